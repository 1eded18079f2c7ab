//! The boards' two simple timers: Arm's CMSDK APB timer.

/// Ticks of a timer in a second: 25 MHz on the boards that QEMU has.
pub const TICKS_PER_S: u64 = 25_000_000;

const CONTROL: usize = 0;
const VALUE: usize = 1;
const RELOAD: usize = 2;
const INTERRUPT: usize = 3;

const ENABLED: u32 = 1;
const INTERRUPTS: u32 = 8;
const EXPIRED: u32 = 1;

/// A timer that interrupts after times that are each told anew.
#[derive(Debug)]
pub struct Timer {
    registers: *mut u32,
}

// SAFETY: whoever has a timer is the only one to touch its registers, whichever task that is.
unsafe impl Send for Timer {}

impl Timer {
    /// The timer of the interrupt [`TIMER0`](crate::device::Interrupt::TIMER0).
    ///
    /// # Safety
    /// To be called once: two owners would take one another's ticks.
    #[must_use]
    pub unsafe fn first() -> Self {
        Self { registers: 0x4000_0000 as *mut u32 }
    }

    /// The timer of the interrupt [`TIMER1`](crate::device::Interrupt::TIMER1).
    ///
    /// # Safety
    /// To be called once: two owners would take one another's ticks.
    #[must_use]
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

    /// Begins: the first interrupt comes after so many ticks.
    pub fn start(&mut self, ticks: u32) {
        self.write(CONTROL, 0);
        self.write(RELOAD, ticks);
        self.write(VALUE, ticks);
        self.write(CONTROL, ENABLED | INTERRUPTS);
    }

    /// No more interrupts.
    pub fn stop(&mut self) {
        self.write(CONTROL, 0);
        self.write(INTERRUPT, EXPIRED);
    }

    /// Ticks since it came to zero, where it stays for one.
    fn waited(&self) -> u32 {
        match self.read(VALUE) {
            0 => 0,
            left => self.read(RELOAD).saturating_sub(left),
        }
    }

    /// In its interrupt: takes that back, and returns how many ticks ago it came.
    pub fn expired(&mut self) -> u32 {
        let waited = self.waited();
        self.write(INTERRUPT, EXPIRED);
        waited
    }

    /// In its interrupt: the next one comes so many ticks after this one came, however long ago that was.
    pub fn again(&mut self, ticks: u32) {
        let waited = self.waited();
        self.write(RELOAD, ticks);
        self.write(VALUE, ticks.saturating_sub(waited).max(1));
    }
}
