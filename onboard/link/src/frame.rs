//! The format of a frame.

use crate::report::Refused;
use cobs::CobsEncoder;
use core::num::NonZeroU16;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// The version of the format.
pub const VERSION: u8 = 1;
/// Bytes before the content: version, kind, session, number, token.
const FRONT: usize = 10;
/// Number of bytes of the checksum.
const CHECK: usize = 4;
/// Number of bytes of a frame besides its content, before byte stuffing.
pub const OVERHEAD: usize = FRONT + CHECK;

/// Without a table: the line is slower than the computation, and flash is scarce.
static CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Maximum number of bytes on the line for a frame with this number of bytes of content, including the zeros around it.
#[must_use]
pub const fn line_bytes(content: usize) -> usize {
    cobs::max_encoding_length(content + OVERHEAD) + 2
}

/// Identifies a request for an answer; the answer contains it too.
pub type Token = NonZeroU16;

/// Type of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameKind {
    /// The head of a stream, number 0 of the session that it opens.
    Head,
    /// A record of the stream, or its end.
    Record,
    /// A request for an answer, without content. Its number has no meaning.
    Ask,
    /// An [`Answer`](crate::Answer), numbered among the answers of the session.
    Answer,
}

impl FrameKind {
    const fn code(self) -> u8 {
        match self {
            Self::Head => 1,
            Self::Record => 2,
            Self::Ask => 3,
            Self::Answer => 4,
        }
    }

    const fn of(code: u8) -> Option<Self> {
        match code {
            1 => Some(Self::Head),
            2 => Some(Self::Record),
            3 => Some(Self::Ask),
            4 => Some(Self::Answer),
            _ => None,
        }
    }
}

/// A frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Its type.
    pub kind: FrameKind,
    /// The session: a different number for each stream.
    pub session: u16,
    /// Its number in the session, from 0.
    pub number: u32,
    /// The token if an answer is requested; of an answer, the token of its request.
    pub token: Option<Token>,
    /// Its content.
    pub content: &'a [u8],
}

impl<'a> Frame<'a> {
    /// Encodes the frame for the line, with a zero before and behind it; `None` if the buffer is too small.
    pub(crate) fn encode<'b>(&self, into: &'b mut [u8]) -> Option<&'b [u8]> {
        let [version, kind] = [VERSION, self.kind.code()];
        let [s0, s1] = self.session.to_le_bytes();
        let [n0, n1, n2, n3] = self.number.to_le_bytes();
        let [t0, t1] = self.token.map_or(0, Token::get).to_le_bytes();
        let front: [u8; FRONT] = [version, kind, s0, s1, n0, n1, n2, n3, t0, t1];
        let mut check = CRC.digest();
        check.update(&front);
        check.update(self.content);
        let (before, stuffed) = into.split_first_mut()?;
        *before = 0;
        let mut encoder = CobsEncoder::new(stuffed);
        encoder.push(&front).ok()?;
        encoder.push(self.content).ok()?;
        encoder.push(&check.finalize().to_le_bytes()).ok()?;
        let len = encoder.finalize();
        *into.get_mut(1 + len)? = 0;
        into.get(..len + 2)
    }

    /// Decodes a frame after removal of the byte stuffing.
    ///
    /// # Errors
    /// The frame is damaged or unknown.
    pub(crate) fn decode(bytes: &'a [u8]) -> Result<Self, Refused> {
        let (checked, check) = bytes.split_last_chunk::<CHECK>().ok_or(Refused::Damaged)?;
        if CRC.checksum(checked) != u32::from_le_bytes(*check) {
            return Err(Refused::Damaged);
        }
        let (front, content) = checked.split_first_chunk::<FRONT>().ok_or(Refused::Unknown)?;
        let &[version, kind, s0, s1, n0, n1, n2, n3, t0, t1] = front;
        let kind = FrameKind::of(kind).filter(|_| version == VERSION).ok_or(Refused::Unknown)?;
        Ok(Self {
            kind,
            session: u16::from_le_bytes([s0, s1]),
            number: u32::from_le_bytes([n0, n1, n2, n3]),
            token: Token::new(u16::from_le_bytes([t0, t1])),
            content,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    /// Contents that are critical for byte stuffing: zeros, runs of about 254 bytes, and pseudo-random bytes.
    fn contents() -> Vec<Vec<u8>> {
        let patterns: [fn(usize) -> u8; 4] = [|_| 0, |_| 7, |k| (k % 255 != 0).into(), |k| (k * k + 3 * k) as u8];
        let lengths = (0..20).chain(230..270).chain(490..530).chain([1000]);
        lengths.flat_map(|len| patterns.map(|pattern| (0..len).map(pattern).collect())).collect()
    }

    #[test]
    fn a_frame_is_decoded_as_it_was_encoded() {
        for content in contents() {
            let frame =
                Frame { kind: FrameKind::Record, session: 0x1234, number: 9, token: Token::new(3), content: &content };
            let mut line = vec![0xaa; line_bytes(content.len())];
            let sent = frame.encode(&mut line).unwrap();
            assert!(sent.len() <= line_bytes(content.len()));
            let [0, stuffed @ .., 0] = sent else { panic!("no zeros around {sent:?}") };
            assert!(!stuffed.contains(&0));
            let mut bytes = vec![0; content.len() + OVERHEAD];
            let len = cobs::decode(stuffed, &mut bytes).unwrap().frame_size();
            assert_eq!(Frame::decode(&bytes[..len]), Ok(frame), "{} bytes", content.len());
        }
    }

    #[test]
    fn the_layout_is_that_of_the_document() {
        let frame =
            Frame { kind: FrameKind::Ask, session: 0x0102, number: 0x0304_0506, token: Token::new(7), content: &[] };
        let mut line = [0; line_bytes(0)];
        let sent = frame.encode(&mut line).unwrap();
        // The checksum by Python: zlib.crc32(bytes([1, 3, 2, 1, 6, 5, 4, 3, 7, 0])).
        let [c0, c1, c2, c3] = 0x0d4b_e0e0_u32.to_le_bytes();
        assert_eq!(sent, [0, 10, 1, 3, 2, 1, 6, 5, 4, 3, 7, 5, c0, c1, c2, c3, 0]);
    }

    #[test]
    fn nothing_is_sent_without_room() {
        for content in contents() {
            let frame = Frame { kind: FrameKind::Record, session: 1, number: 1, token: None, content: &content };
            let whole = frame.encode(&mut vec![0; line_bytes(content.len())]).unwrap().len();
            assert!((0..whole).all(|room| frame.encode(&mut vec![0; room]).is_none()), "{} bytes", content.len());
        }
    }

    #[test]
    fn other_versions_and_types_are_distinguished_from_damage() {
        let sealed = |front: [u8; FRONT]| {
            let check = CRC.checksum(&front).to_le_bytes();
            [&front[..], &check[..]].concat()
        };
        let good = [VERSION, 2, 0, 0, 0, 0, 0, 0, 0, 0];
        assert!(Frame::decode(&sealed(good)).is_ok());
        for (place, value) in [(0, 0), (0, 2), (1, 0), (1, 5)] {
            let mut front = good;
            front[place] = value;
            assert_eq!(Frame::decode(&sealed(front)), Err(Refused::Unknown));
        }
        assert_eq!(Frame::decode(&[]), Err(Refused::Damaged));
        assert_eq!(Frame::decode(&CRC.checksum(&[]).to_le_bytes()), Err(Refused::Unknown));
    }
}
