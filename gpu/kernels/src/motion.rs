//! One motion model for all vehicles in the plane, so that a module needs only one kernel for them.

use scphd::models::{
    Ackermann, AckermannControl, Linearised, ModelError, Motion, PlanarPose, Rates, TangentOf, Unicycle,
    UnicycleControl,
};
use scphd::numerics::Noise;

/// How the vehicle of a run moves.
#[derive(Debug, Clone, Copy)]
pub enum Vehicle {
    /// Controls are encoder speed, m/s, and steering angle, rad.
    Car(Ackermann<f32>),
    /// Controls are speed, m/s, and turn rate, rad/s.
    Robot(Unicycle<f32>),
}

impl Vehicle {
    /// Random numbers that a sample of either vehicle uses: one for the speed, and one for the turn.
    pub(crate) const NUMBERS: usize = 2;
}

/// Evaluates the same expression for either vehicle, with its own type of control.
macro_rules! either {
    ($vehicle:expr, $control:expr, $motion:ident, $own:ident => $done:expr) => {{
        let [speed_mps, turn] = *$control;
        match $vehicle {
            Vehicle::Car($motion) => {
                let $own = &AckermannControl { speed_mps, steering_rad: turn };
                $done
            }
            Vehicle::Robot($motion) => {
                let $own = &UnicycleControl { speed_mps, rate_radps: turn };
                $done
            }
        }
    }};
}

impl Motion for Vehicle {
    type Pose = PlanarPose<f32>;
    type Control = [f32; 2];

    const TRANSLATION_INVARIANT: bool = true;

    fn check(&self) -> Result<(), ModelError> {
        match self {
            Self::Car(motion) => motion.check(),
            Self::Robot(motion) => motion.check(),
        }
    }

    fn admits(&self, control: &[f32; 2]) -> bool {
        either!(self, control, motion, control => motion.admits(control))
    }

    fn rates(&self, control: &[f32; 2]) -> Rates<f32> {
        either!(self, control, motion, control => motion.rates(control))
    }

    fn propagate(&self, pose: &PlanarPose<f32>, control: &[f32; 2], dt: f32) -> PlanarPose<f32> {
        either!(self, control, motion, control => motion.propagate(pose, control, dt))
    }

    fn sample(&self, pose: &PlanarPose<f32>, control: &[f32; 2], dt: f32, noise: &mut Noise) -> PlanarPose<f32> {
        either!(self, control, motion, control => motion.sample(pose, control, dt, noise))
    }

    fn linearise(&self, pose: &PlanarPose<f32>, control: &[f32; 2], dt: f32) -> Linearised<TangentOf<PlanarPose<f32>>> {
        either!(self, control, motion, control => motion.linearise(pose, control, dt))
    }
}

#[cfg(test)]
mod tests {
    use super::Vehicle;
    use scphd::models::{Ackermann, AckermannGeometry, ControlNoise, Motion, PlanarPose, Step, Unicycle};
    use scphd::numerics::Noise;

    #[test]
    fn a_sample_uses_the_stated_number_of_random_numbers() {
        let noise = ControlNoise::white(0.1, 0.02);
        let geometry =
            AckermannGeometry { wheelbase_m: 2.0, encoder_offset_m: 0.0, sensor_forward_m: 0.0, sensor_left_m: 0.0 };
        let car = Vehicle::Car(Ackermann::new(geometry, noise).unwrap());
        let robot = Vehicle::Robot(Unicycle::new(Step::Arc, noise).unwrap());
        for vehicle in [car, robot] {
            let (mut drawn, mut skipped) = (Noise::seeded(3), Noise::seeded(3));
            vehicle.sample(&PlanarPose::new(0.0, 0.0, 0.0), &[1.0, 0.1], 0.1, &mut drawn);
            skipped.skip(Vehicle::NUMBERS);
            assert_eq!(drawn, skipped);
        }
    }
}
