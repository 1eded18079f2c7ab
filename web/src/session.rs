//! A filter in a world, scan after scan.

use crate::drive::Wish;
use crate::sensor::{MEASUREMENTS, RANGE_M, SIGMAS, Scan, Surroundings};
use crate::view::View;
use crate::world::{INTERVAL_S, World};
use nalgebra::{Vector2, Vector4};
use scphd::{
    Births, Component, Config, ControlNoise, Detector, DetectorMemory, Extraction, ModelError, RangeBearing,
    RangeBearingLimits, RangeBearingWindow, ScPhd, Sensing, Step, Unicycle, UniformClutter, Vector, memory,
};

/// Room for particles.
pub const PARTICLES: usize = 64;

memory! {
    type Memory: Unicycle<f32> {
        particles: 64, samples: 1,
        features { pages: 1024, pages_per_map: 32, in_view: 256 },
        moving { pages: 512, pages_per_map: 16, in_view: 128 },
    }
}

pub(crate) type Filter<'m> = ScPhd<'m, Unicycle<f32>>;
pub(crate) type Features = Found<Vector2<f32>, 96>;
pub(crate) type Movers = Found<Vector4<f32>, 32>;

/// How well the filter knows the odometry: worn wheels are a part of what lasts half a second and more.
const NOISE: ControlNoise<f32> = ControlNoise {
    speed_sigma_mps: 0.1,
    speed_sigma_ratio: 0.05,
    turn_sigma: 0.02,
    turn_sigma_ratio: 0.05,
    interval_s: 0.5,
};
/// κ / w_b of static features, and w_b of moving ones as a share of theirs.
const CLUTTER_OVER_BIRTH: f32 = 20.0;
const MOVING_SHARE: f32 = 0.3;
/// Births a scan where next to no clutter is expected.
const LEAST_CLUTTER: f32 = 1.0;

/// Something that the filter does not take; the session is as it was, or has to be started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refused;

/// Features that the filter believes in.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Found<N: Vector, const ROOM: usize> {
    features: [Component<N>; ROOM],
    found: usize,
}

impl<N: Vector, const ROOM: usize> Found<N, ROOM> {
    const NONE: Self = Self { features: [Component::ZERO; ROOM], found: 0 };

    pub(crate) fn found(&self) -> usize {
        self.found
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Component<N>> {
        self.features.iter().take(self.found)
    }
}

/// All of it, for a static.
#[derive(Debug)]
pub struct Session {
    memory: Memory,
    scratch: DetectorMemory<Vector2<f32>, MEASUREMENTS>,
    world: Option<World>,
    particles: usize,
    scans: u32,
    scan: Scan,
    features: Features,
    movers: Movers,
    view: View,
    digest: u64,
}

impl Session {
    /// Not started.
    pub const NEW: Self = Self {
        memory: Memory::new(),
        scratch: DetectorMemory::new(),
        world: None,
        particles: 0,
        scans: 0,
        scan: Scan::EMPTY,
        features: Found::NONE,
        movers: Found::NONE,
        view: View::EMPTY,
        digest: 0,
    };

    /// Starts, or starts again: the world of a seed, and a filter of so many particles at its start, with an empty map.
    ///
    /// # Errors
    /// There is room for 1 to [`PARTICLES`].
    pub fn start(&mut self, seed: u64, particles: usize) -> Result<(), Refused> {
        if !(1..=PARTICLES).contains(&particles) {
            return Err(Refused);
        }
        self.memory.clear();
        self.particles = particles;
        self.scans = 0;
        self.view = View::EMPTY;
        let mut filter = filter(&mut self.memory, particles)?;
        filter.reset(World::START, seed).map_err(|_| Refused)?;
        self.digest = filter.digest();
        self.world = Some(World::of_seed(seed));
        Ok(())
    }

    /// Drives on to the next scan, and takes it in. A filter that is not told how the sensor sees takes it for
    /// [usual](Surroundings::USUAL).
    ///
    /// # Errors
    /// The session has not been started.
    pub fn step(&mut self, wish: Wish, around: Surroundings, told: bool) -> Result<(), Refused> {
        let Self { memory, scratch, world, particles, scans, scan, features, movers, view, digest } = self;
        let world = world.as_mut().ok_or(Refused)?;
        let exact = World::exact().map_err(|_| Refused)?;
        let around = around.bounded();
        let odometry = world.advance(&exact, wish);
        scan.take(world, around);

        let mut filter = filter(memory, *particles)?;
        filter.predict(&odometry, INTERVAL_S).map_err(|_| Refused)?;
        let (sensing, births) = models(if told { around } else { Surroundings::USUAL }).map_err(|_| Refused)?;
        let detector = Detector::new(sensing, births).map_err(|_| Refused)?;
        let mut detector = detector.over(scratch).map_err(|_| Refused)?;
        let report = filter.scan(&mut detector, scan.measurements()).map_err(|_| Refused)?;

        *scans = scans.saturating_add(1);
        features.found = filter.estimate_map(&detector, &mut features.features).features;
        movers.found = filter.estimate_moving(&mut movers.features).features;
        *digest = filter.digest();
        view.show(*scans, world, scan, &filter, (features, movers), &report);
        Ok(())
    }

    /// What is to be seen after the last scan; empty before the first.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// The filter's whole state in one number.
    #[must_use]
    pub fn digest(&self) -> u64 {
        self.digest
    }
}

/// A filter that goes on from what the memory holds.
fn filter(memory: &mut Memory, particles: usize) -> Result<Filter<'_>, Refused> {
    let motion = Unicycle::new(Step::Arc, NOISE).map_err(|_| Refused)?;
    let config = Config {
        unconfirmed_weight: 0.5,
        extraction: Extraction::Peaks,
        extraction_weight: 0.3,
        ..Config::blind(particles, 1)
    };
    ScPhd::new(motion, config, memory).map_err(|_| Refused)
}

type Models = Sensing<RangeBearing<f32>, RangeBearingWindow<f32>, UniformClutter<f32>>;

/// The sensor as the filter takes it to be.
fn models(around: Surroundings) -> Result<(Models, Births<f32>), ModelError> {
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
