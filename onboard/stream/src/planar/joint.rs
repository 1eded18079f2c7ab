//! The joint map of a planar vehicle on board.

use super::onboard::{Direct, Drive, MEASUREMENTS, PlanarSensing, detector, motion, start};
use super::{Odometry, Planar, Sensor};
use crate::header::Header;
use crate::onboard::{Aboard, Capacities, Filter, Helm, Ram, RamPart, Refusal, Scan, Seen, lower, moved};
use crate::record::Measurements;
use nalgebra::Vector2;
use scphd::diagnostics::{Probe, Stage};
use scphd::models::{PlanarPose, Pose};
use scphd::settings::Persistence;
use scphd::storage::joint_numbers;
use scphd::{Detector, JointConfig, JointReport, JointSlam, JointState, Real};

/// Capacity of the joint map, features.
pub(super) const FEATURES: usize = if cfg!(feature = "small-pools") { 16 } else { 64 };

type OnboardState<T> = JointState<PlanarPose<T>, Vector2<T>, FEATURES, { joint_numbers(3, 2, FEATURES) }, MEASUREMENTS>;

/// The filter with a joint map, for streams of planar vehicles.
#[derive(Debug, Clone, Copy)]
pub struct PlanarJoint;

/// All memory of the joint map on board, with a received scan.
#[derive(Debug)]
pub struct Memory<T: Real> {
    state: OnboardState<T>,
    measurements: [Vector2<T>; MEASUREMENTS],
}

/// The joint map, with the memory of its inputs.
#[derive(Debug)]
pub struct OnboardJoint<'m, T: Real> {
    pub(super) filter: JointSlam<'m, Drive<T>, Vector2<T>>,
    pub(super) detector: Detector<PlanarSensing<T>>,
    pub(super) measurements: &'m mut [Vector2<T>],
}

impl<T: Real> Aboard<T> for PlanarJoint {
    type Kind = Planar;
    type Memory = Memory<T>;
    type Filter<'m>
        = OnboardJoint<'m, T>
    where
        T: 'm;

    const MEMORY: Memory<T> =
        Memory { state: JointState::new(), measurements: [Vector2::new(T::ZERO, T::ZERO); MEASUREMENTS] };
    const CAPACITIES: Capacities = Capacities {
        candidates: 1,
        particles: 1,
        components: FEATURES,
        components_in_all: FEATURES,
        measurements: MEASUREMENTS,
    };
    const RAM_PARTS: [RamPart; 6] = Ram {
        total: size_of::<Memory<T>>(),
        state: size_of::<OnboardState<T>>(),
        particles: 0,
        pages: 0,
        moving_pages: 0,
        scratch: 0,
    }
    .parts();

    fn start<'m>(header: &Header<Planar>, memory: &'m mut Memory<T>) -> Result<OnboardJoint<'m, T>, Refusal>
    where
        T: 'm,
    {
        let Memory { state, measurements } = memory;
        let mut filter = JointSlam::new(motion(header, 1.0)?, config(header), state)?;
        let detector = detector(&Sensor::first(header))?;
        filter.reset(start(header))?;
        Ok(OnboardJoint { filter, detector, measurements })
    }
}

impl<T: Real> OnboardJoint<'_, T> {
    /// The results of a scan.
    pub(super) fn seen(&self, report: &JointReport<T>) -> Seen {
        Seen {
            health: report.health.bits(),
            in_view: report.in_view as u32,
            maps_updated: 1,
            pages_used: self.filter.held() as u32,
            pages: FEATURES as u32,
        }
    }
}

pub(super) fn config<T: Real>(header: &Header<Planar>) -> JointConfig<T> {
    let joint = &header.joint;
    JointConfig {
        persistence: Persistence {
            visible_s: T::from_f64(joint.visible_s),
            occluded_s: T::from_f64(joint.occluded_s),
            lifetime_s: T::from_f64(joint.lifetime_s),
        },
        occlusion_factor: T::from_f64(joint.occlusion_factor),
        merge_distance: T::from_f64(joint.merge_distance),
        ..JointConfig::default()
    }
}

impl<T: Real> Filter<Planar> for OnboardJoint<'_, T> {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), Refusal> {
        if let Some((control, dt)) = Direct.control(odometry).map_err(Refusal::Predict)? {
            moved(self.filter.predict(&control, dt))?;
        }
        Ok(())
    }

    fn receive(&mut self, measurements: Measurements<'_, Planar>) -> Scan {
        Scan::received(measurements, self.measurements)
    }

    fn scan_with(&mut self, scan: Scan, probe: &mut impl Probe) -> Result<Seen, Refusal> {
        if !scan.is_plain() {
            return Err(Refusal::NotAboard);
        }
        let measurements = scan.of(self.measurements).map_err(Refusal::Scan)?;
        // A joint map has only one stage.
        probe.enter(Stage::Update);
        let report = self.filter.scan(&self.detector, measurements);
        probe.leave(Stage::Update);
        Ok(self.seen(&report.map_err(Refusal::Scan)?))
    }

    fn estimate(&mut self) -> ([f64; 3], usize) {
        let pose = self.filter.estimate_pose().map_or(PlanarPose::ZERO, |pose| pose.mean);
        ([pose.x_m, pose.y_m, pose.heading_rad].map(T::to_f64), self.filter.features().count())
    }

    fn estimate_pose(&self) -> ([f64; 3], [f64; 6]) {
        let Some(pose) = self.filter.estimate_pose() else { return ([0.0; 3], [0.0; 6]) };
        let PlanarPose { x_m, y_m, heading_rad } = pose.mean;
        ([x_m, y_m, heading_rad].map(T::to_f64), lower::<Planar, _>(pose.covariance.as_lower()))
    }

    fn digest(&self) -> u64 {
        self.filter.digest()
    }
}
