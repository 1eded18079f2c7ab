//! Messages as bytes, so that those of any type are sent and received in one way.

use serde::de::{SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// The head of little-endian CDR, which stands before the bytes of a message in files.
pub const HEAD: [u8; 4] = [0, 1, 0, 0];

/// The bytes of a message in little-endian CDR, as every computer that ROS 2 supports sends them, with their head.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Raw(pub Vec<u8>);

impl Serialize for Raw {
    /// The middleware writes the head itself.
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
        // The end of the bytes is the only error that there is.
        while let Ok(Some(byte)) = rest.next_element::<u8>() {
            bytes.push(byte);
        }
        Ok(Raw(bytes))
    }
}
