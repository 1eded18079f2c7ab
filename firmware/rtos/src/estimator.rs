//! The filter behind a sequencer: takes inputs in any order and processes them in the order of their stamps.

use crate::drive::{SCAN_DELAY_NS, Sample, Scan};
use crate::leds::Led;
use crate::tally::TALLY;
use defmt_semihosting as _;
use scphd::diagnostics::StagePins;
use scphd_firmware::{board, report};
use scphd_sequencer::{Action, Sequencer, Settings, Stamp};
use scphd_stream::planar::{Odometry, Planar};
use scphd_stream::{Aboard, Filter as _, Measurements, Reader};
use static_cell::ConstStaticCell;

/// Capacity for odometry samples that wait for a scan; that of the queue to the estimator is smaller.
const CONTROLS: usize = 32;
/// Capacity for scans.
const SCANS: usize = 4;
/// Sources of stamps. At equal times the smaller one is first.
const WHEELS: u8 = 0;
const SENSOR: u8 = 1;

/// A scan is processed as soon as it arrives, because odometry up to its time arrives earlier, by at least 10 ms of the vehicle's
/// time.
const SETTINGS: Settings = Settings { window_ns: SCAN_DELAY_NS - 10_000_000, ..Settings::DEFAULT };

/// The sequencer.
type Waiting = Sequencer<Odometry, Measurements<'static, Planar>, CONTROLS, SCANS>;

static MEMORY: ConstStaticCell<<Planar as Aboard<f32>>::Memory> = ConstStaticCell::new(<Planar as Aboard<f32>>::MEMORY);
static WAITING: ConstStaticCell<Waiting> = ConstStaticCell::new(Sequencer::new());

/// The task of the filter.
pub struct Estimator {
    filter: <Planar as Aboard<f32>>::Filter<'static>,
    waiting: &'static mut Waiting,
    pins: StagePins<Led>,
    /// An odometry sample that is newer than the last processed scan.
    newer: Option<Sample>,
    scans: u32,
    late: u32,
    refused: u32,
}

/// The stream in the board's memory. Ends the program if there is none.
pub fn stream() -> Reader<'static, Planar> {
    Reader::open(board::stream()).unwrap_or_else(|error| {
        defmt::error!("{}", error);
        report::failed()
    })
}

impl Estimator {
    /// Starts the estimator for the stream, in its memory. Ends the program on an error.
    ///
    /// # Safety
    /// Must be called once, because it uses the lights.
    pub unsafe fn start() -> Self {
        let (Some(memory), Some(waiting)) = (MEMORY.try_take(), WAITING.try_take()) else { report::failed() };
        let standing = Odometry { control: [0.0; 3], dt_s: 0.0 };
        if let Err(error) = waiting.start(SETTINGS, 0, standing) {
            defmt::error!("{}", error);
            report::failed()
        }
        let filter = <Planar as Aboard<f32>>::start(&stream().header(), memory).unwrap_or_else(|refusal| {
            defmt::error!("{}", refusal);
            report::failed()
        });
        // SAFETY: guaranteed by the caller.
        let pins = StagePins::new(unsafe { Led::of_stages() });
        Self { filter, waiting, pins, newer: None, scans: 0, late: 0, refused: 0 }
    }

    /// Processes waiting inputs. Scans are read before odometry: when a scan has arrived, all odometry up to its time has
    /// arrived, too. Odometry that is newer than the scan is queued after it; otherwise the scan would count as late.
    pub fn work(&mut self, mut scans: impl FnMut() -> Option<Scan>, mut samples: impl FnMut() -> Option<Sample>) {
        for worked_on in 0.. {
            let scan = scans();
            let until_ns = scan.as_ref().map_or(u64::MAX, |scan| scan.stamp_ns);
            while let Some(sample) = self.newer.take().or_else(&mut samples) {
                if sample.stamp_ns > until_ns {
                    self.newer = Some(sample);
                    break;
                }
                let stamp = Stamp::new(WHEELS, sample.stamp_ns);
                self.refused += u32::from(self.waiting.push_control(stamp, sample.odometry).is_err());
            }
            let Some(Scan { stamp_ns, arrived_ns, measurements }) = scan else { return };
            // A further scan arrived before the previous one was finished.
            self.late += u32::from(worked_on > 0);
            let stamp = Stamp::new(SENSOR, stamp_ns);
            self.refused += u32::from(self.waiting.push_event(stamp, measurements).is_err());
            self.waiting.tick(arrived_ns);
            self.filter_what_waits();
        }
    }

    fn filter_what_waits(&mut self) {
        while let Some(action) = self.waiting.next_action() {
            match action {
                Action::Predict { control, dt } | Action::Gap { control, dt } => {
                    let passed = Odometry { dt_s: dt.seconds(), ..control };
                    if let Err(refusal) = self.filter.predict(&passed) {
                        defmt::warn!("prediction left out: {}", refusal);
                    }
                }
                Action::Event(measurements) => {
                    let scan = self.filter.receive(measurements.clone());
                    match self.filter.scan_with(scan, &mut self.pins) {
                        Ok(seen) => {
                            let ([x, y, heading], features) = self.filter.estimate();
                            defmt::debug!(
                                "scan {=u32} pose {=f32} m {=f32} m {=f32} rad, {=usize} features, health {=u16:04x}",
                                self.scans,
                                x as f32,
                                y as f32,
                                heading as f32,
                                features,
                                seen.health
                            );
                        }
                        Err(refusal) => defmt::warn!("scan {=u32} left out: {}", self.scans, refusal),
                    }
                    self.scans += 1;
                }
            }
        }
    }

    /// Reports the result, and ends the program.
    pub fn end(&mut self) -> ! {
        self.waiting.flush();
        self.filter_what_waits();
        let (lost_odometry, lost_scans) = TALLY.lost();
        let [predict, weigh, resample, update, reduce] = TALLY.preempted();
        let (waited, deepest) = TALLY.worst();
        defmt::println!(
            "end scans {=u32} late {=u32} lost_odometry {=u32} lost_scans {=u32} refused {=u32} preempted {=u32} \
             predict {=u32} weigh {=u32} resample {=u32} update {=u32} reduce {=u32} \
             waited_ticks {=u32} deepest {=u32} pins_refused {=u32} digest {=u64:016x} stack {=usize}",
            self.scans,
            self.late,
            lost_odometry,
            lost_scans,
            self.refused,
            predict + weigh + resample + update + reduce,
            predict,
            weigh,
            resample,
            update,
            reduce,
            waited,
            deepest,
            self.pins.refused(),
            self.filter.digest(),
            board::stack_used()
        );
        report::done()
    }
}
