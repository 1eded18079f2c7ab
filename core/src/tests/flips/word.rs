//! A piece of memory of which a bit can flip.

use crate::{Noise, Symmetric, Vector};

/// A number in memory. Of a truth value and of what is there or not only the one bit that means something: no other is a value in Rust.
pub(crate) enum Word<'w> {
    Real(&'w mut f32),
    Short(&'w mut u16),
    Long(&'w mut u32),
    /// A count, of the 32 bits that it has on the boards.
    Count(&'w mut usize),
    Truth(&'w mut bool),
    Stream(&'w mut Noise),
}

impl Word<'_> {
    pub(crate) fn bits(&self) -> usize {
        match self {
            Self::Real(_) | Self::Long(_) | Self::Count(_) => 32,
            Self::Short(_) => 16,
            Self::Truth(_) => 1,
            Self::Stream(_) => 128,
        }
    }

    pub(crate) fn flip(self, bit: usize) {
        match self {
            Self::Real(number) => *number = f32::from_bits(number.to_bits() ^ 1 << bit),
            Self::Short(word) => *word ^= 1 << bit,
            Self::Long(word) => *word ^= 1 << bit,
            Self::Count(count) => *count ^= 1 << bit,
            Self::Truth(truth) => *truth = !*truth,
            Self::Stream(noise) => {
                let mut bytes = noise.bytes();
                bytes[bit / 8] ^= 1 << (bit % 8);
                *noise = Noise::from_bytes(bytes);
            }
        }
    }
}

/// Takes every word, with what it is part of.
pub(crate) type Each<'e> = dyn FnMut(&'static str, Word<'_>) + 'e;

/// The numbers of a covariance.
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
