//! The frame of a snapshot: type, length and checksums.

use super::RestoreError;
use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

/// Checksum of the header and of the whole snapshot: CRC-32 as in Ethernet and zip files.
static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);
/// A checksum in progress.
pub(crate) type Check = Digest<'static, u32, Table<1>>;

/// The first four bytes.
const MAGIC: [u8; 4] = *b"SCPH";
/// The version that is written, and the only one that is read.
const VERSION: u16 = 5;
/// Number of words of the head before its checksum.
pub(crate) const WORDS: usize = 8;
/// Number of bytes of the head with its checksum.
pub(crate) const HEAD: usize = 4 * WORDS + 4;
/// Maximum number of bytes passed to a sink, or requested from a source, in a call.
pub(crate) const CHUNK: usize = 64;

/// An empty checksum.
pub(crate) fn check() -> Check {
    CRC.digest()
}

/// The content of a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Content {
    /// A filter of particles and mixtures.
    Mixture,
    /// A filter of one joint map.
    Joint,
    /// The features of a map.
    Map,
    /// The navigator of an underwater vehicle.
    Navigator,
    /// A filter of several joint maps.
    Hypotheses,
}

/// Properties that must be the same in the filter that wrote a snapshot and the one that reads it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shape {
    pub(crate) content: Content,
    /// Number of bytes of a scalar.
    pub(crate) scalar: u8,
    /// Dimensions of the pose's tangent and of a feature's position, and number of numbers of a pose or a measurement.
    pub(crate) dimensions: [u8; 3],
    /// The type of vehicle, a number of the user.
    pub(crate) kind: u32,
}

/// The head of a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Head {
    pub(crate) shape: Shape,
    pub(crate) flags: u8,
    /// Number of bytes of the whole snapshot, including head and checksum.
    pub(crate) len: u32,
    /// Sizes that the memory must have; their meaning depends on the content.
    pub(crate) sizes: [u32; 3],
}

impl Head {
    /// The words of the head before its checksum.
    pub(crate) fn words(&self) -> [[u8; 4]; WORDS] {
        let Self { shape: Shape { content, scalar, dimensions: [k, d, numbers], kind }, flags, len, sizes } = *self;
        let [low, high] = VERSION.to_le_bytes();
        let [first, second, third] = sizes.map(u32::to_le_bytes);
        let about = [low, high, content as u8, scalar];
        [MAGIC, about, kind.to_le_bytes(), [k, d, numbers, flags], len.to_le_bytes(), first, second, third]
    }

    /// The checksum of the head.
    pub(crate) fn check(words: &[[u8; 4]; WORDS]) -> [u8; 4] {
        CRC.checksum(words.as_flattened()).to_le_bytes()
    }

    /// Parses the words of a head and their checksum, for a snapshot of this shape.
    ///
    /// # Errors
    /// The bytes are not a snapshot, are damaged, or are a snapshot of another shape.
    pub(crate) fn parse<E>(words: &[[u8; 4]; WORDS], check: [u8; 4], shape: Shape) -> Result<Self, RestoreError<E>> {
        let &[magic, [low, high, content, scalar], kind, [k, d, numbers, flags], len, first, second, third] = words;
        if magic != MAGIC {
            return Err(RestoreError::Foreign);
        }
        if check != Self::check(words) {
            return Err(RestoreError::Damaged);
        }
        let found = u16::from_le_bytes([low, high]);
        if found != VERSION {
            return Err(RestoreError::Version { found });
        }
        if (content, scalar, [k, d, numbers]) != (shape.content as u8, shape.scalar, shape.dimensions) {
            return Err(RestoreError::Content);
        }
        let found = u32::from_le_bytes(kind);
        if found != shape.kind {
            return Err(RestoreError::Kind { found });
        }
        let sizes = [first, second, third].map(u32::from_le_bytes);
        let head = Self { shape, flags, len: u32::from_le_bytes(len), sizes };
        // A whole number of words, and more than head and checksum.
        let whole = head.len.is_multiple_of(4) && head.body() > 0;
        if whole { Ok(head) } else { Err(RestoreError::Damaged) }
    }

    /// Number of bytes of the whole snapshot.
    pub(crate) fn len(&self) -> usize {
        usize::try_from(self.len).unwrap_or(0)
    }

    /// Number of bytes between the head and the checksum of the whole snapshot.
    pub(crate) fn body(&self) -> usize {
        self.len().saturating_sub(HEAD + 4)
    }

    /// Sets the length, from the number of words of the body.
    pub(crate) fn with_body(self, words: u32) -> Self {
        Self { len: words.saturating_mul(4).saturating_add(HEAD as u32 + 4), ..self }
    }
}

/// Two counts in one word.
pub(crate) fn pair(low: usize, high: usize) -> u32 {
    let half = |count: usize| count.min(usize::from(u16::MAX)) as u32;
    half(low) | half(high) << 16
}

/// The two counts of a word.
pub(crate) fn halves(word: u32) -> [usize; 2] {
    [word & 0xffff, word >> 16].map(|half| half as usize)
}

#[cfg(test)]
mod tests {
    use super::{Content, Head, Shape, halves, pair};
    use crate::RestoreError;

    #[test]
    fn a_head_is_restored_and_every_changed_bit_is_detected() {
        let shape = Shape { content: Content::Joint, scalar: 8, dimensions: [5, 3, 7], kind: 0xdead_beef };
        let head = Head { shape, flags: 3, len: 0, sizes: [1, pair(2, 65_535), 3] }.with_body(10);
        assert_eq!((head.len, head.body(), halves(head.sizes[1])), (80, 40, [2, 65_535]));
        let (words, check) = (head.words(), Head::check(&head.words()));
        assert_eq!(Head::parse::<()>(&words, check, shape), Ok(head));
        for bit in 0..256 {
            let mut damaged = words;
            damaged.as_flattened_mut()[bit / 8] ^= 1 << (bit % 8);
            assert!(Head::parse::<()>(&damaged, check, shape).is_err(), "bit {bit}");
        }
        let of = |shape| Head::parse::<()>(&words, check, shape);
        assert_eq!(of(Shape { kind: 7, ..shape }), Err(RestoreError::Kind { found: 0xdead_beef }));
        for other in [
            Shape { content: Content::Mixture, ..shape },
            Shape { scalar: 4, ..shape },
            Shape { dimensions: [5, 3, 5], ..shape },
        ] {
            assert_eq!(of(other), Err(RestoreError::Content));
        }
    }

    #[test]
    fn another_version_is_distinguished_from_damage() {
        let shape = Shape { content: Content::Joint, scalar: 8, dimensions: [5, 3, 7], kind: 1 };
        let mut words = Head { shape, flags: 0, len: 80, sizes: [0; 3] }.words();
        words[1][0] = 2;
        let check = Head::check(&words);
        assert_eq!(Head::parse::<()>(&words, check, shape), Err(RestoreError::Version { found: 2 }));
        words[0] = *b"GIF8";
        assert_eq!(Head::parse::<()>(&words, check, shape), Err(RestoreError::Foreign));
    }
}
