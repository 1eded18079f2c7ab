//! The inputs of a batch of runs in flat buffers, with the offsets of each run.

use crate::setup::setup_of;
use crate::unfit::Unfit;
use scphd_filters::settings::Settings;
use scphd_filters::slam::PlanarNumbers;
use scphd_gpu_kernels::{
    Feature, MEASUREMENTS, Mover, PARTICLES, Prediction, Run, SAMPLES, Scan, ScanResult, Status, asks_for_digest,
};
use scphd_log::events::{Event, events};
use scphd_log::log::Log;

/// Capacity for estimated features per scan in addition to the landmarks of the scenario, averaged over a run.
pub const SPARE_FEATURES: usize = 16;
/// Capacity for estimated moving features per scan, averaged over a run.
pub const MOVERS_A_SCAN: usize = 16;

/// The inputs of several runs.
#[derive(Debug, Clone)]
pub struct Batch {
    /// The runs.
    pub runs: Vec<Run>,
    /// The scans of all runs, one run after the other.
    pub scans: Vec<Scan>,
    /// The predictions of all runs, one run after the other.
    pub predictions: Vec<Prediction>,
    /// The measurements of all runs, one run after the other: range, m, and bearing, rad.
    pub measurements: Vec<[f32; 2]>,
    /// The capacities of a filter: particles, and samples of each.
    room: [usize; 2],
}

impl Default for Batch {
    /// A batch without runs, for filters of a slot's capacities.
    fn default() -> Self {
        Self::with_room([PARTICLES, SAMPLES])
    }
}

/// An index or a number of elements in a buffer, as `u32`.
fn number(count: usize) -> Result<u32, Unfit> {
    u32::try_from(count).map_err(|_| Unfit(format!("{count} things in one buffer; there is room for {}", u32::MAX)))
}

impl Batch {
    /// A batch without runs, for filters with these capacities: particles, and samples of each.
    pub(crate) fn with_room(room: [usize; 2]) -> Self {
        let (runs, scans, predictions, measurements) = Default::default();
        Self { runs, scans, predictions, measurements, room }
    }

    /// Adds a run over the log, whose filter has the seed.
    ///
    /// # Errors
    /// The kernels have no capacity or no code for the run. The batch must not be used afterwards.
    pub fn push(&mut self, log: &Log, settings: &Settings, seed: u64) -> Result<(), Unfit> {
        let (scans, predictions, measurements) = (self.scans.len(), self.predictions.len(), self.measurements.len());
        let mut since = 0;
        for event in events(log) {
            match event {
                Event::Predict { control: [speed, turn, _], dt_s, .. } => {
                    self.predictions.push(Prediction { control: [speed as f32, turn as f32], dt_s: dt_s as f32 });
                }
                Event::Fix { .. } => return Err(Unfit("fixes of the pose".into())),
                Event::Scan { index } => {
                    let detections = &log.scans[index].detections;
                    if detections.len() > MEASUREMENTS {
                        let found = detections.len();
                        return Err(Unfit(format!("{found} measurements in a scan; there is room for {MEASUREMENTS}")));
                    }
                    let until = self.predictions.len() - predictions;
                    self.scans.push(Scan {
                        first_prediction: number(since)?,
                        predictions: number(until - since)?,
                        first_measurement: number(self.measurements.len() - measurements)?,
                        measurements: number(detections.len())?,
                    });
                    self.measurements.extend(detections.iter().map(|z| z.map(|x| x as f32)));
                    since = until;
                }
            }
        }
        let [first_feature, first_mover] = self.rooms();
        let of_run = number(self.scans.len() - scans)?;
        let room = |a_scan: usize| number(of_run as usize * a_scan);
        let run = Run {
            seed: Run::halves(seed),
            first_scan: number(scans)?,
            scans: of_run,
            first_prediction: number(predictions)?,
            predictions: number(self.predictions.len() - predictions)?,
            first_measurement: number(measurements)?,
            measurements: number(self.measurements.len() - measurements)?,
            first_feature: number(first_feature)?,
            features: room(log.landmarks.len() + SPARE_FEATURES)?,
            first_mover: number(first_mover)?,
            movers: room(MOVERS_A_SCAN)?,
            setup: setup_of(&PlanarNumbers::of(settings, &log.vehicle, log.initial_pose), self.room)?,
        };
        self.runs.push(run);
        Ok(())
    }

    /// Number of particles of the first run's filter.
    pub fn particles(&self) -> u32 {
        self.runs.first().map_or(0, |run| run.setup.particles)
    }

    /// Whether the batch is the single run of a large filter.
    pub fn is_large(&self) -> bool {
        self.room[0] > PARTICLES
    }

    /// The greatest numbers of particles of a run, and of samples of each.
    pub fn most(&self) -> [usize; 2] {
        let most = |of: fn(&Run) -> u32| self.runs.iter().map(of).max().unwrap_or(0) as usize;
        [most(|run| run.setup.particles), most(|run| run.setup.samples)]
    }

    /// The greatest number of predictions before the scan of any run.
    pub fn predictions_before(&self, scan: u32) -> u32 {
        let of = |run: &Run| {
            let place = (scan < run.scans).then_some((run.first_scan + scan) as usize);
            place.and_then(|place| self.scans.get(place)).map_or(0, |scan| scan.predictions)
        };
        self.runs.iter().map(of).max().unwrap_or(0)
    }

    /// Whether any run needs a digest after the scan: after every `every` scans, and after its last.
    pub(crate) fn asks_for_digest(&self, scan: u32, every: u32) -> bool {
        let taken = scan as usize + 1;
        self.runs.iter().any(|run| asks_for_digest(every as usize, taken, taken == run.scans as usize))
    }

    /// Number of filters, greatest number of particles, and greatest number of samples of each.
    pub(crate) fn counts(&self) -> [u64; 3] {
        let [particles, samples] = self.most();
        [self.runs.len(), particles, samples].map(|count| count as u64)
    }

    /// The greatest number of scans of a run.
    pub fn most_scans(&self) -> u32 {
        self.runs.iter().map(|run| run.scans).max().unwrap_or(0)
    }

    /// Capacities for the estimated features, and for the moving ones, of all runs.
    pub fn rooms(&self) -> [usize; 2] {
        let last = |end: fn(&Run) -> usize| self.runs.last().map_or(0, end);
        [
            last(|run| run.first_feature as usize + run.features as usize),
            last(|run| run.first_mover as usize + run.movers as usize),
        ]
    }

    /// Bytes of the inputs and outputs.
    pub fn bytes(&self) -> usize {
        let [features, movers] = self.rooms();
        size_of_val(&self.runs[..])
            + size_of_val(&self.scans[..])
            + size_of_val(&self.predictions[..])
            + size_of_val(&self.measurements[..])
            + self.runs.len() * size_of::<Status>()
            + self.scans.len() * size_of::<ScanResult>()
            + features * size_of::<Feature>()
            + movers * size_of::<Mover>()
    }
}
