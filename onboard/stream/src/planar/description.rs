//! The head of a stream from the description of a vehicle.

use super::Planar;
use crate::header::Header;
use crate::scalar::Scalar;
use scphd::Real;
use scphd_vehicle::{Description, SensorModel};

/// The error of a description with a part that streams do not record: a replay would end in another state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("streams do not record {setting}")]
pub struct NotRecorded {
    /// The setting, or the group of settings.
    pub setting: &'static str,
}

impl Header<Planar> {
    /// The head for the recording of a filter that is built from a description, with numbers of type `scalar` in the records. What a
    /// monitor of fixes decides is recorded with [`Writer::place`](crate::Writer::place).
    ///
    /// # Errors
    /// A sensor measures bearings only: a measurement of a stream has a range, too.
    pub fn of<T: Real>(description: &Description<T>, scalar: Scalar) -> Result<Self, NotRecorded> {
        match description.sensors.iter().flatten().all(|sensor| sensor.model == SensorModel::RangeBearing) {
            true => Ok(Self::with(description, [], scalar)),
            false => Err(NotRecorded { setting: "bearings" }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd::Config;
    use scphd_vehicle::{Filter, Sensor};
    use std::string::ToString;

    #[test]
    fn a_description_comes_back_from_its_head() {
        let mut robot = Description::<f32>::robot();
        robot.sensors[2] = Some(Sensor { range_sigma_ratio: 0.1, ..Sensor::range_bearing(12.0, 0.9, [0.1, 0.01]) });
        robot.filter = Filter::Mixture(Config { births_wait: true, samples: 3, ..Config::informed(5) });
        robot.start.seed = u64::MAX;
        let head = Header::of(&robot, Scalar::F32).unwrap();
        assert_eq!((head.description(), head.scalar), (Ok(robot), Scalar::F32));
        robot.sensors[1] = Some(Sensor { model: SensorModel::Bearing, ..robot.sensors[2].unwrap() });
        let refused = Header::of(&robot, Scalar::F32).unwrap_err();
        assert_eq!(refused.to_string(), "streams do not record bearings");
    }
}
