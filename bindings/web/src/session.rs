//! A filter in a simulated world.

use crate::drive::Wish;
use crate::filter::{Features, Found, Memory, Movers, PARTICLES, Refused, Scratch, filter, models};
use crate::sensor::{Scan, Surroundings};
use crate::view::View;
use crate::world::{INTERVAL_S, World};
use scphd::Detector;

/// The complete session, for a static.
#[derive(Debug)]
pub struct Session {
    memory: Memory,
    scratch: Scratch,
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
    /// A session that has not been started.
    pub const NEW: Self = Self {
        memory: Memory::new(),
        scratch: Scratch::new(),
        world: None,
        particles: 0,
        scans: 0,
        scan: Scan::EMPTY,
        features: Found::NONE,
        movers: Found::NONE,
        view: View::EMPTY,
        digest: 0,
    };

    /// Starts, or restarts: the world of a seed, and a filter with this number of particles and an empty map.
    ///
    /// # Errors
    /// The number of particles is not between 1 and [`PARTICLES`].
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

    /// Drives to the next scan and processes it. If `told` is false, the filter assumes [usual](Surroundings::USUAL) clutter and
    /// detection probability.
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

    /// The view after the last scan; empty before the first.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// The digest of the filter's state.
    #[must_use]
    pub fn digest(&self) -> u64 {
        self.digest
    }
}
