//! Sequences of numbers in the order of a stream.

/// One number or a fixed sequence of numbers.
pub trait Numbers: Copy {
    /// Number of numbers.
    const COUNT: usize;
    /// All zero.
    const ZERO: Self;

    /// Passes the numbers to `sink` one after the other.
    fn put(&self, sink: &mut impl FnMut(f64));

    /// Constructs it from the next numbers of a source; `None` if there are too few.
    fn take(source: &mut impl FnMut() -> Option<f64>) -> Option<Self>;
}

impl Numbers for f64 {
    const COUNT: usize = 1;
    const ZERO: Self = 0.0;

    fn put(&self, sink: &mut impl FnMut(f64)) {
        sink(*self);
    }

    fn take(source: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        source()
    }
}

impl<N: Numbers, const LEN: usize> Numbers for [N; LEN] {
    const COUNT: usize = LEN * N::COUNT;
    const ZERO: Self = [N::ZERO; LEN];

    fn put(&self, sink: &mut impl FnMut(f64)) {
        self.iter().for_each(|numbers| numbers.put(sink));
    }

    fn take(source: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        let mut all = Self::ZERO;
        for numbers in &mut all {
            *numbers = N::take(source)?;
        }
        Some(all)
    }
}

/// Defines a structure of numbers, in the order of its fields.
macro_rules! numbers {
    ($(#[$meta:meta])* $name:ident { $($(#[$doc:meta])* $field:ident: $type:ty,)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl $crate::Numbers for $name {
            const COUNT: usize = 0 $(+ <$type as $crate::Numbers>::COUNT)*;
            const ZERO: Self = Self { $($field: <$type as $crate::Numbers>::ZERO,)* };

            fn put(&self, sink: &mut impl FnMut(f64)) {
                $($crate::Numbers::put(&self.$field, sink);)*
            }

            fn take(source: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
                Some(Self { $($field: $crate::Numbers::take(source)?,)* })
            }
        }
    };
}
pub(crate) use numbers;

#[cfg(test)]
mod tests {
    use super::Numbers;
    use std::vec::Vec;

    numbers! {
        /// One field of each kind.
        Some5 {
            /// One.
            one: f64,
            /// Four.
            four: [[f64; 2]; 2],
        }
    }

    #[test]
    fn numbers_keep_their_order_and_missing_ones_are_detected() {
        let five = Some5 { one: 1.0, four: [[2.0, 3.0], [4.0, 5.0]] };
        let mut all = Vec::new();
        five.put(&mut |number| all.push(number));
        assert_eq!((Some5::COUNT, &all[..]), (5, &[1.0, 2.0, 3.0, 4.0, 5.0][..]));
        let mut source = all.iter().copied();
        assert_eq!(Some5::take(&mut || source.next()), Some(five));
        let mut short = all.iter().copied().take(4);
        assert_eq!(Some5::take(&mut || short.next()), None);
    }
}
