//! A SLAM filter over an underwater log, whichever it is.

use super::log::Log;
use super::record::MapFeature;
use super::settings::Settings;
use crate::reference::{self, Draws, space};
use crate::slam::{Ahead, Precision, Refusal, config_of, full, left_out, online_of, refusal};
use crate::stream::underwater_models;
use crate::threads::Threads;
use nalgebra::{Vector3, Vector4};
use scphd::{
    Auv, AuvControl, AuvPose, Births, Component, Config, Detector, DetectorMemory, Health, Implausible, MapMemory,
    NoMoving, Online, Real, ScPhd, ScanRoom, Sensing, State, Static, StereoCamera, StereoFrustum, UniformClutter,
};
use scphd_stream::underwater::AuvModels;

/// What a scan did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Effective number of particles before resampling.
    pub n_eff: f64,
    /// Greatest number of components in view of a particle.
    pub in_view: usize,
    /// Measurements without an inverse in view, over all distinct particles.
    pub no_birth: usize,
    /// ln of the likelihood of the frame given all before, up to a constant.
    pub ln_evidence: f64,
    /// Mean squared innovation over what was expected of it, 1 where the models are right; `None` where nothing was
    /// detected.
    pub innovation: Option<f64>,
    /// Pages in use, where the filter has pages.
    pub pages_used: Option<usize>,
    /// Conditions the filter reported.
    pub health: Health,
}

/// A filter that an underwater log can be fed to.
pub trait Slam {
    /// Moves the vehicle; where no vehicle does that, leaves it where it is and says what is wrong.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn predict(&mut self, control: &AuvControl<f64>, dt_s: f64) -> Result<Option<Implausible>, Refusal>;

    /// Takes in a frame's keypoints.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn scan(&mut self, keypoints: &[[f64; 4]]) -> Result<Outcome, Refusal>;

    /// Estimated pose (x, y, z m, yaw rad, yaw rate rad/s) and its covariance.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn pose(&mut self) -> Result<([f64; 5], [[f64; 5]; 5]), Refusal>;

    /// N̂ and the estimated features.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal>;

    /// From now on weighs candidates with these threads; its results do not depend on it.
    fn weigh_on(&mut self, threads: &Threads);

    /// Hash of the complete state, where the filter has one.
    fn digest(&mut self) -> Option<u64>;

    /// Memory of the state, where it is fixed.
    fn state_bytes(&self) -> Option<u64>;
}

/// A filter that shows its whole state, for lockstep with the reference.
pub trait Transparent: Slam {
    /// The state as it stands.
    ///
    /// # Errors
    /// The filter refused, and says why.
    fn snapshot(&mut self) -> Result<Snapshot, Refusal>;
}

/// The state of a filter in the reference's terms.
pub struct Snapshot {
    /// Candidates, in order; weights sum to one.
    pub candidates: Vec<space::Candidate>,
    /// The map of every particle.
    pub maps: Vec<Vec<reference::Component<3>>>,
    /// ln L of the candidates that the last scan weighed.
    pub ln_likelihoods: Vec<f64>,
    /// For every particle the candidate of the last scan that it continues.
    pub survivors: Vec<usize>,
    /// A copy of the random stream: gives the numbers that the filter will draw next.
    pub draws: Box<dyn Draws>,
}

impl core::fmt::Debug for Snapshot {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Snapshot")
            .field("candidates", &self.candidates)
            .field("maps", &self.maps)
            .finish_non_exhaustive()
    }
}

/// Keypoints in a frame and components of one map in an update that every state has room for.
const MEASUREMENTS: usize = 256;
const VIEW: usize = 4096;
/// Jobs that the weighing is divided into: some for each of a few threads, so that none waits long for another.
const WORKERS: usize = 16;

type TankState<T, const PARTICLES: usize, const CANDIDATES: usize, const PAGES: usize, const MAP_PAGES: usize> = State<
    AuvPose<T>,
    PARTICLES,
    CANDIDATES,
    MapMemory<Static<Vector3<T>>, PARTICLES, PAGES, MAP_PAGES, VIEW>,
    NoMoving,
>;

type Scratch<T> = DetectorMemory<Vector4<T>, MEASUREMENTS, WORKERS>;

type TankFilter<'s, T> = ScPhd<'s, Auv<T>>;
/// The stereo camera, with or without scratch.
pub(super) type Camera<T, R = ()> = Detector<Sensing<StereoCamera<T>, StereoFrustum<T>, UniformClutter<T>>, R>;

/// The fixed-capacity filter, with its state on the heap.
#[derive(Debug)]
pub struct CoreFilter<
    T: Real,
    const PARTICLES: usize,
    const CANDIDATES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
> {
    models: AuvModels<T>,
    births: Births<T>,
    online: Online<T>,
    config: Config<T>,
    state: Box<TankState<T, PARTICLES, CANDIDATES, PAGES, MAP_PAGES>>,
    scratch: Box<Scratch<T>>,
    threads: Threads,
}

impl<T: Real, const PARTICLES: usize, const CANDIDATES: usize, const PAGES: usize, const MAP_PAGES: usize>
    CoreFilter<T, PARTICLES, CANDIDATES, PAGES, MAP_PAGES>
{
    fn start(models: AuvModels<T>, settings: &Settings, start: AuvPose<T>, seed: u64) -> Result<Self, Refusal> {
        let mut started = Self {
            models,
            births: Births::of_static(T::from_f64(settings.filter.birth_intensity)),
            online: online_of(&settings.filter),
            config: config_of(&settings.filter),
            state: Box::new(State::new()),
            scratch: Box::new(DetectorMemory::new()),
            threads: Threads::default(),
        };
        started.with(|filter, _| filter.reset(start, seed))?.map_err(refusal)?;
        Ok(started)
    }

    /// Works on the filter and its camera. A state goes on from where the last filter over it left off.
    fn with<R>(
        &mut self,
        work: impl FnOnce(&mut TankFilter<'_, T>, &mut Camera<T, ScanRoom<'_, Vector4<T>>>) -> R,
    ) -> Result<R, Refusal> {
        let AuvModels { motion, sensing } = self.models;
        let camera = Detector::new(sensing, self.births).map_err(refusal)?.learning(self.online).map_err(refusal)?;
        let mut camera = camera.over(&mut self.scratch).map_err(refusal)?;
        let mut filter = TankFilter::new(motion, self.config, &mut *self.state).map_err(refusal)?;
        Ok(work(&mut filter, &mut camera))
    }
}

impl<T: Real, const PARTICLES: usize, const CANDIDATES: usize, const PAGES: usize, const MAP_PAGES: usize> Slam
    for CoreFilter<T, PARTICLES, CANDIDATES, PAGES, MAP_PAGES>
{
    fn predict(&mut self, control: &AuvControl<f64>, dt_s: f64) -> Result<Option<Implausible>, Refusal> {
        left_out(self.with(|filter, _| filter.predict(&control.rounded(), T::from_f64(dt_s)))?)
    }

    fn scan(&mut self, keypoints: &[[f64; 4]]) -> Result<Outcome, Refusal> {
        let measurements: Vec<_> = keypoints.iter().map(|z| Vector4::from(z.map(T::from_f64))).collect();
        let threads = self.threads.clone();
        let report =
            self.with(|filter, camera| filter.scan_on(camera, &measurements, &threads, &mut ()))?.map_err(refusal)?;
        Ok(Outcome {
            n_eff: report.n_eff.to_f64(),
            in_view: report.in_view,
            no_birth: report.no_birth,
            ln_evidence: report.ln_evidence.to_f64(),
            innovation: Some(report.innovation.to_f64()).filter(|&innovation| innovation > 0.0),
            pages_used: Some(report.pages_used),
            health: report.health,
        })
    }

    fn pose(&mut self) -> Result<([f64; 5], [[f64; 5]; 5]), Refusal> {
        let estimate = self.with(|filter, _| filter.estimate_pose())?.ok_or_else(|| refusal("not started"))?;
        let AuvPose { x_m, y_m, z_m, yaw_rad, yaw_rate_radps, .. } = estimate.mean;
        Ok(([x_m, y_m, z_m, yaw_rad, yaw_rate_radps].map(T::to_f64), full(&estimate.covariance)))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal> {
        let mut features = vec![Component::ZERO; MAP_PAGES * scphd::PAGE_LEN];
        let estimate = self.with(|filter, camera| filter.estimate_map(camera, &mut features))?;
        features.truncate(estimate.features);
        let features = features.iter().map(|feature| MapFeature {
            id: feature.label,
            weight: feature.ln_weight.exp().to_f64(),
            mean: std::array::from_fn(|k| feature.mean[k].to_f64()),
            covariance: full(&feature.covariance),
        });
        Ok((estimate.expected_features.to_f64(), features.collect()))
    }

    fn weigh_on(&mut self, threads: &Threads) {
        self.threads = threads.clone();
    }

    fn digest(&mut self) -> Option<u64> {
        self.with(|filter, camera| camera.digest(filter.digest())).ok()
    }

    fn state_bytes(&self) -> Option<u64> {
        Some((size_of_val(&*self.state) + size_of_val(&*self.scratch)) as u64)
    }
}

impl<T: Real, const PARTICLES: usize, const CANDIDATES: usize, const PAGES: usize, const MAP_PAGES: usize> Transparent
    for CoreFilter<T, PARTICLES, CANDIDATES, PAGES, MAP_PAGES>
{
    fn snapshot(&mut self) -> Result<Snapshot, Refusal> {
        let particles = self.config.particles;
        self.with(|filter, _| {
            let candidates = filter.candidates().iter().map(|candidate| {
                let AuvPose { x_m, y_m, z_m, yaw_rad, yaw_rate_radps, roll_rad, pitch_rad } = candidate.pose;
                let pose = space::Pose {
                    position: [x_m, y_m, z_m].map(T::to_f64),
                    yaw: yaw_rad.to_f64(),
                    yaw_rate: yaw_rate_radps.to_f64(),
                    roll: roll_rad.to_f64(),
                    pitch: pitch_rad.to_f64(),
                };
                space::Candidate { pose, ln_weight: candidate.ln_weight.to_f64() }
            });
            let component = |component: &Component<Vector3<T>>| reference::Component {
                ln_weight: component.ln_weight.to_f64(),
                mean: std::array::from_fn(|k| component.mean[k].to_f64()),
                covariance: full(&component.covariance),
            };
            let noise = filter.noise().cloned().ok_or_else(|| refusal("not started"))?;
            Ok(Snapshot {
                candidates: candidates.collect(),
                maps: (0..particles).map(|particle| filter.map(particle).map(component).collect()).collect(),
                ln_likelihoods: filter.ln_likelihoods().iter().map(|ln_l| ln_l.to_f64()).collect(),
                survivors: filter.survivors().iter().map(|&survivor| usize::from(survivor)).collect(),
                draws: Box::new(Ahead::<T>::of(noise)),
            })
        })?
    }
}

/// The fixed-capacity filter with the models and tuning that the settings describe.
///
/// # Errors
/// The filter cannot work with the settings.
pub fn core_filter(
    log: &Log,
    settings: &Settings,
    precision: Precision,
    seed: u64,
) -> Result<Box<dyn Transparent>, Refusal> {
    match precision {
        Precision::F32 => with_models::<f32>(log, settings, seed),
        Precision::F64 => with_models::<f64>(log, settings, seed),
    }
}

fn with_models<T: Real>(log: &Log, settings: &Settings, seed: u64) -> Result<Box<dyn Transparent>, Refusal> {
    let Settings { filter, .. } = settings;
    let numbers = underwater_models(log, settings)?;
    let models = numbers.of_filter().map_err(refusal)?;
    let start = numbers.start();
    let candidates = filter.particles.saturating_mul(filter.samples);
    Ok(match (filter.particles, candidates) {
        (..=64, ..=128) => Box::new(CoreFilter::<T, 64, 128, 4096, 512>::start(models, settings, start, seed)?),
        (..=400, ..=800) => Box::new(CoreFilter::<T, 400, 800, 14_000, 512>::start(models, settings, start, seed)?),
        _ => Box::new(CoreFilter::<T, 2048, 4096, 65_535, 512>::start(models, settings, start, seed)?),
    })
}
