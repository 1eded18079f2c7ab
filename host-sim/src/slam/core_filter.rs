//! The fixed-capacity filter over a planar log.

use super::{PoseAndCovariance, Refusal, ScanOutcome, Slam, Snapshot, Transparent, config_of, left_out, online_of};
use crate::log::{self, Vehicle};
use crate::record::{MapFeature, MovingFeature};
use crate::reference::{self, Candidate, Draws};
use crate::settings::{SensorSettings, Settings};
use crate::threads::Threads;
use nalgebra::Vector2;
use scphd::{
    Ackermann, AckermannControl, AckermannGeometry, Births, Component, Config, ConstantVelocity, ControlNoise,
    Detector, DetectorMemory, Dynamic, Implausible, MapMemory, Motion, Mounting, MovingConfig, Noise, Online,
    PlanarPose, RangeBearing, RangeBearingLimits, RangeBearingWindow, Real, ScPhd, ScanRoom, Sensing, State, Static,
    Step, Symmetric, Unicycle, UnicycleControl, UniformClutter, Vector,
};

/// Scalar of the fixed-capacity filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

/// A motion model whose controls come as two numbers.
pub trait PlanarMotion<T: Real>: Motion<Pose = PlanarPose<T>> + Copy {
    /// The model's control.
    fn control(numbers: [f64; 2]) -> Self::Control;
}

impl<T: Real> PlanarMotion<T> for Ackermann<T> {
    fn control([speed, steering]: [f64; 2]) -> AckermannControl<T> {
        AckermannControl { speed_mps: T::from_f64(speed), steering_rad: T::from_f64(steering) }
    }
}

impl<T: Real> PlanarMotion<T> for Unicycle<T> {
    fn control([speed, rate]: [f64; 2]) -> UnicycleControl<T> {
        UnicycleControl { speed_mps: T::from_f64(speed), rate_radps: T::from_f64(rate) }
    }
}

/// Measurements in a scan and components of one map in an update that every host state has room for.
const MEASUREMENTS: usize = 256;
const VIEW: usize = 4096;
/// Jobs that the weighing is divided into: some for each of a few threads, so that none waits long for another.
const WORKERS: usize = 16;

/// Static and moving maps of the same capacities.
type HostState<T, const PARTICLES: usize, const CANDIDATES: usize, const PAGES: usize, const MAP_PAGES: usize> = State<
    PlanarPose<T>,
    PARTICLES,
    CANDIDATES,
    MapMemory<Static<Vector2<T>>, PARTICLES, PAGES, MAP_PAGES, VIEW>,
    MapMemory<Dynamic<Vector2<T>>, PARTICLES, PAGES, MAP_PAGES, VIEW>,
>;

type Scratch<T> = DetectorMemory<Vector2<T>, MEASUREMENTS, WORKERS>;

type PlanarSensing<T> = Sensing<RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>>;

/// The detector of a planar log, with or without scratch.
pub(super) type PlanarDetector<T, R = ()> = Detector<PlanarSensing<T>, R>;

/// The models of a planar log, and what is born and learnt.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlanarModels<T: Real, M> {
    pub(super) motion: M,
    sensing: PlanarSensing<T>,
    mounting: Option<Mounting<T>>,
    births: Births<T>,
    online: Online<T>,
}

impl<T: Real, M> PlanarModels<T, M> {
    /// The detector that these models are of.
    pub(super) fn detector(&self) -> Result<PlanarDetector<T>, Refusal> {
        let detector = Detector::new(self.sensing, self.births).map_err(refusal)?;
        match self.mounting {
            Some(mounting) => detector.mounted(mounting).map_err(refusal),
            None => Ok(detector),
        }
    }
}

/// The filter of one planar log, with its state on the heap.
#[derive(Debug)]
pub struct CoreFilter<
    T: Real,
    M,
    const PARTICLES: usize,
    const CANDIDATES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
> {
    models: PlanarModels<T, M>,
    config: Config<T>,
    state: Box<HostState<T, PARTICLES, CANDIDATES, PAGES, MAP_PAGES>>,
    scratch: Box<Scratch<T>>,
    threads: Threads,
}

impl<
    T: Real,
    M: PlanarMotion<T>,
    const PARTICLES: usize,
    const CANDIDATES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
> CoreFilter<T, M, PARTICLES, CANDIDATES, PAGES, MAP_PAGES>
{
    fn start(
        models: PlanarModels<T, M>,
        config: Config<T>,
        initial_pose: [f64; 3],
        seed: u64,
    ) -> Result<Self, Refusal> {
        let state = Box::new(State::new());
        let scratch = Box::new(DetectorMemory::new());
        let mut started = Self { models, config, state, scratch, threads: Threads::default() };
        let [x, y, heading] = initial_pose.map(T::from_f64);
        started.with(|filter, detector| {
            filter.check(detector).map_err(refusal)?;
            filter.reset(PlanarPose::new(x, y, heading), seed).map_err(refusal)
        })??;
        Ok(started)
    }

    /// Works on the filter and its detector. A state goes on from where the last filter over it left off.
    fn with<R>(
        &mut self,
        work: impl FnOnce(&mut ScPhd<'_, M>, &mut PlanarDetector<T, ScanRoom<'_, Vector2<T>>>) -> R,
    ) -> Result<R, Refusal> {
        let detector = self.models.detector()?.learning(self.models.online).map_err(refusal)?;
        let mut detector = detector.over(&mut self.scratch).map_err(refusal)?;
        let mut filter = ScPhd::new(self.models.motion, self.config, &mut *self.state).map_err(refusal)?;
        Ok(work(&mut filter, &mut detector))
    }
}

pub(crate) fn refusal(error: impl core::fmt::Display) -> Refusal {
    Refusal(error.to_string())
}

impl<
    T: Real,
    M: PlanarMotion<T>,
    const PARTICLES: usize,
    const CANDIDATES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
> Slam for CoreFilter<T, M, PARTICLES, CANDIDATES, PAGES, MAP_PAGES>
{
    fn predict(&mut self, control: [f64; 2], dt_s: f64) -> Result<Option<Implausible>, Refusal> {
        left_out(self.with(|filter, _| filter.predict(&M::control(control), T::from_f64(dt_s)))?)
    }

    fn scan(&mut self, detections: &[[f64; 2]]) -> Result<ScanOutcome, Refusal> {
        let measurements: Vec<_> = detections.iter().map(|z| Vector2::from(z.map(T::from_f64))).collect();
        let threads = self.threads.clone();
        let report = self
            .with(|filter, detector| filter.scan_on(detector, &measurements, &threads, &mut ()))?
            .map_err(refusal)?;
        let innovation = report.innovation.to_f64();
        Ok(ScanOutcome {
            n_eff: report.n_eff.to_f64(),
            resampled: report.resampled,
            ln_evidence: Some(report.ln_evidence.to_f64()),
            innovation: (innovation > 0.0).then_some(innovation),
            health: report.health,
        })
    }

    fn pose(&mut self) -> Result<PoseAndCovariance, Refusal> {
        let estimate = self.with(|filter, _| filter.estimate_pose())?.ok_or_else(|| refusal("not started"))?;
        let mean = estimate.mean;
        Ok(([mean.x_m, mean.y_m, mean.heading_rad].map(T::to_f64), full(&estimate.covariance)))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal> {
        let mut features = vec![Component::ZERO; MAP_PAGES * scphd::PAGE_LEN];
        let estimate = self.with(|filter, detector| filter.estimate_map(detector, &mut features))?;
        features.truncate(estimate.features);
        let features = features.iter().map(|feature| MapFeature {
            id: feature.label,
            weight: feature.ln_weight.exp().to_f64(),
            mean: std::array::from_fn(|k| feature.mean[k].to_f64()),
            covariance: full(&feature.covariance),
        });
        Ok((estimate.expected_features.to_f64(), features.collect()))
    }

    fn moving(&mut self) -> Result<Vec<MovingFeature>, Refusal> {
        let mut features = vec![Component::ZERO; MAP_PAGES * scphd::PAGE_LEN];
        let estimate = self.with(|filter, _| filter.estimate_moving(&mut features))?;
        features.truncate(estimate.features);
        let features = features.iter().map(|feature| MovingFeature {
            id: feature.label,
            weight: feature.ln_weight.exp().to_f64(),
            position: std::array::from_fn(|k| feature.mean[k].to_f64()),
            velocity: std::array::from_fn(|k| feature.mean[2 + k].to_f64()),
            covariance: full(&feature.covariance),
        });
        Ok(features.collect())
    }

    fn digest(&mut self) -> Option<u64> {
        self.with(|filter, detector| detector.digest(filter.digest())).ok()
    }

    fn weigh_on(&mut self, threads: &Threads) {
        self.threads = threads.clone();
    }

    fn state_bytes(&self) -> Option<u64> {
        Some((size_of_val(&*self.state) + size_of_val(&*self.scratch)) as u64)
    }
}

impl<
    T: Real,
    M: PlanarMotion<T>,
    const PARTICLES: usize,
    const CANDIDATES: usize,
    const PAGES: usize,
    const MAP_PAGES: usize,
> Transparent for CoreFilter<T, M, PARTICLES, CANDIDATES, PAGES, MAP_PAGES>
{
    fn snapshot(&mut self) -> Result<Snapshot, Refusal> {
        self.with(|filter, _| {
            let particles = filter.particles();
            let candidates = filter.candidates().iter().map(|candidate| Candidate {
                pose: [candidate.pose.x_m, candidate.pose.y_m, candidate.pose.heading_rad].map(T::to_f64),
                ln_weight: candidate.ln_weight.to_f64(),
            });
            let noise = filter.noise().cloned().ok_or_else(|| refusal("not started"))?;
            Ok(Snapshot {
                candidates: candidates.collect(),
                maps: (0..particles).map(|particle| filter.map(particle).map(of_core).collect()).collect(),
                moving: (0..particles).map(|particle| filter.moving_map(particle).map(of_core).collect()).collect(),
                waited_s: filter.waited_s().to_f64(),
                heaviest: filter.heaviest(),
                ln_likelihoods: filter.ln_likelihoods().iter().map(|ln_l| ln_l.to_f64()).collect(),
                survivors: filter.survivors().iter().map(|&survivor| usize::from(survivor)).collect(),
                draws: Box::new(Ahead::<T>::of(noise)),
            })
        })?
    }
}

/// The upper left corner of a covariance, or all of it.
pub(crate) fn full<V: Vector, const N: usize>(covariance: &Symmetric<V>) -> [[f64; N]; N] {
    std::array::from_fn(|row| std::array::from_fn(|column| covariance.get(row, column).to_f64()))
}

/// A component in the reference's terms.
fn of_core<V: Vector, const N: usize>(component: &Component<V>) -> reference::Component<N> {
    reference::Component {
        ln_weight: component.ln_weight.to_f64(),
        mean: std::array::from_fn(|k| component.mean.at(k).to_f64()),
        covariance: full(&component.covariance),
    }
}

/// A copy of a filter's random stream that runs ahead of it.
pub(crate) struct Ahead<T> {
    noise: Noise,
    scalar: core::marker::PhantomData<T>,
}

impl<T> Ahead<T> {
    /// From where the filter's stream is.
    pub(crate) fn of(noise: Noise) -> Self {
        Self { noise, scalar: core::marker::PhantomData }
    }
}

impl<T: Real> Draws for Ahead<T> {
    fn normal(&mut self) -> f64 {
        self.noise.normal::<T>().to_f64()
    }

    fn uniform(&mut self) -> f64 {
        self.noise.uniform::<T>().to_f64()
    }
}

/// The fixed-capacity filter for a log's vehicle, in the smallest host state with room for its particles.
///
/// # Errors
/// The settings are out of range, and which.
pub fn core_filter(
    settings: &Settings,
    vehicle: &Vehicle,
    initial_pose: [f64; 3],
    precision: Precision,
    seed: u64,
) -> Result<Box<dyn Transparent>, Refusal> {
    match precision {
        Precision::F32 => with_scalar::<f32>(settings, vehicle, initial_pose, seed),
        Precision::F64 => with_scalar::<f64>(settings, vehicle, initial_pose, seed),
    }
}

/// What is to be done with the models of a planar log, whichever motion they have.
pub(super) trait OverModels<T: Real> {
    /// What comes of it.
    type Output;
    /// Does it.
    fn over<M: PlanarMotion<T> + 'static>(self, models: PlanarModels<T, M>) -> Result<Self::Output, Refusal>;
}

/// Makes the models of these settings for a vehicle, and goes on with them.
pub(super) fn with_planar_models<T: Real, W: OverModels<T>>(
    settings: &Settings,
    vehicle: &Vehicle,
    work: W,
) -> Result<W::Output, Refusal> {
    let noise = ControlNoise {
        speed_sigma_mps: T::from_f64(settings.vehicle.speed_sigma_mps),
        speed_sigma_ratio: T::from_f64(settings.vehicle.speed_sigma_ratio),
        turn_sigma: T::from_f64(settings.vehicle.turn_sigma),
        turn_sigma_ratio: T::from_f64(settings.vehicle.turn_sigma_ratio),
        interval_s: T::from_f64(settings.vehicle.noise_interval_s),
    };
    match *vehicle {
        Vehicle::Ackermann { wheelbase_m, encoder_offset_m, sensor_forward_m, sensor_left_m } => {
            let geometry = AckermannGeometry {
                wheelbase_m: T::from_f64(wheelbase_m),
                encoder_offset_m: T::from_f64(encoder_offset_m),
                sensor_forward_m: T::from_f64(sensor_forward_m),
                sensor_left_m: T::from_f64(sensor_left_m),
            };
            work.over(planar_models(settings, Ackermann::new(geometry, noise).map_err(refusal)?)?)
        }
        Vehicle::Unicycle => work.over(planar_models(settings, Unicycle::new(Step::Euler, noise).map_err(refusal)?)?),
        Vehicle::UnicycleArc => work.over(planar_models(settings, Unicycle::new(Step::Arc, noise).map_err(refusal)?)?),
    }
}

fn planar_models<T: Real, M>(settings: &Settings, motion: M) -> Result<PlanarModels<T, M>, Refusal> {
    let field_of_view = RangeBearingWindow::new(limits::<T>(&settings.sensor)).map_err(refusal)?;
    let per_scan = T::from_f64(settings.sensor.clutter_per_scan);
    let sensing = Sensing {
        sensor: range_bearing(&settings.sensor)?,
        field_of_view,
        clutter: UniformClutter::of_scan(per_scan, field_of_view.measure()).map_err(refusal)?,
    };
    let place = settings.sensor.mounting();
    let mounting = (place != log::Mounting::NONE).then(|| {
        let [forward, left, yaw] = [place.forward_m, place.left_m, place.yaw_rad].map(T::from_f64);
        Mounting::in_plane(forward, left, yaw).map_err(refusal)
    });
    let births = Births {
        of_static: T::from_f64(settings.filter.birth_intensity),
        of_moving: T::from_f64(settings.moving.birth_intensity),
    };
    Ok(PlanarModels { motion, sensing, mounting: mounting.transpose()?, births, online: online_of(&settings.filter) })
}

fn with_scalar<T: Real>(
    settings: &Settings,
    vehicle: &Vehicle,
    initial_pose: [f64; 3],
    seed: u64,
) -> Result<Box<dyn Transparent>, Refusal> {
    let filter = &settings.filter;
    let config = Config {
        moving: MovingConfig {
            velocity_sigma_mps: T::from_f64(settings.moving.velocity_sigma_mps),
            motion: ConstantVelocity {
                acceleration_psd: T::from_f64(settings.moving.acceleration_psd),
                lifetime_s: T::from_f64(settings.moving.lifetime_s),
            },
            spread_max_m: T::from_f64(settings.moving.spread_max_m),
            extraction_weight: T::from_f64(settings.moving.extraction_weight),
        },
        ..config_of(filter)
    };
    let candidates = filter.particles.saturating_mul(filter.samples);
    with_planar_models(settings, vehicle, Start { config, candidates, initial_pose, seed })
}

/// Starts the filter with a mixture a particle.
struct Start<T: Real> {
    config: Config<T>,
    candidates: usize,
    initial_pose: [f64; 3],
    seed: u64,
}

impl<T: Real> OverModels<T> for Start<T> {
    type Output = Box<dyn Transparent>;

    fn over<M: PlanarMotion<T> + 'static>(self, models: PlanarModels<T, M>) -> Result<Self::Output, Refusal> {
        let Self { config, candidates, initial_pose, seed } = self;
        Ok(match (config.particles, candidates) {
            (..=32, ..=64) => {
                Box::new(CoreFilter::<T, M, 32, 64, 16_384, 512>::start(models, config, initial_pose, seed)?)
            }
            (..=128, ..=256) => {
                Box::new(CoreFilter::<T, M, 128, 256, 16_384, 256>::start(models, config, initial_pose, seed)?)
            }
            _ => Box::new(CoreFilter::<T, M, 1024, 2048, 65_535, 512>::start(models, config, initial_pose, seed)?),
        })
    }
}

/// The sensor of these settings.
///
/// # Errors
/// The noise is not one the sensor can work with.
pub(crate) fn range_bearing<T: Real>(sensor: &SensorSettings) -> Result<RangeBearing<T>, Refusal> {
    RangeBearing::new(T::from_f64(sensor.range_sigma_m), T::from_f64(sensor.bearing_sigma_rad)).map_err(refusal)
}

fn limits<T: Real>(sensor: &SensorSettings) -> RangeBearingLimits<T> {
    RangeBearingLimits {
        range_min_m: T::from_f64(sensor.range_min_m),
        range_max_m: T::from_f64(sensor.range_max_m),
        range_edge_m: T::from_f64(sensor.range_edge_m),
        bearing_center_rad: T::from_f64(sensor.bearing_center_rad()),
        bearing_half_width_rad: T::from_f64(sensor.bearing_half_width_rad()),
        bearing_edge_rad: T::from_f64(sensor.bearing_edge_rad),
        probability_near: T::from_f64(sensor.detection_near),
        probability_far: T::from_f64(sensor.detection_far),
    }
}
