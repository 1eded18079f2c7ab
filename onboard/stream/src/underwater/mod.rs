//! Streams of underwater vehicles with a stereo camera.

mod fix;
mod joint;
mod models;
mod onboard;

pub use fix::{Fix, Of};
pub use joint::{UnderwaterJoint, joint_config};
pub use models::{AuvModels, Models};
pub use onboard::{BlackBox, MEASUREMENTS, Memory};

use crate::kind::{Input, Kind};
use crate::numbers::Numbers;
use crate::scalar::Scalar;
use scphd::Real;
use scphd::errors::PredictError;
use scphd::models::{AuvControl, Reading};
use scphd::navigation::{Instruments, Navigator};

/// The kind of streams of underwater vehicles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Underwater;

/// A prediction, usually with readings of the instruments.
///
/// The readings are recorded in double precision in every stream: the velocity filter runs in the replay, in double precision for
/// any precision of the particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Navigation {
    /// Its duration, s.
    pub dt_s: f64,
    /// The readings; `None` at an image between two rows of readings.
    pub instruments: Option<Instruments<f64>>,
}

impl Navigation {
    /// The control by the velocity filter, with its duration, s; `None` if no time has passed.
    ///
    /// # Errors
    /// A reading is invalid; the state of the velocity filter is unchanged.
    pub fn control<T: Real>(&self, navigator: &mut Navigator<f64>) -> Result<Option<(AuvControl<T>, T)>, PredictError> {
        let control = match &self.instruments {
            Some(row) => navigator.instruments(row, self.dt_s),
            None => navigator.onward(self.dt_s),
        };
        Ok(control?.map(|control| (control.rounded(), T::from_f64(self.dt_s))))
    }
}

impl Kind for Underwater {
    type Models = Models;
    type Input = Navigation;
    /// Column and row in the left and in the right image, px.
    type Measurement = [f64; 4];
    /// x, y, z (m), yaw (rad) and yaw rate (rad/s).
    type Pose = [f64; 5];
    type Fix = Fix;
    /// The capacity is one camera.
    type Sensor = [f64; 0];
    /// x, y, z (m), yaw, yaw rate, roll and pitch (rad, rad/s).
    type Full = [f64; 7];
    type Covariance = [f64; 15];
    type Feature = [f64; 11];

    const DETECTORS: u8 = 1;
    const CODE: u8 = 3;
}

/// Roll, pitch, yaw rate and its standard deviation.
const INERTIAL: u8 = 1;
/// Three velocities.
const VELOCITY: u8 = 2;
/// z.
const DEPTH: u8 = 4;

impl Input for Navigation {
    fn parts(&self) -> u8 {
        self.instruments.map_or(0, |row| {
            let velocity = row.velocity_mps.map_or(0, |_| VELOCITY);
            INERTIAL | velocity | row.z_m.map_or(0, |_| DEPTH)
        })
    }

    fn count(parts: u8) -> Option<usize> {
        let has = |part: u8, count: usize| if parts & part == 0 { 0 } else { count };
        // Readings of the Doppler log and the pressure sensor come with those of the inertial unit.
        let known = parts == 0 || parts & INERTIAL != 0 && parts <= INERTIAL | VELOCITY | DEPTH;
        known.then(|| 1 + has(INERTIAL, 4) + has(VELOCITY, 3) + has(DEPTH, 1))
    }

    fn scalar(_of_stream: Scalar) -> Scalar {
        Scalar::F64
    }

    fn put(&self, sink: &mut impl FnMut(f64)) {
        sink(self.dt_s);
        if let Some(Instruments { roll_rad, pitch_rad, yaw_rate_radps, velocity_mps, z_m }) = self.instruments {
            [roll_rad, pitch_rad, yaw_rate_radps.value, yaw_rate_radps.sigma].put(sink);
            velocity_mps.iter().for_each(|velocity| velocity.put(sink));
            z_m.iter().for_each(|z| z.put(sink));
        }
    }

    fn take(parts: u8, source: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        let dt_s = source()?;
        if parts & INERTIAL == 0 {
            return Some(Self { dt_s, instruments: None });
        }
        let [roll_rad, pitch_rad, value, sigma] = Numbers::take(source)?;
        let yaw_rate_radps = Reading { value, sigma };
        let velocity_mps = if parts & VELOCITY == 0 { None } else { Some(Numbers::take(source)?) };
        let z_m = if parts & DEPTH == 0 { None } else { Some(source()?) };
        Some(Self { dt_s, instruments: Some(Instruments { roll_rad, pitch_rad, yaw_rate_radps, velocity_mps, z_m }) })
    }
}
