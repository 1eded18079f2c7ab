//! The joint map of an underwater vehicle on board.

use super::onboard::{MEASUREMENTS, StereoSensing, other_filter, parts, told};
use super::{Navigation, Underwater};
use crate::Parameters;
use crate::onboard::{Aboard, Capacities, Filter, Ram, RamPart, Refusal, Scan, Seen, moved, zero};
use crate::record::Measurements;
use nalgebra::Vector4;
use scphd::diagnostics::{Probe, Stage};
use scphd::models::{Auv, AuvPose};
use scphd::navigation::Navigator;
use scphd::settings::Persistence;
use scphd::storage::joint_numbers;
use scphd::{Detector, JointConfig, JointSlam, JointState, Real};
use scphd_vehicle as vehicle;

/// Capacity of the joint map, features.
const FEATURES: usize = 128;

/// The filter with a joint map, for streams of underwater vehicles.
#[derive(Debug, Clone, Copy)]
pub struct UnderwaterJoint;

/// Most measurements of a stereo camera under water are clutter, which would fill the map. Features remain and stay visible: a
/// missed feature was not matched, and one behind it is visible nevertheless.
#[must_use]
pub fn joint_config<T: Real>() -> JointConfig<T> {
    JointConfig { persistence: Persistence::FOR_EVER, occlusion_factor: T::ONE, ..JointConfig::strict() }
}

/// All memory of the joint map: its state, and the received scan.
#[derive(Debug)]
pub struct JointMemory<T: Real> {
    state: JointState<AuvPose<T>, Vector4<T>, FEATURES, { joint_numbers(5, 3, FEATURES) }, MEASUREMENTS>,
    measurements: [Vector4<T>; MEASUREMENTS],
}

/// The joint map with the memory of received measurements and the velocity filter.
#[derive(Debug)]
pub struct OnboardJoint<'m, T: Real> {
    filter: JointSlam<'m, Auv<T>, Vector4<T>>,
    detector: Detector<StereoSensing<T>>,
    navigator: Navigator<f64>,
    measurements: &'m mut [Vector4<T>],
}

impl<T: Real> Aboard<T> for UnderwaterJoint {
    type Kind = Underwater;
    type Memory = JointMemory<T>;
    type Filter<'m>
        = OnboardJoint<'m, T>
    where
        T: 'm;

    const MEMORY: JointMemory<T> = JointMemory { state: JointState::new(), measurements: [zero(); MEASUREMENTS] };
    const CAPACITIES: Capacities = Capacities {
        candidates: 1,
        particles: 1,
        components: FEATURES,
        components_in_all: FEATURES,
        measurements: MEASUREMENTS,
    };
    const RAM_PARTS: [RamPart; 6] = {
        let scan = size_of::<[Vector4<T>; MEASUREMENTS]>();
        Ram::of_joint(size_of::<JointMemory<T>>(), size_of::<JointMemory<T>>() - scan).parts()
    };

    fn start<'m>(
        head: &impl Parameters<Underwater>,
        memory: &'m mut JointMemory<T>,
    ) -> Result<Self::Filter<'m>, Refusal>
    where
        T: 'm,
    {
        let JointMemory { state, measurements } = memory;
        let models = head.models();
        let (vehicle::Filter::Joint(joint), _, motion, detector) = parts(head, &models)? else {
            return Err(other_filter());
        };
        let mut filter = JointSlam::new(motion, joint.config, state)?;
        filter.reset(models.start())?;
        Ok(OnboardJoint { filter, detector, navigator: models.navigator()?, measurements })
    }
}

impl<T: Real> Filter<Underwater> for OnboardJoint<'_, T> {
    fn predict(&mut self, input: &Navigation) -> Result<(), Refusal> {
        if let Some((control, dt)) = input.control(&mut self.navigator).map_err(Refusal::Predict)? {
            moved(self.filter.predict(&control, dt))?;
        }
        Ok(())
    }

    fn receive(&mut self, measurements: Measurements<'_, Underwater>) -> Scan {
        Scan::received(measurements, self.measurements)
    }

    fn scan_with(&mut self, scan: Scan, probe: &mut impl Probe) -> Result<Seen, Refusal> {
        if !scan.is_plain() {
            return Err(Refusal::NotAboard);
        }
        let measurements = scan.of(self.measurements)?;
        // A joint map has only one stage.
        probe.enter(Stage::Update);
        let report = self.filter.scan(&self.detector, measurements);
        probe.leave(Stage::Update);
        Ok(Seen::of_joint(&report?, self.filter.held(), FEATURES))
    }

    fn estimate(&mut self) -> ([f64; 5], usize) {
        (told(self.filter.estimate_pose()).0, self.filter.features().count())
    }

    fn estimate_pose(&self) -> ([f64; 5], [f64; 15]) {
        told(self.filter.estimate_pose())
    }

    fn digest(&self) -> u64 {
        self.filter.digest()
    }
}
