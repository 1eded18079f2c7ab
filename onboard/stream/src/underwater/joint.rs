//! The joint map of an underwater vehicle on board.

use super::onboard::MEASUREMENTS;
use super::{AuvModels, Underwater};
use crate::header::Header;
use crate::joint::{self, JointMemory, OnboardJoint};
use crate::onboard::{Aboard, Capacities, RamPart, Refusal, births};
use nalgebra::Vector4;
use scphd::models::{Auv, AuvPose, Sensing, StereoCamera, StereoFrustum, UniformClutter};
use scphd::navigation::Navigator;
use scphd::settings::Persistence;
use scphd::storage::{NoMovers, joint_numbers};
use scphd::{Detector, JointConfig, JointSlam, JointState, Real};

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

impl<T: Real> Aboard<T> for UnderwaterJoint {
    type Kind = Underwater;
    type Memory = JointMemory<
        JointState<AuvPose<T>, Vector4<T>, FEATURES, { joint_numbers(5, 3, FEATURES) }, MEASUREMENTS>,
        (),
        Vector4<T>,
        MEASUREMENTS,
    >;
    type Filter<'m>
        = OnboardJoint<
        'm,
        Underwater,
        Navigator<f64>,
        JointSlam<'m, Auv<T>, Vector4<T>>,
        Sensing<StereoCamera<T>, StereoFrustum<T>, UniformClutter<T>>,
    >
    where
        T: 'm;

    const MEMORY: Self::Memory = JointMemory::with(JointState::new(), ());
    const CAPACITIES: Capacities = joint::capacities(FEATURES, MEASUREMENTS);
    const RAM_PARTS: [RamPart; 6] = <Self::Memory>::RAM_PARTS;

    fn start<'m>(header: &Header<Underwater>, memory: &'m mut Self::Memory) -> Result<Self::Filter<'m>, Refusal>
    where
        T: 'm,
    {
        let JointMemory { state, parts, measurements } = memory;
        let AuvModels { motion, sensing } = header.models.of_filter()?;
        let map = JointSlam::new(motion, header.joint.config(), state)?;
        let seated = (Detector::new(sensing, births(header))?, header.models.navigator()?);
        let start = header.models.start();
        OnboardJoint::start::<_, NoMovers>(map, (parts, header), seated, (measurements, FEATURES), start)
    }
}
