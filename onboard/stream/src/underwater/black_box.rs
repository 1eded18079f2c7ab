//! The filter of an underwater vehicle that processes all records of a black box.

use super::onboard::{MEASUREMENTS, Memory};
use super::{AuvModels, Fix, Underwater};
use crate::black_box::{BlackBoxFilter, Modelled, Observes};
use crate::header::Header;
use crate::onboard::{Aboard, Capacities, RamPart, Refusal, births};
use scphd::models::{Auv, AuvPose, ModelError, Sensing, StereoCamera, StereoFrustum, UniformClutter};
use scphd::navigation::Navigator;
use scphd::{Detector, Real};

/// The mixture filter for black boxes of underwater vehicles: one detector, fixes, and all other records.
#[derive(Debug, Clone, Copy)]
pub struct BlackBox;

/// Models of the camera.
type StereoSensing<T> = Sensing<StereoCamera<T>, StereoFrustum<T>, UniformClutter<T>>;

impl<T: Real> Modelled<T> for Underwater {
    type Motion = Auv<T>;
    type Helm = Navigator<f64>;
    type Sensing = StereoSensing<T>;

    fn motion(header: &Header<Self>) -> Result<Auv<T>, ModelError> {
        Ok(header.models.of_filter()?.motion)
    }

    fn steer(helm: &mut Navigator<f64>, header: &Header<Self>) -> Result<(), ModelError> {
        helm.retune(header.models.velocity_noise())
    }

    fn first(header: &Header<Self>) -> Result<Detector<StereoSensing<T>>, Refusal> {
        let AuvModels { sensing, .. } = header.models.of_filter()?;
        Ok(Detector::new(sensing, births(header))?)
    }

    fn other(_sensor: &[f64; 0]) -> Result<Detector<StereoSensing<T>>, Refusal> {
        Err(Refusal::NotAboard)
    }

    fn observe(filter: &mut impl Observes<AuvPose<T>>, fix: &Fix) -> Result<(), Refusal> {
        fix.shown(filter)
    }
}

impl<T: Real> Aboard<T> for BlackBox {
    type Kind = Underwater;
    type Memory = Memory<T>;
    type Filter<'m>
        = BlackBoxFilter<'m, Underwater, T, MEASUREMENTS, 0>
    where
        T: 'm;

    const MEMORY: Memory<T> = <Underwater as Aboard<T>>::MEMORY;
    const CAPACITIES: Capacities = <Underwater as Aboard<T>>::CAPACITIES;
    const RAM_PARTS: [RamPart; 6] = <Underwater as Aboard<T>>::RAM_PARTS;

    fn start<'m>(header: &Header<Underwater>, memory: &'m mut Memory<T>) -> Result<Self::Filter<'m>, Refusal>
    where
        T: 'm,
    {
        memory.state.clear();
        let first = <Underwater as Aboard<T>>::start(header, memory)?;
        Ok(BlackBoxFilter { first, others: [] })
    }
}
