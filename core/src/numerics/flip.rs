//! Fault injection: memory in which a bit can be flipped, word by word.

use crate::{Noise, Symmetric, Vector};

/// A number in memory. Of a `bool` or an `Option` only the one meaningful bit is flipped: other values are invalid in Rust.
pub(crate) enum Word<'w> {
    Real(&'w mut f32),
    Short(&'w mut u16),
    Long(&'w mut u32),
    Wide(&'w mut u64),
    /// A count, of which 32 bits are flipped, as on the boards.
    Count(&'w mut usize),
    Truth(&'w mut bool),
    Stream(&'w mut Noise),
}

impl Word<'_> {
    pub(crate) fn bits(&self) -> usize {
        match self {
            Self::Real(_) | Self::Long(_) | Self::Count(_) => 32,
            Self::Short(_) => 16,
            Self::Wide(_) => 64,
            Self::Truth(_) => 1,
            Self::Stream(_) => 128,
        }
    }

    pub(crate) fn flip(self, bit: usize) {
        match self {
            Self::Real(number) => *number = f32::from_bits(number.to_bits() ^ 1 << bit),
            Self::Short(word) => *word ^= 1 << bit,
            Self::Long(word) => *word ^= 1 << bit,
            Self::Wide(word) => *word ^= 1 << bit,
            Self::Count(count) => *count ^= 1 << bit,
            Self::Truth(truth) => *truth = !*truth,
            Self::Stream(noise) => {
                let mut bytes = noise.bytes();
                if let Some(byte) = bytes.get_mut(bit / 8) {
                    *byte ^= 1 << (bit % 8);
                }
                *noise = Noise::from_bytes(bytes);
            }
        }
    }
}

/// A function that is called with every word and the name of its part.
pub(crate) type Each<'e> = dyn FnMut(&'static str, Word<'_>) + 'e;

/// Visits the elements of a covariance.
pub(crate) fn of_symmetric<N: Vector<Scalar = f32>>(what: &'static str, of: &mut Symmetric<N>, each: &mut Each<'_>) {
    for row in 0..N::DIMENSION {
        for column in 0..=row {
            let mut number = of.get(row, column);
            each(what, Word::Real(&mut number));
            if number.to_bits() != of.get(row, column).to_bits() {
                *of = Symmetric::from_fn(|r, c| if (r, c) == (row, column) { number } else { of.get(r, c) });
            }
        }
    }
}

/// Flips one bit of all words that `words` visits, each with the same probability. Returns the name of its part, and the index of
/// the bit in its word.
pub(crate) fn flip_one(mut words: impl FnMut(&mut Each<'_>), draws: &mut Noise) -> (&'static str, usize) {
    let mut bits = 0;
    words(&mut |_, word| bits += word.bits());
    // 24 random bits are sufficient for some hundred thousand bits of state.
    let mut left = Some((draws.uniform::<f64>() * bits as f64) as usize);
    let mut flipped = ("nothing", 0);
    words(&mut |what, word: Word<'_>| {
        if let Some(before) = left {
            if before < word.bits() {
                (left, flipped) = (None, (what, before));
                word.flip(before);
            } else {
                left = Some(before - word.bits());
            }
        }
    });
    flipped
}
