//! The simulated world: landmarks, walkers, the vehicle and its odometry.

use crate::drive::{Autopilot, Wish};
use scphd::Real;
use scphd::models::{ControlNoise, Motion, PlanarPose, Step, Unicycle, UnicycleControl};
use scphd::numerics::Noise;

/// Time between scans, s.
pub const INTERVAL_S: f32 = 0.05;
/// Number of landmarks.
pub const LANDMARKS: usize = 48;
/// Number of walkers.
pub const MOVERS: usize = 4;

/// Half sizes of the area, m. The vehicle stops at its edge.
const HALF_SIZES_M: [f32; 2] = [45.0, 32.0];
/// Minimum distance of landmarks, m, if one of these tries finds such a place.
const APART_M: f32 = 4.0;
const TRIES: usize = 64;
/// Speed of walkers, m/s.
const WALK_MPS: f32 = 1.2;
/// Odometry errors of worn wheels: relative errors of speed and turn rate, and standard deviations of white noise, m/s and rad/s.
const WORN: [f32; 2] = [0.04, 0.03];
const WHITE: [f32; 2] = [0.2, 0.03];

/// Someone who walks back and forth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Walker {
    pub(crate) place: [f32; 2],
    velocity: [f32; 2],
}

/// The true state of the world.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    pub(crate) landmarks: [[f32; 2]; LANDMARKS],
    pub(crate) walkers: [Walker; MOVERS],
    pub(crate) pose: PlanarPose<f32>,
    /// The pose of odometry alone.
    pub(crate) reckoned: PlanarPose<f32>,
    autopilot: Autopilot,
    pub(crate) draws: Noise,
}

impl World {
    /// The world of a seed.
    #[must_use]
    pub fn of_seed(seed: u64) -> Self {
        let mut draws = Noise::seeded(seed);
        let mut landmarks = [[0.0; 2]; LANDMARKS];
        for made in 0..LANDMARKS {
            let mut place = somewhere(&mut draws);
            for _ in 0..TRIES {
                let near = |other: &[f32; 2]| distance_m(*other, place) < APART_M;
                if !landmarks.iter().take(made).any(near) {
                    break;
                }
                place = somewhere(&mut draws);
            }
            landmarks.iter_mut().skip(made).take(1).for_each(|slot| *slot = place);
        }
        let walkers = [Walker::default(); MOVERS].map(|_| {
            let (place, heading) = (somewhere(&mut draws), 2.0 * f32::PI * draws.uniform::<f32>());
            let (sine, cosine) = Real::sin_cos(heading);
            Walker { place, velocity: [WALK_MPS * cosine, WALK_MPS * sine] }
        });
        let pose = Self::START;
        Self { landmarks, walkers, pose, reckoned: pose, autopilot: Autopilot::default(), draws }
    }

    /// The start pose of every drive.
    pub(crate) const START: PlanarPose<f32> = PlanarPose::new(0.0, 0.0, 0.6);

    /// Advances by an interval. Returns the odometry.
    pub(crate) fn advance(&mut self, exact: &Unicycle<f32>, wish: Wish) -> UnicycleControl<f32> {
        for Walker { place, velocity } in &mut self.walkers {
            for ((place, velocity), half) in place.iter_mut().zip(velocity).zip(HALF_SIZES_M) {
                *place += *velocity * INTERVAL_S;
                if *place * *velocity > half * velocity.abs() {
                    *velocity = -*velocity;
                }
            }
        }
        let mut control = self.autopilot.control(&self.pose, wish);
        let next = exact.propagate(&self.pose, &control, INTERVAL_S);
        if next.x_m.abs() <= HALF_SIZES_M[0] && next.y_m.abs() <= HALF_SIZES_M[1] {
            self.pose = next;
        } else {
            // Turns in place.
            control.speed_mps = 0.0;
            self.pose = exact.propagate(&self.pose, &control, INTERVAL_S);
        }
        let mut told = |truth: f32, which: usize| {
            let at = |pair: [f32; 2]| if which == 0 { pair[0] } else { pair[1] };
            truth * (1.0 + at(WORN)) + at(WHITE) * self.draws.normal::<f32>()
        };
        let odometry =
            UnicycleControl { speed_mps: told(control.speed_mps, 0), rate_radps: told(control.rate_radps, 1) };
        self.reckoned = exact.propagate(&self.reckoned, &odometry, INTERVAL_S);
        odometry
    }

    /// A motion without noise.
    ///
    /// # Errors
    /// An error of the model; never with this noise.
    pub(crate) fn exact() -> Result<Unicycle<f32>, scphd::models::ModelError> {
        Unicycle::new(Step::Arc, ControlNoise::NONE)
    }
}

fn somewhere(draws: &mut Noise) -> [f32; 2] {
    HALF_SIZES_M.map(|half| half * (2.0 * draws.uniform::<f32>() - 1.0))
}

pub(crate) fn distance_m(a: [f32; 2], b: [f32; 2]) -> f32 {
    let off = [a[0] - b[0], a[1] - b[1]];
    Real::sqrt(off[0] * off[0] + off[1] * off[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vehicle_and_walkers_stay_in_the_area() {
        let mut world = World::of_seed(3);
        let exact = World::exact().unwrap();
        for _ in 0..20_000 {
            world.advance(&exact, Wish::Manual { speed_mps: 8.0, rate_radps: 0.01 });
            let pose = [world.pose.x_m, world.pose.y_m];
            for place in world.walkers.iter().map(|walker| walker.place).chain([pose]) {
                assert!(place[0].abs() < HALF_SIZES_M[0] + 0.1 && place[1].abs() < HALF_SIZES_M[1] + 0.1, "{place:?}");
            }
        }
    }

    #[test]
    fn landmarks_are_apart_and_depend_on_the_seed() {
        let world = World::of_seed(1);
        for (index, a) in world.landmarks.iter().enumerate() {
            assert!(world.landmarks[..index].iter().all(|b| distance_m(*a, *b) >= APART_M));
        }
        assert_eq!(world, World::of_seed(1));
        assert_ne!(world.landmarks, World::of_seed(2).landmarks);
    }
}
