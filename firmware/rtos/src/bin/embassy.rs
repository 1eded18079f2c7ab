//! The filter under embassy: odometry and sensor are tasks of executors that run in interrupts, and preempt the estimator, a task
//! of an executor in thread mode.
#![no_std]
#![no_main]

use cortex_m::peripheral::NVIC;
use cortex_m_rt::entry;
use embassy_executor::{InterruptExecutor, raw};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use scphd_firmware::report;
use scphd_firmware_rtos::device::{Interrupt, NVIC_PRIO_BITS, interrupt};
use scphd_firmware_rtos::drive::{Sample, Scan, Sensor, Wheels};
use scphd_firmware_rtos::estimator::{Estimator, stream};
use scphd_firmware_rtos::tally::TALLY;
use scphd_firmware_rtos::timer::Timer;
use static_cell::StaticCell;

/// Capacity of the queue of odometry samples.
const SAMPLES: usize = 16;
/// Capacity of the queue of scans.
const SCANS: usize = 2;

static OF_SAMPLES: Channel<CriticalSectionRawMutex, Sample, SAMPLES> = Channel::new();
static OF_SCANS: Channel<CriticalSectionRawMutex, Scan, SCANS> = Channel::new();
/// Signals the estimator that there is an input.
static ARRIVED: Signal<CriticalSectionRawMutex, ()> = Signal::new();
/// Signals that a timer has expired.
static ODOMETRY_DUE: Signal<CriticalSectionRawMutex, ()> = Signal::new();
static SCAN_DUE: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// The executors in software interrupts.
static OF_ODOMETRY: InterruptExecutor = InterruptExecutor::new();
static OF_SENSOR: InterruptExecutor = InterruptExecutor::new();
/// The executor of the estimator, in thread mode.
static BELOW: StaticCell<raw::Executor> = StaticCell::new();

#[interrupt]
fn DUAL_TIMER() {
    // SAFETY: this is the handler of the executor's interrupt, which is unmasked when the executor starts.
    unsafe { OF_ODOMETRY.on_interrupt() }
}

#[interrupt]
fn UART2_RX() {
    // SAFETY: as above.
    unsafe { OF_SENSOR.on_interrupt() }
}

/// The interrupt stays pending until the task clears the timer, and is masked until then.
#[interrupt]
fn TIMER0() {
    NVIC::mask(Interrupt::TIMER0);
    ODOMETRY_DUE.signal(());
}

#[interrupt]
fn TIMER1() {
    NVIC::mask(Interrupt::TIMER1);
    SCAN_DUE.signal(());
}

/// Unmasks an interrupt, and clears a request that is still pending although the timer was already cleared.
///
/// # Safety
/// No critical section depends on the masked interrupt.
unsafe fn await_interrupt(interrupt: Interrupt) {
    NVIC::unpend(interrupt);
    // SAFETY: guaranteed by the caller.
    unsafe { NVIC::unmask(interrupt) };
}

/// Reads an odometry sample when its timer expires. Preempts all other tasks.
#[embassy_executor::task]
async fn odometry(mut timer: Timer, mut wheels: Wheels) {
    while let Some(ticks) = wheels.due() {
        timer.again(ticks);
        // SAFETY: no critical section depends on the masked interrupt.
        unsafe { await_interrupt(Interrupt::TIMER0) };
        ODOMETRY_DUE.wait().await;
        TALLY.interrupted(timer.expired());
        if let Some(sample) = wheels.sample() {
            if OF_SAMPLES.try_send(sample).is_err() {
                TALLY.lost_odometry();
            }
            TALLY.waiting(OF_SAMPLES.len());
        }
        ARRIVED.signal(());
    }
    timer.stop();
}

/// Receives a scan when its timer expires.
#[embassy_executor::task]
async fn receive(mut timer: Timer, mut sensor: Sensor) {
    while let Some(ticks) = sensor.due() {
        timer.again(ticks);
        // SAFETY: as above.
        unsafe { await_interrupt(Interrupt::TIMER1) };
        SCAN_DUE.wait().await;
        timer.expired();
        if let Some(scan) = sensor.scan()
            && OF_SCANS.try_send(scan).is_err()
        {
            TALLY.lost_scan();
        }
        ARRIVED.signal(());
    }
    timer.stop();
    TALLY.end();
    ARRIVED.signal(());
}

/// Runs the filter on waiting inputs.
#[embassy_executor::task]
async fn estimate(mut estimator: Estimator) {
    loop {
        ARRIVED.wait().await;
        // Read before the queues, so that these have every input if the drive has ended.
        let ended = TALLY.has_ended();
        estimator.work(|| OF_SCANS.try_receive().ok(), || OF_SAMPLES.try_receive().ok());
        if ended {
            estimator.end();
        }
    }
}

/// A priority as the processor encodes it: 1 is the lowest.
const fn priority(level: u8) -> u8 {
    ((1 << NVIC_PRIO_BITS) - level) << (8 - NVIC_PRIO_BITS)
}

#[entry]
fn main() -> ! {
    let Some(mut peripherals) = cortex_m::Peripherals::take() else { report::failed() };
    // SAFETY: this runs once, and nothing else uses timers or lights.
    let (mut odometry_timer, mut sensor_timer, estimator) =
        unsafe { (Timer::first(), Timer::second(), Estimator::start()) };
    let (wheels, sensor) = (Wheels::of(stream()), Sensor::of(stream()));
    for (interrupt, level) in
        [(Interrupt::TIMER0, 4), (Interrupt::DUAL_TIMER, 3), (Interrupt::TIMER1, 2), (Interrupt::UART2_RX, 1)]
    {
        // SAFETY: nothing has been started whose critical sections depend on priorities.
        unsafe { peripherals.NVIC.set_priority(interrupt, priority(level)) };
    }
    wheels.due().into_iter().for_each(|ticks| odometry_timer.start(ticks));
    sensor.due().into_iter().for_each(|ticks| sensor_timer.start(ticks));
    let below = BELOW.init(raw::Executor::new(usize::MAX as *mut ()));
    let (Ok(odometry), Ok(receive), Ok(estimate)) =
        (odometry(odometry_timer, wheels), receive(sensor_timer, sensor), estimate(estimator))
    else {
        report::failed()
    };
    below.spawner().spawn(estimate);
    OF_SENSOR.start(Interrupt::UART2_RX).spawn(receive);
    OF_ODOMETRY.start(Interrupt::DUAL_TIMER).spawn(odometry);
    // A board should use `embassy_executor::Executor`, which sleeps. QEMU wakes a sleeping processor late if several timers
    // expire, and runs would not be reproducible.
    loop {
        // SAFETY: polled only here; it was initialised with the context of the thread-mode executor.
        unsafe { below.poll() };
    }
}

scphd_firmware::failure_handlers!();
