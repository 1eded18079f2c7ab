//! What arithmetic instructions compute.
//!
//! A register is a `u64` whose lowest bits are used: an instruction reads as many bits as its type has, and writes zeros above
//! them. Single precision is that of IEEE 754, computed by the host.

use std::cmp::Ordering;

/// A type: its bits, and how they are read.
#[derive(Debug, Clone, Copy)]
struct Kind {
    bits: u32,
    signed: bool,
    single: bool,
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        let bits = if name == "pred" { 1 } else { name.get(1..)?.parse().ok()? };
        let (signed, single) = (name.starts_with('s'), name == "f32");
        (matches!(bits, 1 | 16 | 32 | 64) && (single || !name.starts_with('f'))).then_some(Self {
            bits,
            signed,
            single,
        })
    }

    /// The number in the lowest bits of a register; of single precision, its bits.
    fn read(self, register: u64) -> i128 {
        let unused = u64::BITS - self.bits;
        let high = register << unused;
        if self.signed { i128::from(high.cast_signed() >> unused) } else { i128::from(high >> unused) }
    }
}

type Function = fn(i128, i128, i128) -> i128;

/// A function of up to three registers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Operation {
    function: Function,
    of: Kind,
    /// Bits of the result.
    bits: u32,
    pub(crate) operands: usize,
    /// The orders for which it holds, if it is a comparison.
    holds: &'static [Option<Ordering>],
}

impl Operation {
    pub(crate) fn value(&self, [a, b, c]: [u64; 3]) -> u64 {
        let [a, b, c] = [a, b, c].map(|register| self.of.read(register));
        if !self.holds.is_empty() {
            let order = if self.of.single { single(a).partial_cmp(&single(b)) } else { Some(a.cmp(&b)) };
            return self.holds.contains(&order).into();
        }
        (self.function)(a, b, c) as u64 & u64::MAX >> (u64::BITS - self.bits)
    }

    /// The operation of a mnemonic, if it is known.
    pub(crate) fn of(mnemonic: &str) -> Option<Self> {
        let (name, kind) = mnemonic.rsplit_once('.')?;
        let of = Kind::of(kind)?;
        let with = |operands, function, bits| Some(Self { function, of, bits, operands, holds: &[] });
        if let Some(to) = name.strip_prefix("cvt.") {
            return match (to, of.single) {
                ("rzi.s32", true) => with(1, |a, _, _| (single(a) as i32).into(), 32),
                ("rn.f32", false) => with(1, |a, _, _| bits(a as f32), 32),
                (_, false) => with(1, |a, _, _| a, Kind::of(to).filter(|to| !to.single)?.bits),
                _ => None,
            };
        }
        if let Some(comparison) = name.strip_prefix("setp.") {
            let holds = holds(comparison, of.single)?;
            return Some(Self { function: |_, _, _| 0, of, bits: 1, operands: 2, holds });
        }
        let (operands, function) = function(name, of)?;
        with(operands, function, if name == "mul.wide" { 2 * of.bits } else { of.bits })
    }
}

/// The number of operands of a name, and its function.
fn function(name: &str, kind: Kind) -> Option<(usize, Function)> {
    Some(match (name, kind.single) {
        ("mov", _) => (1, |a, _, _| a),
        ("selp", _) => (3, |a, b, first| if first != 0 { a } else { b }),
        // All address spaces share one range of addresses.
        ("cvta.to.local" | "cvta.local" | "cvta.to.global" | "cvta.global", false) => (1, |a, _, _| a),
        ("neg", false) => (1, |a, _, _| -a),
        ("abs", false) => (1, |a, _, _| a.abs()),
        ("not", false) => (1, |a, _, _| !a),
        ("popc", false) => (1, |a, _, _| a.count_ones().into()),
        ("add", false) => (2, |a, b, _| a + b),
        ("sub", false) => (2, |a, b, _| a - b),
        ("mul.lo" | "mul.wide", false) => (2, |a, b, _| a.wrapping_mul(b)),
        ("mul.hi", false) if kind.bits == 32 => (2, |a, b, _| (a * b) >> 32),
        ("mul.hi", false) if kind.bits == 64 => (2, |a, b, _| a.wrapping_mul(b) >> 64),
        ("mad.lo", false) => (3, |a, b, c| a.wrapping_mul(b).wrapping_add(c)),
        // The result of a division by 0 is not defined: all ones, as on cards.
        ("div", false) => (2, |a, b, _| a.checked_div(b).unwrap_or(-1)),
        ("rem", false) => (2, |a, b, _| a.checked_rem(b).unwrap_or(a)),
        ("min", false) => (2, |a, b, _| a.min(b)),
        ("max", false) => (2, |a, b, _| a.max(b)),
        ("and", false) => (2, |a, b, _| a & b),
        ("or", false) => (2, |a, b, _| a | b),
        ("xor", false) => (2, |a, b, _| a ^ b),
        // A shift by the width or more leaves zeros, or copies of the sign of a signed number.
        ("shl", false) => (2, |a, places, _| a << (places as u32).min(64)),
        ("shr", false) => (2, |a, places, _| a >> (places as u32).min(64)),
        // The upper word of both, shifted to the left.
        ("shf.l.wrap", false) if kind.bits == 32 => {
            (3, |low, high, places| ((high << 32 | low) << (places & 31)) >> 32)
        }
        // `count` bits from bit `from` on, unsigned.
        ("bfe", false) => (3, |a, from, count| (a >> (from & 0xff).min(64)) & !(-1 << (count & 0xff).min(64))),
        ("prmt", false) if kind.bits == 32 => (3, permute),
        ("add.rn", true) => (2, |a, b, _| bits(single(a) + single(b))),
        ("sub.rn", true) => (2, |a, b, _| bits(single(a) - single(b))),
        ("mul.rn", true) => (2, |a, b, _| bits(single(a) * single(b))),
        ("div.rn", true) => (2, |a, b, _| bits(single(a) / single(b))),
        ("rcp.rn", true) => (1, |a, _, _| bits(1.0 / single(a))),
        ("abs", true) => (1, |a, _, _| bits(single(a).abs())),
        ("neg", true) => (1, |a, _, _| bits(-single(a))),
        // The sign of the first operand on the second.
        ("copysign", true) => (2, |a, b, _| bits(single(b).copysign(single(a)))),
        ("min", true) => (2, |a, b, _| least(a, b)),
        // The negative of the minimum of the negatives.
        ("max", true) => (2, |a, b, _| least(a ^ SIGN, b ^ SIGN) ^ SIGN),
        _ => return None,
    })
}

/// Selects four of the eight bytes of both words. A selector with bit 3 set replaces its byte by eight copies of the byte's sign.
fn permute(a: i128, b: i128, selectors: i128) -> i128 {
    (0..4).fold(0, |made, place| {
        let selector = selectors >> (4 * place) & 0xf;
        let byte = (b << 32 | a) >> (8 * (selector & 7)) & 0xff;
        let byte = if selector & 8 == 0 { byte } else { 0xff * (byte >> 7) };
        made | byte << (8 * place)
    })
}

fn single(number: i128) -> f32 {
    f32::from_bits(number as u32)
}

fn bits(x: f32) -> i128 {
    x.to_bits().into()
}

/// The sign bit.
const SIGN: i128 = 1 << 31;

/// The lesser of both. -0 is less than 0, and a number is less than NaN.
fn least(a: i128, b: i128) -> i128 {
    let (x, y) = (single(a), single(b));
    if y.is_nan() || x < y || x == y && x.is_sign_negative() { a } else { b }
}

/// The orders for which a comparison holds. A `u` at the end of its name means: or one of both is NaN.
fn holds(name: &str, single: bool) -> Option<&'static [Option<Ordering>]> {
    const LESS: Option<Ordering> = Some(Ordering::Less);
    const EQUAL: Option<Ordering> = Some(Ordering::Equal);
    const GREATER: Option<Ordering> = Some(Ordering::Greater);
    Some(match name {
        "eq" => &[EQUAL],
        "ne" => &[LESS, GREATER],
        "lt" => &[LESS],
        "le" => &[LESS, EQUAL],
        "gt" => &[GREATER],
        "ge" => &[GREATER, EQUAL],
        "equ" if single => &[EQUAL, None],
        "neu" if single => &[LESS, GREATER, None],
        "ltu" if single => &[LESS, None],
        "leu" if single => &[LESS, EQUAL, None],
        "gtu" if single => &[GREATER, None],
        "geu" if single => &[GREATER, EQUAL, None],
        "num" if single => &[LESS, EQUAL, GREATER],
        "nan" if single => &[None],
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::Operation;

    fn value(mnemonic: &str, of: &[u64]) -> u64 {
        let operation = Operation::of(mnemonic).unwrap_or_else(|| panic!("{mnemonic}"));
        assert_eq!(operation.operands, of.len(), "{mnemonic}");
        operation.value(std::array::from_fn(|place| of.get(place).copied().unwrap_or(0)))
    }

    fn bits(x: f32) -> u64 {
        x.to_bits().into()
    }

    #[test]
    fn values_of_operations() {
        let cases: &[(&str, &[u64], u64)] = &[
            // Integers wrap at their width.
            ("add.s16", &[0xffff, 2], 1),
            ("sub.s32", &[0, 1], 0xffff_ffff),
            ("mul.lo.s32", &[0xffff_ffff, 3], 0xffff_fffd),
            ("mad.lo.s64", &[2, 3, u64::MAX], 5),
            // Bits above the width of an operand are ignored.
            ("add.s32", &[0xff_0000_0001, 1], 2),
            // Products have a high and a wide form.
            ("mul.hi.u64", &[1 << 63, 6], 3),
            ("mul.hi.u32", &[0xffff_ffff, 0xffff_ffff], 0xffff_fffe),
            ("mul.wide.s32", &[0xffff_ffff, 2], u64::MAX - 1),
            // Comparison depends on the sign.
            ("max.s32", &[0xffff_ffff, 0], 0),
            ("setp.gt.s32", &[0xffff_ffff, 0], 0),
            ("setp.gt.u32", &[0xffff_ffff, 0], 1),
            ("setp.ne.b16", &[0x1_0000, 0], 0),
            ("div.u32", &[7, 0], 0xffff_ffff),
            // A shift by the width or more leaves zeros or the sign.
            ("shl.b32", &[1, 32], 0),
            ("shr.u64", &[u64::MAX, 64], 0),
            ("shr.s32", &[0x8000_0000, 40], 0xffff_ffff),
            ("shl.b16", &[0xff, 12], 0xf000),
            ("shf.l.wrap.b32", &[0x8000_0001, 0x8000_0001, 1], 3),
            ("shf.l.wrap.b32", &[0xdead_beef, 0x1234_5678, 32], 0x1234_5678),
            // Bit fields and byte permutations.
            ("bfe.u32", &[0xffff_ffff, 31, 8], 1),
            ("bfe.u64", &[0x00ab_cd00, 8, 8], 0xcd),
            ("bfe.u32", &[0xffff_ffff, 0, 0], 0),
            ("prmt.b32", &[0x4433_2211, 0, 0x123], 0x1122_3344),
            ("prmt.b32", &[0x4433_2281, 0x8877_6655, 0x48f0], 0x55ff_ff81),
            ("not.b16", &[0xff], 0xff00),
            ("not.pred", &[1], 0),
            // Conversions of integers.
            ("cvt.u64.u16", &[0xab_ffff], 0xffff),
            ("cvt.u64.u32", &[0x1_ffff_ffff], 0xffff_ffff),
            // Single precision rounds to nearest and keeps subnormals.
            ("add.rn.f32", &[bits(1.0), bits(f32::EPSILON / 2.0)], bits(1.0)),
            ("mul.rn.f32", &[bits(f32::MIN_POSITIVE), bits(0.5)], bits(f32::MIN_POSITIVE / 2.0)),
            ("rcp.rn.f32", &[bits(3.0)], bits(1.0 / 3.0)),
            ("neg.f32", &[bits(0.0)], bits(-0.0)),
            ("copysign.f32", &[bits(-1.0), bits(3.0)], bits(-3.0)),
            ("min.f32", &[bits(0.0), bits(-0.0)], bits(-0.0)),
            ("max.f32", &[bits(-0.0), bits(0.0)], bits(0.0)),
            ("max.f32", &[bits(f32::NAN), bits(1.0)], bits(1.0)),
            ("cvt.rzi.s32.f32", &[bits(-1.9)], 0xffff_ffff),
            ("cvt.rzi.s32.f32", &[bits(f32::NAN)], 0),
            ("cvt.rn.f32.s32", &[0xffff_ffff], bits(-1.0)),
            ("cvt.rn.f32.u32", &[0xffff_ffff], bits(4_294_967_296.0)),
        ];
        for (mnemonic, of, expected) in cases {
            assert_eq!(value(mnemonic, of), *expected, "{mnemonic} {of:x?}");
        }
    }

    #[test]
    fn comparisons_with_nan_follow_their_mnemonic() {
        for name in "eq ne lt le gt ge num equ neu ltu leu gtu geu nan".split(' ') {
            let of_nan = name.ends_with('u') || name == "nan";
            let of_equal = ["eq", "le", "ge", "num", "equ", "leu", "geu"].contains(&name);
            let mnemonic = format!("setp.{name}.f32");
            assert_eq!(value(&mnemonic, &[bits(f32::NAN), bits(1.0)]), u64::from(of_nan), "{name}");
            assert_eq!(value(&mnemonic, &[bits(-0.0), bits(0.0)]), u64::from(of_equal), "{name}");
        }
    }
}
