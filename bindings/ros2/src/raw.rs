//! Messages as bytes, so that messages of all types are sent and received in the same way.

use serde::de::{SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Header of little-endian CDR, which precedes the bytes of a message in files.
pub const HEAD: [u8; 4] = [0, 1, 0, 0];

/// The bytes of a message in little-endian CDR, which all platforms of ROS 2 send, with the header.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Raw(pub Vec<u8>);

impl Serialize for Raw {
    /// Omits the header, which the middleware writes.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let body = self.0.get(HEAD.len()..).unwrap_or_default();
        let mut tuple = serializer.serialize_tuple(body.len())?;
        body.iter().try_for_each(|byte| tuple.serialize_element(byte))?;
        tuple.end()
    }
}

impl<'de> Deserialize<'de> for Raw {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(usize::MAX, Bytes)
    }
}

struct Bytes;

impl<'de> Visitor<'de> for Bytes {
    type Value = Raw;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the bytes of a message")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut rest: A) -> Result<Raw, A::Error> {
        let mut bytes = HEAD.to_vec();
        // The end of the bytes is the only possible error.
        while let Ok(Some(byte)) = rest.next_element::<u8>() {
            bytes.push(byte);
        }
        Ok(Raw(bytes))
    }
}
