//! The functions of arithmetic instructions.
//!
//! A register is a `u64` whose lowest bits are used: an instruction reads as many bits as its type has, and writes zeros above
//! them.

mod function;
mod single;
mod whole;

pub(crate) use function::Function;

/// The function of a mnemonic, if it is known.
pub(crate) fn function_of(mnemonic: &str) -> Option<Function> {
    let (name, kinds) = mnemonic.split_once('.')?;
    // A hint for the assembler that all threads of a warp agree.
    let kinds = kinds.strip_prefix("uni.").unwrap_or(kinds);
    if name == "cvta" {
        // All address spaces share one range of addresses.
        return Some(Function::One(|address| address));
    }
    if let Some(kind) = kinds.strip_suffix("f32") {
        return single::function(name, kind.trim_end_matches('.'));
    }
    if name == "cvt" {
        let (to, from) = kinds.split_once('.')?;
        return single::conversion(kinds).or_else(|| whole::conversion(to, from));
    }
    whole::function(name, kinds)
}

#[cfg(test)]
mod tests {
    use super::{Function, function_of};

    /// The value of a mnemonic's function.
    fn value(mnemonic: &str, of: &[u64]) -> u64 {
        match (function_of(mnemonic).unwrap_or_else(|| panic!("{mnemonic}")), of) {
            (Function::One(f), &[a]) => f(a),
            (Function::Two(f), &[a, b]) => f(a, b),
            (Function::Three(f), &[a, b, c]) => f(a, b, c),
            (function, _) => panic!("{mnemonic}: {function:?}"),
        }
    }

    fn bits(x: f32) -> u64 {
        x.to_bits().into()
    }

    #[test]
    fn values_of_functions() {
        let cases: &[(&str, &[u64], u64)] = &[
            // Integers wrap at their width.
            ("add.s16", &[0xffff, 2], 1),
            ("sub.s32", &[0, 1], 0xffff_ffff),
            ("add.u64", &[u64::MAX, 2], 1),
            ("mul.lo.s32", &[0xffff_ffff, 3], 0xffff_fffd),
            ("mad.lo.s64", &[2, 3, u64::MAX], 5),
            ("neg.s32", &[1], 0xffff_ffff),
            // Bits above the width of an operand are ignored.
            ("add.s32", &[0xff_0000_0001, 1], 2),
            // Products have a high and a wide form.
            ("mul.hi.u64", &[1 << 63, 6], 3),
            ("mul.hi.u32", &[0xffff_ffff, 0xffff_ffff], 0xffff_fffe),
            ("mul.wide.u32", &[0xffff_ffff, 2], 0x1_ffff_fffe),
            ("mul.wide.s32", &[0xffff_ffff, 2], u64::MAX - 1),
            ("mul.wide.u16", &[0xffff, 2], 0x1_fffe),
            // Comparison depends on the sign.
            ("min.u16", &[5, 0xfffe], 5),
            ("max.s32", &[0xffff_ffff, 0], 0),
            ("max.u32", &[0xffff_ffff, 0], 0xffff_ffff),
            ("setp.gt.s32", &[0xffff_ffff, 0], 0),
            ("setp.gt.u32", &[0xffff_ffff, 0], 1),
            ("setp.ne.b16", &[0x1_0000, 0], 0),
            ("div.u32", &[7, 2], 3),
            ("rem.u64", &[7, 4], 3),
            ("div.u32", &[7, 0], 0xffff_ffff),
            // A shift by the width or more leaves zeros or the sign.
            ("shl.b32", &[1, 31], 1 << 31),
            ("shl.b32", &[1, 32], 0),
            ("shr.u64", &[u64::MAX, 64], 0),
            ("shr.s32", &[0x8000_0000, 40], 0xffff_ffff),
            ("shr.u32", &[0x8000_0000, 31], 1),
            ("shl.b16", &[0xff, 12], 0xf000),
            ("shf.l.wrap.b32", &[0x8000_0001, 0x8000_0001, 1], 3),
            ("shf.l.wrap.b32", &[0xdead_beef, 0x1234_5678, 32], 0x1234_5678),
            // Bit fields and byte permutations.
            ("bfe.u32", &[0x1234_5678, 8, 12], 0x456),
            ("bfe.u32", &[0xffff_ffff, 31, 8], 1),
            ("bfe.u64", &[0x00ab_cd00, 8, 8], 0xcd),
            ("bfe.u32", &[0xffff_ffff, 0, 0], 0),
            ("prmt.b32", &[0x4433_2211, 0, 0x123], 0x1122_3344),
            ("prmt.b32", &[0x4433_2281, 0x8877_6655, 0x48f0], 0x55ff_ff81),
            ("popc.b32", &[0xf0f0_0001], 9),
            ("not.b16", &[0xff], 0xff00),
            ("not.pred", &[1], 0),
            // Conversions of integers.
            ("cvt.u64.u16", &[0xab_ffff], 0xffff),
            ("cvt.u16.u64", &[0x1_0002], 2),
            ("cvt.u64.u32", &[0x1_ffff_ffff], 0xffff_ffff),
            // Single precision rounds to nearest and keeps subnormals.
            ("add.rn.f32", &[bits(1.0), bits(f32::EPSILON / 2.0)], bits(1.0)),
            ("mul.rn.f32", &[bits(f32::MIN_POSITIVE), bits(0.5)], bits(f32::MIN_POSITIVE / 2.0)),
            ("div.rn.f32", &[bits(1.0), bits(3.0)], bits(1.0 / 3.0)),
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
            ("cvt.rn.f32.u64", &[1 << 40], bits(1_099_511_627_776.0)),
        ];
        for (mnemonic, of, expected) in cases {
            assert_eq!(value(mnemonic, of), *expected, "{mnemonic} {of:x?}");
        }
    }

    #[test]
    fn comparisons_with_nan_follow_their_mnemonic() {
        let nan = bits(f32::NAN);
        for (name, of_nan, of_equal) in [
            ("eq", 0, 1),
            ("ne", 0, 0),
            ("lt", 0, 0),
            ("le", 0, 1),
            ("gt", 0, 0),
            ("ge", 0, 1),
            ("equ", 1, 1),
            ("neu", 1, 0),
            ("ltu", 1, 0),
            ("leu", 1, 1),
            ("gtu", 1, 0),
            ("geu", 1, 1),
            ("num", 0, 1),
            ("nan", 1, 0),
        ] {
            let mnemonic = format!("setp.{name}.f32");
            assert_eq!(value(&mnemonic, &[nan, bits(1.0)]), of_nan, "{name}");
            assert_eq!(value(&mnemonic, &[bits(-0.0), bits(0.0)]), of_equal, "{name}");
        }
    }

    #[test]
    fn unknown_mnemonics_are_refused() {
        for mnemonic in
            ["fma.rn.f32", "add.f32", "add.rn.ftz.f32", "div.full.f32", "add.f64", "setp.eq.and.b32", "bar.sync"]
        {
            assert!(function_of(mnemonic).is_none(), "{mnemonic}");
        }
    }
}
