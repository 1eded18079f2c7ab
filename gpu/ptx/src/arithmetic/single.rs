//! Single precision according to IEEE 754, computed by the host.

use super::function::{Function, predicate};
use Function::{One, Three, Two};

fn of(register: u64) -> f32 {
    f32::from_bits(register as u32)
}

fn bits(x: f32) -> u64 {
    x.to_bits().into()
}

/// The function of a name, and of the part of the mnemonic between the name and `f32`.
pub(super) fn function(name: &str, form: &str) -> Option<Function> {
    Some(match (name, form) {
        ("mov", "") => One(|a| a & 0xffff_ffff),
        ("selp", "") => Three(|a, b, first| (if first != 0 { a } else { b }) & 0xffff_ffff),
        ("add", "rn") => Two(|a, b| bits(of(a) + of(b))),
        ("sub", "rn") => Two(|a, b| bits(of(a) - of(b))),
        ("mul", "rn") => Two(|a, b| bits(of(a) * of(b))),
        ("div", "rn") => Two(|a, b| bits(of(a) / of(b))),
        ("rcp", "rn") => One(|a| bits(1.0 / of(a))),
        ("abs", "") => One(|a| bits(of(a).abs())),
        ("neg", "") => One(|a| bits(-of(a))),
        // The sign of the first operand on the second.
        ("copysign", "") => Two(|a, b| bits(of(b).copysign(of(a)))),
        ("min", "") => Two(least),
        // The negative of the minimum of the negatives.
        ("max", "") => Two(|a, b| least(a ^ SIGN, b ^ SIGN) ^ SIGN),
        ("setp", comparison) => return compare(comparison),
        ("cvt", _) => return conversion(&format!("{form}.f32")),
        _ => return None,
    })
}

/// The sign bit.
const SIGN: u64 = 1 << 31;

/// The lesser of both. -0 is less than 0, and a number is less than NaN.
fn least(a: u64, b: u64) -> u64 {
    let (x, y) = (of(a), of(b));
    let first = y.is_nan() || x < y || x == y && x.is_sign_negative();
    (if first { a } else { b }) & 0xffff_ffff
}

/// The comparison of a name. A `u` at the end means: or one of them is NaN.
fn compare(name: &str) -> Option<Function> {
    Some(Two(match name {
        "eq" => |a, b| predicate(of(a) == of(b)),
        "ne" => |a, b| predicate(of(a) < of(b) || of(a) > of(b)),
        "lt" => |a, b| predicate(of(a) < of(b)),
        "le" => |a, b| predicate(of(a) <= of(b)),
        "gt" => |a, b| predicate(of(a) > of(b)),
        "ge" => |a, b| predicate(of(a) >= of(b)),
        "equ" => |a, b| predicate(!(of(a) < of(b) || of(a) > of(b))),
        "neu" => |a, b| predicate(of(a) != of(b)),
        "ltu" => |a, b| predicate(!(of(a) >= of(b))),
        "leu" => |a, b| predicate(!(of(a) > of(b))),
        "gtu" => |a, b| predicate(!(of(a) <= of(b))),
        "geu" => |a, b| predicate(!(of(a) < of(b))),
        "num" => |a, b| predicate(!of(a).is_nan() && !of(b).is_nan()),
        "nan" => |a, b| predicate(of(a).is_nan() || of(b).is_nan()),
        _ => return None,
    }))
}

/// Conversion from an integer, rounded to nearest, or to an integer, rounded towards 0, saturated, and 0 for NaN.
pub(super) fn conversion(kinds: &str) -> Option<Function> {
    Some(One(match kinds {
        "rn.f32.s32" => |a| bits(a as i32 as f32),
        "rn.f32.u32" => |a| bits(a as u32 as f32),
        "rn.f32.u64" => |a| bits(a as f32),
        "rzi.s32.f32" => |a| u64::from(of(a) as i32 as u32),
        _ => return None,
    }))
}
