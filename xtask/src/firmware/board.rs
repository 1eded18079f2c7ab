//! The boards: targets, flags and names in QEMU.

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Board {
    /// Name of its memory map in `firmware/memory` and of QEMU's machine.
    pub name: &'static str,
    pub core: &'static str,
    pub target: &'static str,
    /// The compiler's flags for the processor.
    pub flags: &'static [&'static str],
    /// Address to which the stream is loaded; `None` if QEMU does not have the board.
    pub stream: Option<u32>,
    /// Start address of the program's RAM.
    pub ram: u64,
}

/// The reference board with the top-level `memory.x`: images are linked for it, but not run.
pub const REFERENCE: Board = Board {
    name: "stm32h753",
    core: "Cortex-M7",
    target: "thumbv7em-none-eabihf",
    flags: &["-Ctarget-cpu=cortex-m7"],
    stream: None,
    ram: 0x2400_0000,
};

/// The boards that QEMU has.
pub const EMULATED: [Board; 3] = [
    Board {
        name: "mps2-an500",
        core: "Cortex-M7",
        target: "thumbv7em-none-eabihf",
        flags: &["-Ctarget-cpu=cortex-m7"],
        stream: Some(0x6080_0000),
        ram: 0x6000_0000,
    },
    Board {
        name: "mps2-an386",
        core: "Cortex-M4F",
        target: "thumbv7em-none-eabihf",
        flags: &["-Ctarget-cpu=cortex-m4"],
        stream: Some(0x2180_0000),
        ram: 0x2100_0000,
    },
    Board {
        name: "mps3-an547",
        core: "Cortex-M55",
        target: "thumbv8m.main-none-eabihf",
        // Without the vector extension: its floating-point instructions flush subnormal numbers to zero, which would differ from
        // the other processors.
        flags: &["-Ctarget-cpu=cortex-m55", "-Ctarget-feature=-mve,-mve.fp"],
        stream: Some(0x2110_0000),
        ram: 0x2100_0000,
    },
];

/// The board of checks that do not depend on it.
pub const FIRST: &Board = &EMULATED[0];

/// All targets, without duplicates.
pub const TARGETS: [&str; 2] = ["thumbv7em-none-eabihf", "thumbv8m.main-none-eabihf"];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process;

    #[test]
    fn the_first_board_has_the_processor_of_the_reference_board() {
        assert_eq!((FIRST.core, FIRST.target, FIRST.flags), (REFERENCE.core, REFERENCE.target, REFERENCE.flags));
    }

    #[test]
    fn every_board_has_a_memory_map_and_a_known_target() {
        for board in EMULATED {
            let map = process::root().join("firmware/memory").join(board.name).with_extension("x");
            let text = std::fs::read_to_string(&map).unwrap();
            let stream = format!("0x{:08x}", board.stream.unwrap());
            assert!(text.contains(&stream) && text.contains(&format!("0x{:08x}", board.ram)), "{}", map.display());
            assert!(TARGETS.contains(&board.target));
        }
        assert!(TARGETS.contains(&REFERENCE.target));
    }
}
