//! Whole numbers.

use super::function::{Function, predicate};
use Function::{One, Three, Two};

/// A whole number in the lowest bits of a register.
pub(super) trait Whole: Copy + Ord {
    /// Number of its bits.
    const BITS: u32;
    fn of(register: u64) -> Self;
    fn bits(self) -> u64;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    /// The upper half of the product.
    fn times_high(self, other: Self) -> Self;
    fn over(self, other: Self) -> Option<Self>;
    fn modulo(self, other: Self) -> Option<Self>;
    /// For fewer places than it has bits.
    fn left(self, places: u32) -> Self;
    fn right(self, places: u32) -> Self;
    /// In 64 bits, with its sign.
    fn widened(self) -> u64;
}

macro_rules! whole {
    ($($number:ty, $unsigned:ty, $wider:ty);*) => { $(
        impl Whole for $number {
            const BITS: u32 = <$number>::BITS;
            fn of(register: u64) -> Self {
                register as $number
            }
            fn bits(self) -> u64 {
                u64::from(self as $unsigned)
            }
            fn plus(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
            fn minus(self, other: Self) -> Self {
                self.wrapping_sub(other)
            }
            fn times(self, other: Self) -> Self {
                self.wrapping_mul(other)
            }
            fn times_high(self, other: Self) -> Self {
                ((self as $wider * other as $wider) >> <$number>::BITS) as $number
            }
            fn over(self, other: Self) -> Option<Self> {
                self.checked_div(other)
            }
            fn modulo(self, other: Self) -> Option<Self> {
                self.checked_rem(other)
            }
            fn left(self, places: u32) -> Self {
                self << places
            }
            fn right(self, places: u32) -> Self {
                self >> places
            }
            fn widened(self) -> u64 {
                self as u64
            }
        }
    )* };
}

whole!(
    u8, u8, u16; i8, u8, i16; u16, u16, u32; i16, u16, i32; u32, u32, u64; i32, u32, i64; u64, u64, u128; i64, u64, i128
);

/// A function for the type of that name.
macro_rules! by_kind {
    ($kind:expr, $shape:ident, $function:ident) => {
        match $kind {
            "u16" | "b16" => $shape($function::<u16>),
            "s16" => $shape($function::<i16>),
            "u32" | "b32" => $shape($function::<u32>),
            "s32" => $shape($function::<i32>),
            "u64" | "b64" => $shape($function::<u64>),
            "s64" => $shape($function::<i64>),
            _ => return None,
        }
    };
}

/// The function of a name and its kinds.
pub(super) fn function(name: &str, kinds: &str) -> Option<Function> {
    if kinds == "pred" {
        return of_predicates(name);
    }
    if let Some((form, kind)) = kinds.split_once('.') {
        return Some(match (name, form) {
            ("mul", "lo") => by_kind!(kind, Two, multiply),
            ("mul", "hi") => by_kind!(kind, Two, multiply_high),
            ("mul", "wide") => by_kind!(kind, Two, multiply_wide),
            ("mad", "lo") => by_kind!(kind, Three, multiply_add),
            ("mad", "wide") => by_kind!(kind, Three, multiply_add_wide),
            ("setp", _) => return comparison(form, kind),
            ("shf", "l") if kind == "wrap.b32" => Three(funnel_left),
            ("shf", "r") if kind == "wrap.b32" => Three(funnel_right),
            _ => return None,
        });
    }
    Some(match name {
        "mov" => by_kind!(kinds, One, same),
        "add" => by_kind!(kinds, Two, add),
        "sub" => by_kind!(kinds, Two, subtract),
        "div" => by_kind!(kinds, Two, divide),
        "rem" => by_kind!(kinds, Two, remainder),
        "min" => by_kind!(kinds, Two, least),
        "max" => by_kind!(kinds, Two, greatest),
        "neg" => by_kind!(kinds, One, negative),
        "not" => by_kind!(kinds, One, inverse),
        "and" => by_kind!(kinds, Two, and),
        "or" => by_kind!(kinds, Two, or),
        "xor" => by_kind!(kinds, Two, exclusive_or),
        "shl" => by_kind!(kinds, Two, shift_left),
        "shr" => by_kind!(kinds, Two, shift_right),
        "selp" => by_kind!(kinds, Three, choose),
        "popc" => by_kind!(kinds, One, ones),
        "clz" => by_kind!(kinds, One, zeros_ahead),
        "bfe" if kinds == "u32" => Three(field::<u32>),
        "bfe" if kinds == "u64" => Three(field::<u64>),
        "prmt" if kinds == "b32" => Three(permute),
        _ => return None,
    })
}

fn of_predicates(name: &str) -> Option<Function> {
    Some(match name {
        "mov" => One(|a| predicate(a != 0)),
        "not" => One(|a| predicate(a == 0)),
        "and" => Two(|a, b| a & b),
        "or" => Two(|a, b| a | b),
        "xor" => Two(|a, b| a ^ b),
        _ => return None,
    })
}

fn comparison(name: &str, kind: &str) -> Option<Function> {
    Some(match name {
        "eq" => by_kind!(kind, Two, equal),
        "ne" => by_kind!(kind, Two, unequal),
        "lt" | "lo" => by_kind!(kind, Two, less),
        "le" | "ls" => by_kind!(kind, Two, less_or_equal),
        "gt" | "hi" => by_kind!(kind, Two, greater),
        "ge" | "hs" => by_kind!(kind, Two, greater_or_equal),
        _ => return None,
    })
}

/// From one type to another: the sign of the first goes on.
pub(super) fn conversion(to: &str, from: &str) -> Option<Function> {
    macro_rules! to {
        ($from:ty) => {
            match to {
                "u8" | "s8" => convert::<u8, $from>,
                "u16" | "s16" => convert::<u16, $from>,
                "u32" | "s32" => convert::<u32, $from>,
                "u64" | "s64" => convert::<u64, $from>,
                _ => return None,
            }
        };
    }
    Some(One(match from {
        "u8" => to!(u8),
        "s8" => to!(i8),
        "u16" => to!(u16),
        "s16" => to!(i16),
        "u32" => to!(u32),
        "s32" => to!(i32),
        "u64" => to!(u64),
        "s64" => to!(i64),
        _ => return None,
    }))
}

fn convert<T: Whole, F: Whole>(a: u64) -> u64 {
    T::of(F::of(a).widened()).bits()
}

pub(super) fn same<W: Whole>(a: u64) -> u64 {
    W::of(a).bits()
}

fn add<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a).plus(W::of(b)).bits()
}

fn subtract<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a).minus(W::of(b)).bits()
}

fn multiply<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a).times(W::of(b)).bits()
}

fn multiply_high<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a).times_high(W::of(b)).bits()
}

/// In a register of twice the width.
fn multiply_wide<W: Whole>(a: u64, b: u64) -> u64 {
    let product = W::of(a).widened().wrapping_mul(W::of(b).widened());
    if 2 * W::BITS < u64::BITS { product & ((1 << (2 * W::BITS)) - 1) } else { product }
}

fn multiply_add<W: Whole>(a: u64, b: u64, c: u64) -> u64 {
    W::of(a).times(W::of(b)).plus(W::of(c)).bits()
}

fn multiply_add_wide<W: Whole>(a: u64, b: u64, c: u64) -> u64 {
    let sum = multiply_wide::<W>(a, b).wrapping_add(c);
    if 2 * W::BITS < u64::BITS { sum & ((1 << (2 * W::BITS)) - 1) } else { sum }
}

/// What a division by 0 gives is the device's business: all ones, as cards do.
fn divide<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a).over(W::of(b)).unwrap_or(W::of(u64::MAX)).bits()
}

fn remainder<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a).modulo(W::of(b)).unwrap_or(W::of(a)).bits()
}

fn least<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a).min(W::of(b)).bits()
}

fn greatest<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a).max(W::of(b)).bits()
}

fn negative<W: Whole>(a: u64) -> u64 {
    W::of(0).minus(W::of(a)).bits()
}

fn inverse<W: Whole>(a: u64) -> u64 {
    W::of(!a).bits()
}

fn and<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a & b).bits()
}

fn or<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a | b).bits()
}

fn exclusive_or<W: Whole>(a: u64, b: u64) -> u64 {
    W::of(a ^ b).bits()
}

fn shift_left<W: Whole>(a: u64, places: u64) -> u64 {
    let places = places as u32;
    if places < W::BITS { W::of(a).left(places).bits() } else { 0 }
}

/// A number with a sign is filled with it.
fn shift_right<W: Whole>(a: u64, places: u64) -> u64 {
    let places = places as u32;
    if places < W::BITS { W::of(a).right(places).bits() } else { W::of(a).right(W::BITS - 1).right(1).bits() }
}

fn choose<W: Whole>(a: u64, b: u64, first: u64) -> u64 {
    W::of(if first != 0 { a } else { b }).bits()
}

fn ones<W: Whole>(a: u64) -> u64 {
    W::of(a).bits().count_ones().into()
}

fn zeros_ahead<W: Whole>(a: u64) -> u64 {
    (W::of(a).bits().leading_zeros() - (u64::BITS - W::BITS)).into()
}

fn equal<W: Whole>(a: u64, b: u64) -> u64 {
    predicate(W::of(a) == W::of(b))
}

fn unequal<W: Whole>(a: u64, b: u64) -> u64 {
    predicate(W::of(a) != W::of(b))
}

fn less<W: Whole>(a: u64, b: u64) -> u64 {
    predicate(W::of(a) < W::of(b))
}

fn less_or_equal<W: Whole>(a: u64, b: u64) -> u64 {
    predicate(W::of(a) <= W::of(b))
}

fn greater<W: Whole>(a: u64, b: u64) -> u64 {
    predicate(W::of(a) > W::of(b))
}

fn greater_or_equal<W: Whole>(a: u64, b: u64) -> u64 {
    predicate(W::of(a) >= W::of(b))
}

/// So many bits from a place on, without sign.
fn field<W: Whole>(a: u64, from: u64, bits: u64) -> u64 {
    let [from, bits] = [from, bits].map(|x| (x & 0xff) as u32);
    let shifted = W::of(a).bits().checked_shr(from).unwrap_or(0);
    if bits < u64::BITS { shifted & ((1 << bits) - 1) } else { shifted }
}

/// The upper word of both, shifted to the left.
fn funnel_left(low: u64, high: u64, places: u64) -> u64 {
    let both = (high & 0xffff_ffff) << 32 | low & 0xffff_ffff;
    (both << (places & 31)) >> 32
}

/// The lower word of both, shifted to the right.
fn funnel_right(low: u64, high: u64, places: u64) -> u64 {
    let both = (high & 0xffff_ffff) << 32 | low & 0xffff_ffff;
    both >> (places & 31) & 0xffff_ffff
}

/// Four bytes of the eight of both words; one that is told to is but its sign, eight times.
fn permute(a: u64, b: u64, selectors: u64) -> u64 {
    let both = (b & 0xffff_ffff) << 32 | a & 0xffff_ffff;
    (0..4).fold(0, |made, place| {
        let selector = selectors >> (4 * place) & 0xf;
        let byte = both >> (8 * (selector & 7)) & 0xff;
        let byte = if selector & 8 == 0 { byte } else { 0xff * (byte >> 7) };
        made | byte << (8 * place)
    })
}
