//! Frames of MAVLink 2: what is around a payload.

use crate::bytes::{PAYLOAD, Writer};
use crc::{CRC_16_MCRF4XX, Crc, Digest, NoTable};
use heapless::Vec;

/// What a frame begins with.
pub(crate) const MARK: u8 = 0xfd;
/// Bytes before the payload.
pub(crate) const HEAD: usize = 10;
/// Bytes of the check after it.
pub(crate) const CHECK: usize = 2;
/// Bytes of a signature after that.
pub(crate) const SIGNATURE: usize = 13;
/// Bytes of the longest frame.
pub const FRAME: usize = HEAD + PAYLOAD + CHECK + SIGNATURE;

static CRC: Crc<u16, NoTable> = Crc::<u16, NoTable>::new(&CRC_16_MCRF4XX);

/// The check over what is after the mark, and a byte that both sides know of the message's fields.
pub(crate) fn check(covered: &[u8], extra: u8) -> u16 {
    let mut digest: Digest<'_, u16, NoTable> = CRC.digest();
    digest.update(covered);
    digest.update(&[extra]);
    digest.finalize()
}

/// A message that is sent.
pub trait Outgoing {
    /// Its number.
    const NUMBER: u32;
    /// The byte of the check that stands for its fields.
    const EXTRA: u8;

    #[doc(hidden)]
    fn write(&self, payload: &mut Payload);
}

/// The payload of a message while it is written.
#[derive(Default)]
pub struct Payload(pub(crate) Writer);

impl core::fmt::Debug for Payload {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Payload").field(&self.0.sent()).finish()
    }
}

/// Numbers frames, as of one component of one system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sender {
    /// The vehicle's number: that of its flight stack.
    pub system: u8,
    /// The component's number: [`Sender::VISUAL_ODOMETRY`], say.
    pub component: u8,
    sequence: u8,
}

impl Sender {
    /// `MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY`.
    pub const VISUAL_ODOMETRY: u8 = 197;

    /// A sender whose first frame has the number 0.
    #[must_use]
    pub const fn new(system: u8, component: u8) -> Self {
        Self { system, component, sequence: 0 }
    }

    /// The frame of a message.
    pub fn frame<M: Outgoing>(&mut self, message: &M) -> Vec<u8, FRAME> {
        let mut payload = Payload::default();
        message.write(&mut payload);
        let sent = payload.0.sent();
        let [n0, n1, n2, _] = M::NUMBER.to_le_bytes();
        // No payload is longer than a byte can say.
        let len = sent.len() as u8;
        let head = [MARK, len, 0, 0, self.sequence, self.system, self.component, n0, n1, n2];
        self.sequence = self.sequence.wrapping_add(1);
        let mut frame = Vec::new();
        let _always = frame.extend_from_slice(&head).and_then(|()| frame.extend_from_slice(sent));
        let check = check(frame.get(1..).unwrap_or(&[]), M::EXTRA);
        let _always = frame.extend_from_slice(&check.to_le_bytes());
        frame
    }
}
