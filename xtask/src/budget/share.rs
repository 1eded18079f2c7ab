//! Share of the time of a real microcontroller that a filter takes, from the instructions counted on the most similar
//! emulated board.

pub struct Chip {
    pub name: &'static str,
    /// The emulated board whose instructions are taken as those of the chip.
    pub like: &'static str,
    pub clock_hz: f64,
    /// Assumed cycles per instruction, with code in flash behind a cache or accelerator, and the filter in on-chip RAM.
    /// The dual-issue M7 takes about one; the others wait for loads, branches and flash.
    pub cycles_per_instruction: f64,
}

pub const CHIPS: [Chip; 5] = [
    Chip { name: "STM32F427", like: "mps2-an386", clock_hz: 168e6, cycles_per_instruction: 1.5 },
    Chip { name: "STM32F765", like: "mps2-an500", clock_hz: 216e6, cycles_per_instruction: 1.0 },
    Chip { name: "STM32H753", like: "mps2-an500", clock_hz: 480e6, cycles_per_instruction: 1.0 },
    Chip { name: "RT1062", like: "mps2-an500", clock_hz: 600e6, cycles_per_instruction: 1.0 },
    // A Cortex-M33: it runs the code of the M4F, because its single-precision FPU is similar.
    Chip { name: "RP2350", like: "mps2-an386", clock_hz: 150e6, cycles_per_instruction: 1.5 },
];

impl Chip {
    /// Share of the chip's time: 0 to 1, or more if the chip is too slow.
    pub fn share(&self, instructions: u64, per_second: f64) -> f64 {
        instructions as f64 * self.cycles_per_instruction * per_second / self.clock_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::firmware::board::EMULATED;

    #[test]
    fn a_share_is_cycles_over_clock() {
        let chip = Chip { name: "", like: "", clock_hz: 100e6, cycles_per_instruction: 2.0 };
        assert_eq!(chip.share(5_000_000, 10.0), 1.0);
    }

    #[test]
    fn every_chip_is_like_a_board() {
        assert!(CHIPS.iter().all(|chip| EMULATED.iter().any(|board| board.name == chip.like)));
    }
}
