//! Encoding of a message: plain CDR (XCDR version 1) after a header of four bytes, as every ROS 2 middleware sends it.

use crate::definition::Message;
use cdr_encoding::{from_bytes, to_vec};

/// Little-endian CDR, no options.
const LITTLE: [u8; 4] = [0, 1, 0, 0];

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CdrError {
    #[error("{0} bytes, where the head alone has 4")]
    Short(usize),
    #[error("encoding {0:02x} {1:02x}, where 00 00 and 00 01 are plain CDR")]
    Encoding(u8, u8),
    #[error("{0}")]
    Content(String),
}

/// Encodes a message.
pub fn encode<M: Message>(message: &M) -> Result<Vec<u8>, CdrError> {
    let body = to_vec::<M, byteorder::LittleEndian>(message).map_err(|error| CdrError::Content(error.to_string()))?;
    Ok([&LITTLE, &body[..]].concat())
}

/// Decodes a message; additional bytes are padding.
pub fn decode<M: Message>(bytes: &[u8]) -> Result<M, CdrError> {
    let Some((&[first, second, _, _], body)) = bytes.split_first_chunk() else {
        return Err(CdrError::Short(bytes.len()));
    };
    let read = match (first, second) {
        (0, 0) => from_bytes::<M, byteorder::BigEndian>(body),
        (0, 1) => from_bytes::<M, byteorder::LittleEndian>(body),
        _ => return Err(CdrError::Encoding(first, second)),
    };
    read.map(|(message, _)| message).map_err(|error| CdrError::Content(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Time;
    use crate::messages::{Header, Point, Pose, PoseStamped, Quaternion};

    fn message() -> PoseStamped {
        let header = Header { stamp: Time { sec: 1, nanosec: 2 }, frame_id: "map".into() };
        let pose = Pose { position: Point { x: 1.5, y: -2.0, z: 0.0 }, orientation: Quaternion::default() };
        PoseStamped { header, pose }
    }

    /// By the rules of CDR: numbers are aligned to their size behind the header, strings have their length and a terminating
    /// zero.
    const BYTES: [u8; 4 + 72] = [
        0, 1, 0, 0, // little-endian CDR
        1, 0, 0, 0, // sec
        2, 0, 0, 0, // nanosec
        4, 0, 0, 0, b'm', b'a', b'p', 0, // frame_id
        0, 0, 0, 0, 0, 0, 0xf8, 0x3f, // x
        0, 0, 0, 0, 0, 0, 0, 0xc0, // y
        0, 0, 0, 0, 0, 0, 0, 0, // z
        0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, // x, y and z of the rotation
        0, 0, 0, 0, 0, 0, 0xf0, 0x3f, // w
    ];

    #[test]
    fn the_encoding_is_that_of_the_specification() {
        assert_eq!(encode(&message()).unwrap(), BYTES);
        assert_eq!(decode::<PoseStamped>(&BYTES).unwrap(), message());
    }

    #[test]
    fn the_other_byte_order_is_read() {
        let mut bytes = vec![0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4];
        bytes.extend(*b"map\0");
        [1.5_f64, -2.0, 0.0, 0.0, 0.0, 0.0, 1.0].iter().for_each(|x| bytes.extend(x.to_be_bytes()));
        assert_eq!(decode::<PoseStamped>(&bytes).unwrap(), message());
    }

    #[test]
    fn truncated_bytes_and_other_encodings_are_errors() {
        for length in 0..BYTES.len() {
            assert!(decode::<PoseStamped>(&BYTES[..length]).is_err(), "{length}");
        }
        let mut other = BYTES;
        other[1] = 7;
        assert_eq!(decode::<PoseStamped>(&other), Err(CdrError::Encoding(0, 7)));
        let mut long = BYTES;
        long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(matches!(decode::<PoseStamped>(&long), Err(CdrError::Content(_))));
    }
}
