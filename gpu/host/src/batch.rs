//! The inputs of a batch of runs in flat buffers, with the offsets of each run.

use crate::failure::Failure;
use crate::runs::Input;
use scphd::settings::Proposal;
use scphd_filters::settings::Settings;
use scphd_filters::slam::{Filter, PlanarNumbers, Precision, joint_config};
use scphd_gpu_kernels::{
    Feature, LARGE_PARTICLES, MEASUREMENTS, PARTICLES, Prediction, Run, SAMPLES, Scan, ScanResult, Setup, Status,
    setup_of,
};
use scphd_log::events::{Event, events};
use scphd_log::log::Log;
use scphd_vehicle::{Description, Filter as Tuning, JointSettings, Start};

/// A sort of filters, by their capacities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sort {
    /// Many filters of a few particles.
    Many,
    /// Filters of many particles.
    Large,
    /// Joint maps.
    Joint,
}

/// Capacity for estimated features per scan in addition to the landmarks of the scenario, averaged over a run.
const SPARE_FEATURES: usize = 32;

/// The inputs of several runs with filters of a sort: everything of one run, then everything of the next.
#[derive(Debug)]
pub struct Batch {
    pub runs: Vec<Run>,
    pub scans: Vec<Scan>,
    pub predictions: Vec<Prediction>,
    /// Range, m, and bearing, rad.
    pub measurements: Vec<[f32; 2]>,
    pub sort: Sort,
}

fn unfit(why: impl std::fmt::Display) -> Failure {
    Failure::of("not for the kernels", why)
}

/// An index or a number of elements in a buffer, as `u32`.
fn number(count: usize) -> Result<u32, Failure> {
    u32::try_from(count).map_err(|_| unfit(format!("{count} things in one buffer; there is room for {}", u32::MAX)))
}

impl Batch {
    /// A run for each of the inputs.
    pub fn of(sort: Sort, inputs: &[Input<'_>]) -> Result<Self, Failure> {
        let (runs, scans, predictions, measurements) = Default::default();
        let mut batch = Self { runs, scans, predictions, measurements, sort };
        inputs.iter().try_for_each(|(log, settings, seed)| batch.push(log, settings, *seed))?;
        Ok(batch)
    }

    /// Adds a run over the log, whose filter has the seed.
    fn push(&mut self, log: &Log, settings: &Settings, seed: u64) -> Result<(), Failure> {
        let (scans, predictions, measurements) = (self.scans.len(), self.predictions.len(), self.measurements.len());
        let mut since = 0;
        for event in events(log) {
            match event {
                Event::Predict { control, dt_s, .. } => {
                    self.predictions.push(Prediction { control: control.map(|x| x as f32), dt_s: dt_s as f32 });
                }
                Event::Fix { .. } => return Err(unfit("fixes of the pose")),
                Event::Scan { index } => {
                    let detections = &log.scans[index].detections;
                    if detections.len() > MEASUREMENTS {
                        let found = detections.len();
                        return Err(unfit(format!("{found} measurements in a scan; there is room for {MEASUREMENTS}")));
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
        let of_run = self.scans.len() - scans;
        let ([particles, samples], setup) = self.sort.setup(log, settings)?;
        let run = Run {
            seed: bytemuck::cast(seed),
            first_scan: number(scans)?,
            scans: number(of_run)?,
            first_prediction: number(predictions)?,
            first_measurement: number(measurements)?,
            first_feature: number(self.features())?,
            features: number(of_run * (log.landmarks.len() + SPARE_FEATURES))?,
            particles,
            samples,
            setup,
        };
        self.runs.push(run);
        Ok(())
    }

    /// The greatest numbers of particles of a run, and of samples of each.
    pub fn most(&self) -> [usize; 2] {
        let most = |of: fn(&Run) -> u32| self.runs.iter().map(of).max().unwrap_or(0) as usize;
        [most(|run| run.particles), most(|run| run.samples)]
    }

    /// The greatest number of predictions before the scan of any run.
    pub fn predictions_before(&self, scan: u32) -> u32 {
        let runs = self.runs.iter().filter(|run| scan < run.scans);
        runs.map(|run| self.scans[(run.first_scan + scan) as usize].predictions).max().unwrap_or(0)
    }

    /// Whether any run needs a digest after the scan: after every `every` scans, and after its last.
    pub fn asks_for_digest(&self, scan: u32, every: u32) -> bool {
        let taken = scan + 1;
        taken.checked_rem(every) == Some(0) || self.runs.iter().any(|run| taken == run.scans)
    }

    pub fn most_scans(&self) -> u32 {
        self.runs.iter().map(|run| run.scans).max().unwrap_or(0)
    }

    /// Capacity for the estimated features of all runs.
    pub fn features(&self) -> usize {
        self.runs.last().map_or(0, |run| run.first_feature as usize + run.features as usize)
    }

    /// Bytes of the inputs and outputs.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.runs[..])
            + size_of_val(&self.scans[..])
            + size_of_val(&self.predictions[..])
            + size_of_val(&self.measurements[..])
            + self.runs.len() * size_of::<Status>()
            + self.scans.len() * size_of::<ScanResult>()
            + self.features() * size_of::<Feature>()
    }
}

impl Sort {
    /// The sort of a filter with these settings.
    pub fn of(filter: Filter, settings: &Settings) -> Result<Self, Failure> {
        match filter {
            Filter::Joint(Precision::F32) => Ok(Self::Joint),
            Filter::Core(Precision::F32) if settings.filter.particles <= PARTICLES => Ok(Self::Many),
            Filter::Core(Precision::F32) => Ok(Self::Large),
            _ => Err(unfit(format!("the filter {}, or its precision", filter.name(settings.filter.likelihood)))),
        }
    }

    /// Numbers of particles and samples of a run's filter, and its settings.
    fn setup(self, log: &Log, settings: &Settings) -> Result<([u32; 2], Setup), Failure> {
        let margin = if self == Self::Joint { 1.0 } else { settings.filter.interval_margin };
        let numbers = PlanarNumbers::<f32>::with_margin(settings, margin, &log.vehicle, log.initial_pose);
        let PlanarNumbers { vehicle, sensors, config, start } = numbers;
        let [sensor] = sensors[..] else { return Err(unfit(format!("{} sensors; there may be one", sensors.len()))) };
        let most = |count: usize, most: usize, of: &str| match u32::try_from(count) {
            Ok(number) if count <= most => Ok(number),
            _ => Err(unfit(format!("{count} {of}; there is room for {most}"))),
        };
        let (counts, filter) = if self == Self::Joint {
            most(settings.joint.hypotheses, 1, "hypotheses")?;
            if settings.calibration.is_some() {
                return Err(unfit("calibration of the odometry"));
            }
            let movers = (settings.moving.birth_intensity > 0.0).then_some(config.moving);
            let joint = JointSettings { config: joint_config(&settings.joint), movers, ..JointSettings::default() };
            ([0; 2], Tuning::Joint(joint))
        } else {
            if config.births_wait {
                return Err(unfit("births that wait"));
            }
            if let Proposal::Informed(informed) = config.proposal {
                most(informed.rounds, 16, "rounds of the proposal")?;
            }
            let particles = if self == Self::Large { LARGE_PARTICLES } else { PARTICLES };
            let particles = most(config.particles, particles, "particles")?;
            ([particles, most(config.samples, SAMPLES, "samples of a particle")?], Tuning::Mixture(config))
        };
        let robot = Description::robot();
        let start = Start { pose: start, ..robot.start };
        let sensors = [Some(sensor), None, None, None];
        Ok((counts, setup_of(&Description { vehicle, filter, sensors, start, ..robot })))
    }
}
