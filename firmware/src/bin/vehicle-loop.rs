//! A filter in a vehicle's loop: odometry and scans arrive in an interrupt, the filter runs in the foreground, and every scan
//! must be finished before the next one arrives.
//!
//! A vehicle has an interrupt of the odometry's timer and one of the sensor's transfer. Here SysTick replaces both, at 20 Hz, and
//! reads their data from a stream.
#![no_std]
#![no_main]

use core::cell::RefCell;
use cortex_m::Peripherals;
use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use defmt_semihosting as _;
use heapless::Deque;
use scphd_firmware::{board, report};
use scphd_stream::planar::{Odometry, Planar};
use scphd_stream::{Aboard, Filter, Measurements, Reader, Record};
use static_cell::ConstStaticCell;

/// Odometry samples a second.
const ODOMETRY_HZ: u32 = 20;
/// Clock frequency of the core: 25 MHz on QEMU's boards.
const CLOCK_HZ: u32 = 25_000_000;
/// Capacity of the queue of inputs during a scan. If it is full, inputs are lost, and no filter can recover their time.
const QUEUE: usize = 16;

/// An input from the interrupt to the foreground.
enum Input {
    Odometry(Odometry),
    /// The measurements remain in the stream's memory; a driver would hand over its buffer.
    Scan {
        measurements: Measurements<'static, Planar>,
        tick: u32,
    },
}

/// Data shared by interrupt and foreground.
struct Arrivals {
    source: Option<Reader<'static, Planar>>,
    inputs: Deque<Input, QUEUE>,
    /// Number of interrupts so far: the time.
    tick: u32,
    lost: u32,
    ended: bool,
}

static ARRIVALS: Mutex<RefCell<Arrivals>> =
    Mutex::new(RefCell::new(Arrivals { source: None, inputs: Deque::new(), tick: 0, lost: 0, ended: false }));

static MEMORY: ConstStaticCell<<Planar as Aboard<f32>>::Memory> = ConstStaticCell::new(<Planar as Aboard<f32>>::MEMORY);

#[entry]
fn main() -> ! {
    let (Some(memory), Some(mut peripherals)) = (MEMORY.try_take(), Peripherals::take()) else { report::failed() };
    let reader = match Reader::open(board::stream()) {
        Ok(reader) => reader,
        Err(error) => {
            defmt::error!("{}", error);
            report::failed()
        }
    };
    let header = reader.header();
    let mut filter = match <Planar as Aboard<f32>>::start(&header, memory) {
        Ok(filter) => filter,
        Err(refusal) => {
            defmt::error!("{}", refusal);
            report::failed()
        }
    };
    // A scan must be finished before the next one arrives.
    let deadline = (header.scan_interval_s * f64::from(ODOMETRY_HZ)) as u32;
    free(|token| ARRIVALS.borrow(token).borrow_mut().source = Some(reader));
    start_timer(&mut peripherals);

    let (mut scans, mut late) = (0_u32, 0_u32);
    loop {
        let (input, ended, lost) = free(|token| {
            let mut arrivals = ARRIVALS.borrow(token).borrow_mut();
            (arrivals.inputs.pop_front(), arrivals.ended, arrivals.lost)
        });
        match input {
            Some(Input::Odometry(odometry)) => {
                if let Err(refusal) = filter.predict(&odometry) {
                    defmt::warn!("prediction left out: {}", refusal);
                }
            }
            Some(Input::Scan { measurements, tick }) => {
                let scan = filter.receive(measurements);
                match filter.scan(scan) {
                    Ok(seen) => {
                        let ([x, y, heading], features) = filter.estimate();
                        let now = free(|token| ARRIVALS.borrow(token).borrow().tick);
                        let took = now.wrapping_sub(tick);
                        if took > deadline {
                            late += 1;
                            defmt::warn!("scan {=u32} took {=u32} ticks of {=u32}", scans, took, deadline);
                        }
                        defmt::debug!(
                            "scan {=u32} pose {=f32} m {=f32} m {=f32} rad, {=usize} features, health {=u16:04x}",
                            scans,
                            x as f32,
                            y as f32,
                            heading as f32,
                            features,
                            seen.health
                        );
                    }
                    Err(refusal) => defmt::warn!("scan {=u32} left out: {}", scans, refusal),
                }
                scans += 1;
            }
            None if ended => {
                defmt::println!(
                    "end scans {=u32} late {=u32} lost {=u32} digest {=u64:016x} stack {=usize}",
                    scans,
                    late,
                    lost,
                    filter.digest(),
                    board::stack_used()
                );
                report::done()
            }
            None => cortex_m::asm::wfi(),
        }
    }
}

fn start_timer(peripherals: &mut Peripherals) {
    let timer = &mut peripherals.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(CLOCK_HZ / ODOMETRY_HZ - 1);
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
}

/// Reads an odometry sample and the scan that arrived with it.
#[exception]
fn SysTick() {
    free(|token| {
        let arrivals = &mut *ARRIVALS.borrow(token).borrow_mut();
        arrivals.tick = arrivals.tick.wrapping_add(1);
        let Arrivals { source: Some(source), inputs, tick, lost, ended } = arrivals else { return };
        // Reads all records up to the next odometry sample, at most as many as the queue could hold.
        for _ in 0..QUEUE {
            let (input, last) = match source.read() {
                Ok(Some(Record::Predict(odometry))) => (Input::Odometry(odometry), true),
                Ok(Some(Record::Scan(measurements))) => (Input::Scan { measurements, tick: *tick }, false),
                // This loop does not use other records.
                Ok(Some(_)) => continue,
                Ok(None) | Err(_) => {
                    *ended = true;
                    return;
                }
            };
            *lost += u32::from(inputs.push_back(input).is_err());
            if last {
                return;
            }
        }
    });
}

scphd_firmware::failure_handlers!();
