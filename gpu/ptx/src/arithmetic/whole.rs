//! Integers.

use super::function::{Function, predicate};
use Function::{One, Three, Two};

/// The integer in the lowest bits of a register, sign-extended if it is signed.
fn number<const BITS: u32, const SIGNED: bool>(register: u64) -> i128 {
    let unused = i128::BITS - BITS;
    let high = i128::from(register) << unused;
    if SIGNED { high >> unused } else { (high as u128 >> unused) as i128 }
}

/// The `count` lowest bits of a number, as a register holds them.
fn bits(number: i128, count: u32) -> u64 {
    number as u64 & u64::MAX.checked_shr(u64::BITS - count.min(u64::BITS)).unwrap_or(0)
}

/// A function of registers. `n` extracts the number from a register; `BITS` is the number of its bits.
macro_rules! of_registers {
    ($bits:literal, $signed:literal, $kept:expr, |$($register:ident),+| $result:expr) => {
        |$($register: u64),+| {
            #[allow(dead_code, reason = "most results are not about the number of bits")]
            const BITS: u32 = $bits;
            fn n(register: u64) -> i128 {
                number::<$bits, $signed>(register)
            }
            bits($result, $kept)
        }
    };
}

/// The function for a type. The result keeps as many bits as the expression says.
macro_rules! by_kind {
    ($kind:expr, $shape:ident, $($function:tt)+) => {
        match $kind {
            "u16" | "b16" => $shape(of_registers!(16, false, $($function)+)),
            "s16" => $shape(of_registers!(16, true, $($function)+)),
            "u32" | "b32" => $shape(of_registers!(32, false, $($function)+)),
            "s32" => $shape(of_registers!(32, true, $($function)+)),
            "u64" | "b64" => $shape(of_registers!(64, false, $($function)+)),
            "s64" => $shape(of_registers!(64, true, $($function)+)),
            _ => return None,
        }
    };
}

pub(super) fn function(name: &str, kinds: &str) -> Option<Function> {
    if kinds == "pred" {
        return of_predicates(name);
    }
    if let Some((form, kind)) = kinds.split_once('.') {
        return Some(match (name, form) {
            ("mul", "lo") => by_kind!(kind, Two, BITS, |a, b| n(a).wrapping_mul(n(b))),
            ("mul", "hi") => by_kind!(kind, Two, BITS, |a, b| n(a).wrapping_mul(n(b)) >> BITS),
            // The result has twice the width.
            ("mul", "wide") => by_kind!(kind, Two, 2 * BITS, |a, b| n(a).wrapping_mul(n(b))),
            ("mad", "lo") => by_kind!(kind, Three, BITS, |a, b, c| n(a).wrapping_mul(n(b)).wrapping_add(n(c))),
            ("setp", _) => return comparison(form, kind),
            ("shf", "l") if kind == "wrap.b32" => Three(funnel_left),
            _ => return None,
        });
    }
    Some(match name {
        "mov" => by_kind!(kinds, One, BITS, |a| n(a)),
        "add" => by_kind!(kinds, Two, BITS, |a, b| n(a) + n(b)),
        "sub" => by_kind!(kinds, Two, BITS, |a, b| n(a) - n(b)),
        // The result of a division by 0 is not defined: all ones, as on cards.
        "div" => by_kind!(kinds, Two, BITS, |a, b| n(a).checked_div(n(b)).unwrap_or(-1)),
        "rem" => by_kind!(kinds, Two, BITS, |a, b| n(a).checked_rem(n(b)).unwrap_or(n(a))),
        "min" => by_kind!(kinds, Two, BITS, |a, b| n(a).min(n(b))),
        "max" => by_kind!(kinds, Two, BITS, |a, b| n(a).max(n(b))),
        "neg" => by_kind!(kinds, One, BITS, |a| -n(a)),
        "abs" => by_kind!(kinds, One, BITS, |a| n(a).abs()),
        "not" => by_kind!(kinds, One, BITS, |a| !n(a)),
        "and" => by_kind!(kinds, Two, BITS, |a, b| n(a) & n(b)),
        "or" => by_kind!(kinds, Two, BITS, |a, b| n(a) | n(b)),
        "xor" => by_kind!(kinds, Two, BITS, |a, b| n(a) ^ n(b)),
        // A shift by the width or more leaves zeros, or copies of the sign of a signed number.
        "shl" => by_kind!(kinds, Two, BITS, |a, places| n(a) << (places as u32).min(BITS)),
        "shr" => by_kind!(kinds, Two, BITS, |a, places| n(a) >> (places as u32).min(BITS)),
        "selp" => by_kind!(kinds, Three, BITS, |a, b, first| if first != 0 { n(a) } else { n(b) }),
        "popc" => by_kind!(kinds, One, BITS, |a| bits(n(a), BITS).count_ones().into()),
        "bfe" if kinds == "u32" => Three(|a, from, count| field(a & 0xffff_ffff, from, count)),
        "bfe" if kinds == "u64" => Three(field),
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
        _ => return None,
    })
}

fn comparison(name: &str, kind: &str) -> Option<Function> {
    Some(match name {
        "eq" => by_kind!(kind, Two, 1, |a, b| i128::from(n(a) == n(b))),
        "ne" => by_kind!(kind, Two, 1, |a, b| i128::from(n(a) != n(b))),
        "lt" => by_kind!(kind, Two, 1, |a, b| i128::from(n(a) < n(b))),
        "le" => by_kind!(kind, Two, 1, |a, b| i128::from(n(a) <= n(b))),
        "gt" => by_kind!(kind, Two, 1, |a, b| i128::from(n(a) > n(b))),
        "ge" => by_kind!(kind, Two, 1, |a, b| i128::from(n(a) >= n(b))),
        _ => return None,
    })
}

pub(super) fn conversion(to: &str, from: &str) -> Option<Function> {
    Some(One(match (to, from) {
        ("u16", "u32" | "u64") | ("u32" | "u64", "u16") => |a| a & 0xffff,
        ("u32", "u64") | ("u64", "u32") => |a| a & 0xffff_ffff,
        _ => return None,
    }))
}

/// `count` bits from bit `from` on, unsigned.
fn field(a: u64, from: u64, count: u64) -> u64 {
    let [from, count] = [from, count].map(|x| (x & 0xff) as u32);
    bits(a.checked_shr(from).unwrap_or(0).into(), count)
}

/// The upper word of both, shifted to the left.
fn funnel_left(low: u64, high: u64, places: u64) -> u64 {
    let both = (high & 0xffff_ffff) << 32 | low & 0xffff_ffff;
    (both << (places & 31)) >> 32
}

/// Selects four of the eight bytes of both words. A selector with bit 3 set replaces its byte by eight copies of the byte's sign.
fn permute(a: u64, b: u64, selectors: u64) -> u64 {
    let both = (b & 0xffff_ffff) << 32 | a & 0xffff_ffff;
    (0..4).fold(0, |made, place| {
        let selector = selectors >> (4 * place) & 0xf;
        let byte = both >> (8 * (selector & 7)) & 0xff;
        let byte = if selector & 8 == 0 { byte } else { 0xff * (byte >> 7) };
        made | byte << (8 * place)
    })
}
