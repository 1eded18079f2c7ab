//! Any vehicle in the plane as one motion, so that a module has one kernel for all.

use scphd::{
    Ackermann, AckermannControl, Linearised, ModelError, Motion, Noise, PlanarPose, Rates, TangentOf, Unicycle,
    UnicycleControl,
};

/// How the vehicle of a run moves.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Vehicle {
    /// Controls are encoder speed, m/s, and steering angle, rad.
    Car(Ackermann<f32>),
    /// Controls are speed, m/s, and turn rate, rad/s.
    Robot(Unicycle<f32>),
}

/// Does the same with either, each with its own control.
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
