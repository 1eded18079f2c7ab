//! Frames of MAVLink 2: the bytes around a payload.

use crate::bytes::{PAYLOAD, Writer};
use crc::{CRC_16_MCRF4XX, Crc, Digest, NoTable};
use heapless::Vec;

/// The first byte of a frame.
pub(crate) const MARK: u8 = 0xfd;
/// Number of bytes before the payload.
pub(crate) const HEAD: usize = 10;
/// Number of bytes of the checksum.
pub(crate) const CHECK: usize = 2;
/// Number of bytes of a signature.
pub(crate) const SIGNATURE: usize = 13;
/// Number of bytes of the longest frame.
pub const FRAME: usize = HEAD + PAYLOAD + CHECK + SIGNATURE;

static CRC: Crc<u16, NoTable> = Crc::<u16, NoTable>::new(&CRC_16_MCRF4XX);

/// The checksum over the bytes after the mark, and over a byte that identifies the fields of the message.
pub(crate) fn check(covered: &[u8], extra: u8) -> u16 {
    let mut digest: Digest<'_, u16, NoTable> = CRC.digest();
    digest.update(covered);
    digest.update(&[extra]);
    digest.finalize()
}

/// A message that can be sent.
pub trait Outgoing {
    /// Its message id.
    const NUMBER: u32;
    /// The byte of the checksum that identifies its fields.
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

/// Makes numbered frames of one component of one system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sender {
    /// The system id of the vehicle: that of its flight stack.
    pub system: u8,
    /// The component id, for example [`Sender::VISUAL_ODOMETRY`].
    pub component: u8,
    sequence: u8,
}

impl Sender {
    /// `MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY`.
    pub const VISUAL_ODOMETRY: u8 = 197;

    /// A sender whose first frame has the sequence number 0.
    pub const fn new(system: u8, component: u8) -> Self {
        Self { system, component, sequence: 0 }
    }

    /// The frame of a message.
    pub fn frame<M: Outgoing>(&mut self, message: &M) -> Vec<u8, FRAME> {
        let mut payload = Payload::default();
        message.write(&mut payload);
        let sent = payload.0.sent();
        let [n0, n1, n2, _] = M::NUMBER.to_le_bytes();
        // The length of a payload fits in a byte.
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
