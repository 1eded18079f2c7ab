//! Control of the vehicle: by the user of the page, or on a figure of eight.

use scphd::Real;
use scphd::models::{PlanarPose, UnicycleControl};
use scphd::numerics::wrap;

/// Number of corners of the figure.
const CORNERS: u16 = 16;
/// Half length and half width of the figure, m.
const HALF_SIZES_M: [f32; 2] = [30.0, 20.0];
/// Speed along it, m/s.
const CRUISE_MPS: f32 = 4.0;
/// Distance at which a corner counts as reached, m.
const NEAR_M: f32 = 4.0;
/// Turn rate per angle to the next corner, 1/s.
const GAIN: f32 = 1.5;
/// Greatest speed, m/s, and turn rate, rad/s, of the vehicle.
const GREATEST: [f32; 2] = [8.0, 1.2];

/// The requested motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wish {
    /// The figure of eight, from the next corner on.
    Automatic,
    /// This speed, m/s, and turn rate, rad/s, within the vehicle's limits; not-a-number is 0.
    Manual {
        /// Speed, m/s.
        speed_mps: f32,
        /// Turn rate, rad/s, positive to the left.
        rate_radps: f32,
    },
}

/// The next corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Autopilot {
    corner: u16,
}

impl Autopilot {
    /// The next control of the vehicle.
    pub(crate) fn control(&mut self, pose: &PlanarPose<f32>, wish: Wish) -> UnicycleControl<f32> {
        match wish {
            Wish::Manual { speed_mps, rate_radps } => {
                let [speed_mps, rate_radps] = [(speed_mps, GREATEST[0]), (rate_radps, GREATEST[1])]
                    .map(|(asked, most)| if asked.is_finite() { asked.clamp(-most, most) } else { 0.0 });
                UnicycleControl { speed_mps, rate_radps }
            }
            Wish::Automatic => {
                let mut off = self.offset(pose);
                if Real::sqrt(off[0] * off[0] + off[1] * off[1]) < NEAR_M {
                    self.corner = (self.corner + 1) % CORNERS;
                    off = self.offset(pose);
                }
                let aside = wrap(Real::atan2(off[1], off[0]) - pose.heading_rad);
                let rate_radps = (GAIN * aside).clamp(-GREATEST[1], GREATEST[1]);
                UnicycleControl { speed_mps: CRUISE_MPS, rate_radps }
            }
        }
    }

    /// Vector from the vehicle to the corner, m.
    fn offset(self, pose: &PlanarPose<f32>) -> [f32; 2] {
        let turn = f32::from(self.corner + 1) * (2.0 * f32::PI / f32::from(CORNERS));
        let [(along, _), (across, _)] = [turn, 2.0 * turn].map(Real::sin_cos);
        [HALF_SIZES_M[0] * along - pose.x_m, HALF_SIZES_M[1] * across - pose.y_m]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_beyond_the_limits_are_clamped() {
        let wish = |speed_mps, rate_radps| {
            Autopilot::default().control(&PlanarPose::new(0.0, 0.0, 0.0), Wish::Manual { speed_mps, rate_radps })
        };
        let control = wish(1e9, -1e9);
        assert_eq!([control.speed_mps, control.rate_radps], [GREATEST[0], -GREATEST[1]]);
        let control = wish(f32::NAN, f32::INFINITY);
        assert_eq!([control.speed_mps, control.rate_radps], [0.0, 0.0]);
    }
}
