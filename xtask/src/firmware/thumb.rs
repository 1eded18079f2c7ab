//! What a Thumb-2 instruction does to the stack, and where it goes.

/// What matters of one instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// Nothing that matters.
    None,
    /// It takes so many bytes of the stack.
    Takes(u32),
    /// It goes to this address, for good or as a call.
    GoesTo(u32),
    /// It goes where a register says.
    GoesAnywhere,
    /// It goes to one of the branches in a table that begins behind it, where compilers have written it.
    GoesByTable,
    /// It sets the stack pointer from a register, or moves it by one.
    SetsStack,
}

/// The length in bytes and the effect of the instruction at `address` that begins with the half-words `first`, `second`.
pub fn decode(address: u32, first: u16, second: u16) -> (u32, Effect) {
    if first >> 11 >= 0b11101 { (4, long(address, first, second)) } else { (2, short(address, first)) }
}

fn short(address: u32, code: u16) -> Effect {
    match code {
        // PUSH
        _ if code & 0xfe00 == 0xb400 => Effect::Takes(4 * (code & 0x1ff).count_ones()),
        // SUB SP, #imm
        _ if code & 0xff80 == 0xb080 => Effect::Takes(4 * u32::from(code & 0x7f)),
        // BX LR returns; BLX and other BX go anywhere.
        0x4770 => Effect::None,
        _ if code & 0xff07 == 0x4700 => Effect::GoesAnywhere,
        // ADD SP, Rm; MOV SP, Rm
        _ if code & 0xff87 == 0x4485 || code & 0xff87 == 0x4685 => Effect::SetsStack,
        // MOV PC, Rm
        _ if code & 0xff87 == 0x4687 => Effect::GoesByTable,
        // B<cond>, of which the last two conditions are other instructions.
        _ if code & 0xf000 == 0xd000 && code & 0x0e00 != 0x0e00 => {
            goes(address, extended(u32::from(code & 0xff) << 1, 9))
        }
        // B
        _ if code & 0xf800 == 0xe000 => goes(address, extended(u32::from(code & 0x7ff) << 1, 12)),
        _ => Effect::None,
    }
}

fn long(address: u32, first: u16, second: u16) -> Effect {
    let register = second >> 8 & 0xf;
    match first {
        // STMDB SP!
        0xe92d => Effect::Takes(4 * second.count_ones()),
        // STR Rt, [SP, #-imm]!
        0xf84d if second & 0x0f00 == 0x0d00 => Effect::Takes(u32::from(second & 0xff)),
        // STRD Rt, Rt2, [SP, #-imm]!
        0xe96d => Effect::Takes(4 * u32::from(second & 0xff)),
        // VPUSH
        _ if first & 0xffbf == 0xed2d && second & 0x0e00 == 0x0a00 => Effect::Takes(4 * u32::from(second & 0xff)),
        // SUB SP, SP, #constant
        _ if first & 0xfbef == 0xf1ad && register == 13 => Effect::Takes(constant(immediate(first, second))),
        // SUBW SP, SP, #imm
        _ if first & 0xfbff == 0xf2ad && register == 13 => Effect::Takes(immediate(first, second)),
        // SUB SP, SP, Rm; ADD SP, SP, Rm
        _ if (first & 0xffef == 0xebad || first & 0xffef == 0xeb0d) && register == 13 => Effect::SetsStack,
        // B<cond>, B, BL
        _ if first & 0xf800 == 0xf000 && second & 0x8000 != 0 => branch(address, first, second),
        // LDR PC, […], except for the one that returns: LDR PC, [SP], #4
        _ if first & 0xff70 == 0xf850 && second & 0xf000 == 0xf000 && (first, second) != (0xf85d, 0xfb04) => {
            Effect::GoesAnywhere
        }
        _ => Effect::None,
    }
}

fn branch(address: u32, first: u16, second: u16) -> Effect {
    let sign = u32::from(first >> 10 & 1);
    let (j1, j2) = (u32::from(second >> 13 & 1), u32::from(second >> 11 & 1));
    let low = u32::from(second & 0x7ff) << 1;
    if second & 0x5000 == 0 {
        // B<cond>; the conditions that are none belong to other instructions.
        if first >> 7 & 0b111 == 0b111 {
            return Effect::None;
        }
        let offset = sign << 20 | j2 << 19 | j1 << 18 | u32::from(first & 0x3f) << 12 | low;
        return goes(address, extended(offset, 21));
    }
    if second & 0x5000 == 0x4000 {
        return Effect::None;
    }
    let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
    let offset = sign << 24 | i1 << 23 | i2 << 22 | u32::from(first & 0x3ff) << 12 | low;
    goes(address, extended(offset, 25))
}

/// Branches count from four bytes further on.
fn goes(address: u32, offset: u32) -> Effect {
    Effect::GoesTo(address.wrapping_add(4).wrapping_add(offset))
}

/// A number of so many bits with its sign.
fn extended(number: u32, bits: u32) -> u32 {
    let unused = 32 - bits;
    ((number << unused).cast_signed() >> unused).cast_unsigned()
}

/// i:imm3:imm8
fn immediate(first: u16, second: u16) -> u32 {
    u32::from(first >> 10 & 1) << 11 | u32::from(second >> 12 & 7) << 8 | u32::from(second & 0xff)
}

/// The constant that twelve bits stand for.
fn constant(bits: u32) -> u32 {
    let byte = bits & 0xff;
    match bits >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => (0x80 | bits & 0x7f).rotate_right(bits >> 7),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(first: u16, second: u16, length: u32, effect: Effect) {
        assert_eq!(decode(0x1000, first, second), (length, effect), "{first:04x} {second:04x}");
    }

    /// As an assembler encodes them.
    #[test]
    fn instructions_that_matter() {
        check(0xb5f0, 0, 2, Effect::Takes(20)); // push {r4-r7, lr}
        check(0xb082, 0, 2, Effect::Takes(8)); // sub sp, #8
        check(0xb002, 0, 2, Effect::None); // add sp, #8
        check(0xe92d, 0x4ff0, 4, Effect::Takes(36)); // push {r4-r11, lr}
        check(0xed2d, 0x8b10, 4, Effect::Takes(64)); // vpush {d8-d15}
        check(0xf5ad, 0x6d80, 4, Effect::Takes(1024)); // sub.w sp, sp, #1024
        check(0xf5ad, 0x5d80, 4, Effect::Takes(4096)); // sub.w sp, sp, #4096
        check(0xf2ad, 0x4d0c, 4, Effect::Takes(1036)); // subw sp, sp, #1036
        check(0xf84d, 0x8d04, 4, Effect::Takes(4)); // str r8, [sp, #-4]!
        check(0x4770, 0, 2, Effect::None); // bx lr
        check(0x4798, 0, 2, Effect::GoesAnywhere); // blx r3
        check(0x46b7, 0, 2, Effect::GoesByTable); // mov pc, r6
        check(0x46a5, 0, 2, Effect::SetsStack); // mov sp, r4
        check(0xf85d, 0xfb04, 4, Effect::None); // ldr pc, [sp], #4
        check(0xe8bd, 0x8ff0, 4, Effect::None); // pop {r4-r11, pc}
        check(0xe7fe, 0, 2, Effect::GoesTo(0x1000)); // b .
        check(0xd0fe, 0, 2, Effect::GoesTo(0x1000)); // beq .
        check(0xdf00, 0, 2, Effect::None); // svc 0
        check(0xf000, 0xf800, 4, Effect::GoesTo(0x1004)); // bl .+4
        check(0xf7ff, 0xfffe, 4, Effect::GoesTo(0x1000)); // bl .
        check(0xf7ff, 0xbffe, 4, Effect::GoesTo(0x1000)); // b.w .
        check(0xf43f, 0xaffe, 4, Effect::GoesTo(0x1000)); // beq.w .
        check(0xf3bf, 0x8f4f, 4, Effect::None); // dsb sy
    }
}
