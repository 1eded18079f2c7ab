//! The settings of a run as plain numbers, and the filter made from them.

use crate::buffer::{Run, Setup, Status};
use crate::memory::{Particles, Slot};
use core::array::from_fn;
use nalgebra::Vector2;
use scphd::models::{
    PlanarControl, PlanarMotion, PlanarPose, RangeBearing, RangeBearingWindow, RangeNoise, UniformClutter, WithNoise,
};
use scphd::storage::ScanRoom;
use scphd::{Detector, ScPhd};
use scphd_vehicle::{Control, Description, Filter as Tuning, Polar, Setting, VehicleKind};

/// The sensor of a run.
pub(crate) type Sighting = Polar<PlanarPose<f32>, f32>;

/// The numbers of a description.
pub fn setup_of(description: &Description<f32>) -> Setup {
    from_fn(|place| {
        let setting = u32::try_from(place + 1).ok().and_then(Setting::of_number);
        setting.and_then(|setting| description.get(setting, 0)).unwrap_or(f32::NAN)
    })
}

/// Sets these numbers of a description. Returns its motion model and its sensor; `None` if a number is out of range.
pub(crate) fn describe(description: &mut Description<f32>, setup: &Setup) -> Option<(PlanarMotion<f32>, Sighting)> {
    // A part is there before its settings, except for the sensor, whose model is in the list behind them all.
    for (setting, &number) in Setting::all().zip(setup).filter(|(_, number)| !number.is_nan()) {
        description.set(setting, 0, number).ok()?;
    }
    let sensor = description.sensors.first()?.as_ref()?.polar::<PlanarPose<f32>>().ok()?;
    Some((description.vehicle.drive().ok()?, sensor))
}

/// A filter over a slot's state, of any capacities.
pub type Filter<'s> = ScPhd<'s, PlanarMotion<f32>>;
/// The models of a sensor.
pub type Sensing =
    scphd::models::Sensing<WithNoise<RangeBearing<f32>, RangeNoise<f32>>, RangeBearingWindow<f32>, UniformClutter<f32>>;
/// The sensor of a run.
pub type Sighted<'s> = Detector<Sensing, ScanRoom<'s, Vector2<f32>>>;

/// The started filter and the sensor over a slot, or the code of a [`Status`].
pub fn over<'s, M: Particles>(run: &Run, slot: &'s mut Slot<M>) -> Result<(Filter<'s>, Sighted<'s>), u32> {
    let Slot { memory, scratch, .. } = slot;
    let refused = Status::SETUP;
    let mut description = Description::robot();
    let (motion, sensor) = describe(&mut description, &run.setup).ok_or(refused)?;
    let Tuning::Mixture(config) = description.filter else { return Err(refused) };
    let mut filter = memory.filter(motion, config).map_err(|_| refused)?;
    let detector = Sighting::over(sensor, scratch).map_err(|_| refused)?;
    filter.check(&detector).map_err(|_| refused)?;
    filter.reset(description.start.pose, bytemuck::cast(run.seed)).map_err(|_| refused)?;
    Ok((filter, detector))
}

/// The control of a vehicle from a row of odometry: speed, turn, and speed to the left.
pub fn control_of(motion: &PlanarMotion<f32>, [speed_mps, turn, left_mps]: [f32; 3]) -> PlanarControl<f32> {
    let kind = match motion {
        PlanarMotion::Ackermann(_) => VehicleKind::Ackermann,
        PlanarMotion::Unicycle(_) => VehicleKind::Unicycle,
        PlanarMotion::Holonomic(_) => VehicleKind::Holonomic,
    };
    kind.control(&Control { speed_mps, left_mps, turn })
}

#[cfg(any(target_arch = "nvptx64", test))]
/// Random numbers that a sample of the motion uses: one for each number of the control.
pub(crate) fn numbers_of(motion: &PlanarMotion<f32>) -> usize {
    if matches!(motion, PlanarMotion::Holonomic(_)) { 3 } else { 2 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd::models::Motion;
    use scphd::numerics::Noise;
    use scphd_vehicle::Sensor;

    #[test]
    fn a_setup_has_everything_of_its_description() {
        let mut description = Description::<f32>::robot();
        description.sensors[0] = Some(Sensor::range_bearing(12.0, 0.7, [0.1, 0.03]));
        for joint in [true, false] {
            if !joint {
                description.filter = Tuning::Mixture(scphd::Config::default());
            }
            let mut found = Description::robot();
            assert!(describe(&mut found, &setup_of(&description)).is_some());
            assert_eq!(found, description);
        }
        description.sensors[0] = None;
        assert!(describe(&mut Description::robot(), &setup_of(&description)).is_none());
    }

    #[test]
    fn a_sample_uses_the_stated_number_of_random_numbers() {
        for kind in [VehicleKind::Ackermann, VehicleKind::Unicycle, VehicleKind::Holonomic] {
            let mut vehicle = Description::<f32>::robot().vehicle;
            vehicle.kind = kind;
            let motion = vehicle.drive().unwrap();
            let (mut drawn, mut skipped) = (Noise::seeded(3), Noise::seeded(3));
            let control = control_of(&motion, [1.0, 0.1, 0.0]);
            motion.sample(&PlanarPose::new(0.0, 0.0, 0.0), &control, 0.1, &mut drawn);
            skipped.skip(numbers_of(&motion));
            assert_eq!(drawn, skipped);
        }
    }
}
