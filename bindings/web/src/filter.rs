//! The filter of a session: its memory, settings and models.

use crate::sensor::{MEASUREMENTS, RANGE_M, SIGMAS, Surroundings};
use nalgebra::{Vector2, Vector4};
use scphd::models::{
    ControlNoise, ModelError, RangeBearing, RangeBearingLimits, RangeBearingWindow, Sensing, Step, Unicycle,
    UniformClutter,
};
use scphd::numerics::Vector;
use scphd::settings::Extraction;
use scphd::{Births, Component, Config, DetectorMemory, ScPhd, memory};

/// Maximum number of particles.
pub const PARTICLES: usize = 64;

memory! {
    pub(crate) type Memory: Unicycle<f32> {
        particles: 64, samples: 1,
        features { pages: 1024, pages_per_map: 32, in_view: 256 },
        moving { pages: 512, pages_per_map: 16, in_view: 128 },
    }
}

pub(crate) type Filter<'m> = ScPhd<'m, Unicycle<f32>>;
/// Scratch memory for scans.
pub(crate) type Scratch = DetectorMemory<Vector2<f32>, MEASUREMENTS>;
pub(crate) type Features = Found<Vector2<f32>, 96>;
pub(crate) type Movers = Found<Vector4<f32>, 32>;

/// Odometry noise of the filter: the error of worn wheels is covered by noise with a correlation time of half a second and more.
const NOISE: ControlNoise<f32> = ControlNoise {
    speed_sigma_mps: 0.1,
    speed_sigma_ratio: 0.05,
    turn_sigma: 0.02,
    turn_sigma_ratio: 0.05,
    interval_s: 0.5,
};
/// Ratio of clutter to birth intensity of static features, and of the birth intensities of moving and static features.
const CLUTTER_OVER_BIRTH: f32 = 20.0;
const MOVING_SHARE: f32 = 0.3;
/// Least number of false measurements in a scan that the filter assumes; the birth intensity is proportional to it.
const LEAST_CLUTTER: f32 = 1.0;

/// An argument that is refused; the session is unchanged, or has to be started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refused;

/// Estimated features.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Found<N: Vector, const ROOM: usize> {
    pub(crate) features: [Component<N>; ROOM],
    pub(crate) found: usize,
}

impl<N: Vector, const ROOM: usize> Found<N, ROOM> {
    pub(crate) const NONE: Self = Self { features: [Component::ZERO; ROOM], found: 0 };

    pub(crate) fn found(&self) -> usize {
        self.found
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Component<N>> {
        self.features.iter().take(self.found)
    }
}

/// A filter that continues with the state in the memory.
pub(crate) fn filter(memory: &mut Memory, particles: usize) -> Result<Filter<'_>, Refused> {
    let motion = Unicycle::new(Step::Arc, NOISE).map_err(|_| Refused)?;
    let config = Config {
        unconfirmed_weight: 0.5,
        extraction: Extraction::Peaks,
        extraction_weight: 0.3,
        ..Config::blind(particles, 1)
    };
    ScPhd::reborrow(motion, config, memory).map_err(|_| Refused)
}

type Models = Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>;

/// The filter's models of the sensor.
pub(crate) fn models(around: Surroundings) -> Result<(Models, Births<f32>), ModelError> {
    let limits = RangeBearingLimits {
        range_edge_m: 3.0 * SIGMAS[0],
        ..RangeBearingLimits::full_circle(RANGE_M, around.detection)
    };
    let field_of_view = RangeBearingWindow::new(limits)?;
    let measure = field_of_view.measure();
    let clutter = around.clutter.max(LEAST_CLUTTER);
    let of_static = clutter / measure / CLUTTER_OVER_BIRTH;
    let sensing = Sensing {
        sensor: RangeBearing::new(SIGMAS[0], SIGMAS[1])?,
        field_of_view,
        clutter: UniformClutter::of_scan(clutter, measure)?,
    };
    Ok((sensing, Births { of_static, of_moving: MOVING_SHARE * of_static }))
}
