//! Random configurations with all proposals and options.

use super::draw::Draw;
use scphd::models::ConstantVelocity;
use scphd::settings::{Extraction, Informed, MovingConfig, Plausible, Proposal};
use scphd::{Births, Config, Real};

/// Capacities of a state.
#[derive(Debug, Clone, Copy)]
pub struct Room {
    pub particles: usize,
    /// Particles times samples.
    pub candidates: usize,
    pub measurements: usize,
    /// Whether there is memory for moving features.
    pub moving: bool,
}

/// A random configuration for a state; out of range if one of its numbers is hostile.
pub fn config<T: Real>(draw: &mut Draw, room: Room) -> Config<T> {
    let number = T::from_f64;
    let particles = 1 + draw.below(room.particles);
    Config {
        particles,
        samples: 1 + draw.below(room.candidates / particles),
        proposal: if draw.chance(0.5) { Proposal::Blind } else { Proposal::Informed(informed(draw)) },
        resample_threshold: draw.real(0.0, 1.0),
        prune_weight: number(draw.magnitude(1e-6, 0.1)),
        confirming_detections: draw.real(1.0, 5.0),
        unconfirmed_weight: if draw.chance(0.5) { T::ZERO } else { draw.real(0.0, 1.0) },
        confirmed_weight: if draw.chance(0.5) { T::ZERO } else { draw.real(0.0, 1.0) },
        merge_distance: draw.real(0.0, 9.0),
        max_components: if draw.chance(0.5) { usize::MAX } else { 1 + draw.below(20) },
        extraction: [Extraction::Heaviest, Extraction::Peaks, Extraction::Confirmed][draw.below(3)],
        extraction_weight: draw.real(0.0, 1.0),
        births_wait: draw.chance(0.5),
        moving: if room.moving && draw.chance(0.5) { moving(draw) } else { MovingConfig::walkers() },
        plausible: if draw.chance(0.8) { Plausible::default() } else { Plausible::ANYTHING },
        ..Config::default()
    }
}

/// A random birth intensity; out of range if one of its numbers is hostile.
pub fn births<T: Real>(draw: &mut Draw, room: Room) -> Births<T> {
    let number = T::from_f64;
    Births {
        of_static: if draw.chance(0.1) { T::ZERO } else { number(draw.magnitude(1e-6, 0.5)) },
        of_moving: if room.moving && draw.chance(0.5) { number(draw.magnitude(1e-6, 0.1)) } else { T::ZERO },
    }
}

fn informed<T: Real>(draw: &mut Draw) -> Informed<T> {
    let drawn = [0.0, 1.0, draw.even(0.0, 1.0)][draw.below(3)];
    Informed {
        rounds: 1 + draw.below(4),
        sampled_fraction: T::from_f64(draw.spoilt(drawn)),
        min_responsibility: T::from_f64(draw.magnitude(1e-4, 0.5)),
    }
}

fn moving<T: Real>(draw: &mut Draw) -> MovingConfig<T> {
    MovingConfig {
        velocity_sigma_mps: draw.real(0.1, 5.0),
        motion: ConstantVelocity {
            acceleration_psd: T::from_f64(draw.magnitude(1e-4, 10.0)),
            lifetime_s: if draw.chance(0.2) { T::INFINITY } else { draw.real(1.0, 100.0) },
        },
        spread_max_m: draw.real(0.5, 10.0),
        extraction_weight: draw.real(0.0, 1.0),
    }
}
