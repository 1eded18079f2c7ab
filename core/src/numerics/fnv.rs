//! A hash of numbers.

use crate::Real;

/// 64-bit FNV-1a over 32-bit words.
pub(crate) struct Fnv(u64);

impl Fnv {
    /// The hash of no words.
    pub(crate) const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    /// The hash of all words so far.
    pub(crate) fn value(&self) -> u64 {
        self.0
    }

    pub(crate) fn take(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    pub(crate) fn take_scalar<T: Real>(&mut self, x: T) {
        let bits = x.bits();
        self.take(bits as u32);
        self.take((bits >> 32) as u32);
    }
}
