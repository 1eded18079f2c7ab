//! The boards' two simple timers: Arm's CMSDK APB timer.

/// Ticks of a timer in a second: 25 MHz on QEMU's boards.
pub const TICKS_PER_S: u64 = 25_000_000;

const CONTROL: usize = 0;
const VALUE: usize = 1;
const RELOAD: usize = 2;
const INTERRUPT: usize = 3;

const ENABLED: u32 = 1;
const INTERRUPTS: u32 = 8;
const EXPIRED: u32 = 1;

/// A timer with an interval that is set for each interrupt.
#[derive(Debug)]
pub struct Timer {
    registers: *mut u32,
}

// SAFETY: only the owner of a timer uses its registers, in any task.
unsafe impl Send for Timer {}

impl Timer {
    /// The timer of the interrupt [`TIMER0`](crate::device::Interrupt::TIMER0).
    ///
    /// # Safety
    /// Must be called once: two owners would clear each other's interrupts.
    pub unsafe fn first() -> Self {
        Self { registers: 0x4000_0000 as *mut u32 }
    }

    /// The timer of the interrupt [`TIMER1`](crate::device::Interrupt::TIMER1).
    ///
    /// # Safety
    /// Must be called once: two owners would clear each other's interrupts.
    pub unsafe fn second() -> Self {
        Self { registers: 0x4000_1000 as *mut u32 }
    }

    fn read(&self, register: usize) -> u32 {
        // SAFETY: a register of the board, one of the four of this timer.
        unsafe { self.registers.add(register).read_volatile() }
    }

    fn write(&mut self, register: usize, value: u32) {
        // SAFETY: as above.
        unsafe { self.registers.add(register).write_volatile(value) }
    }

    /// Starts the timer: the first interrupt is after `ticks`.
    pub fn start(&mut self, ticks: u32) {
        self.write(CONTROL, 0);
        self.write(RELOAD, ticks);
        self.write(VALUE, ticks);
        self.write(CONTROL, ENABLED | INTERRUPTS);
    }

    /// Stops the timer.
    pub fn stop(&mut self) {
        self.write(CONTROL, 0);
        self.write(INTERRUPT, EXPIRED);
    }

    /// Ticks since it expired; it stays at zero for one tick.
    fn waited(&self) -> u32 {
        match self.read(VALUE) {
            0 => 0,
            left => self.read(RELOAD).saturating_sub(left),
        }
    }

    /// Called in its interrupt: clears it, and returns its latency, ticks.
    pub fn expired(&mut self) -> u32 {
        let waited = self.waited();
        self.write(INTERRUPT, EXPIRED);
        waited
    }

    /// Called in its interrupt: sets the next one to `ticks` after this one, whatever the latency was.
    pub fn again(&mut self, ticks: u32) {
        let waited = self.waited();
        self.write(RELOAD, ticks);
        self.write(VALUE, ticks.saturating_sub(waited).max(1));
    }
}
