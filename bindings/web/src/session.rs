//! A filter, in a simulated world or alone.

use crate::drive::Wish;
use crate::filter::{Features, Filter, Found, Memory, Movers, Refused, robot, sensor};
use crate::sensor::{Scan, Surroundings};
use crate::view::View;
use crate::world::{INTERVAL_S, World};
use core::cell::Cell;
use scphd_vehicle::{Control, Description, Measurements};

/// The complete session, for a static.
#[derive(Debug)]
pub struct Session {
    memory: Memory,
    /// In a cell, because a cell has no niche: the `None` of this option is all zero, so that the static session is in .bss, and the
    /// module does not contain its bytes.
    described: Option<Cell<Description<f32>>>,
    world: Option<World>,
    scans: u32,
    scan: Scan,
    features: Features,
    movers: Movers,
    view: View,
}

impl Session {
    /// A session that has not been started.
    pub const NEW: Self = Self {
        memory: Memory::NEW,
        described: None,
        world: None,
        scans: 0,
        scan: Scan::EMPTY,
        features: Found::NONE,
        movers: Found::NONE,
        view: View::EMPTY,
    };

    /// Starts, or restarts: the world of a seed, and a filter with an empty map: a mixture with this number of particles or, if it
    /// is 0, a joint map.
    ///
    /// # Errors
    /// There are more particles than [`PARTICLES`](crate::PARTICLES).
    pub fn start(&mut self, seed: u64, particles: usize) -> Result<(), Refused> {
        self.begin(robot(seed, particles))?;
        self.world = Some(World::of_seed(seed));
        Ok(())
    }

    /// Starts, or restarts, a filter without a world: that of a [`Description`] with these [numbers](Description::numbers).
    ///
    /// # Errors
    /// The description is out of range, or does not fit the memory.
    pub fn describe(&mut self, numbers: &[f64]) -> Result<(), Refused> {
        let mut described = Description::robot();
        described.take_numbers(numbers.iter().copied()).map_err(|_| Refused)?;
        described.check().map_err(|_| Refused)?;
        self.begin(described)
    }

    fn begin(&mut self, described: Description<f32>) -> Result<(), Refused> {
        self.memory.clear();
        (self.world, self.scans, self.view) = (None, 0, View::EMPTY);
        let mut filter = self.memory.filter(self.described.insert(Cell::new(described)).get_mut())?;
        filter.services().reset(&described.start).map_err(|_| Refused)
    }

    /// The filter.
    ///
    /// # Errors
    /// The session has not been started.
    pub fn filter(&mut self) -> Result<Filter<'_>, Refused> {
        self.memory.filter(self.described.as_mut().ok_or(Refused)?.get_mut())
    }

    /// Drives to the next scan and processes it. If `told` is false, the filter assumes [usual](Surroundings::USUAL) clutter and
    /// detection probability.
    ///
    /// # Errors
    /// The session has not been started with a world.
    pub fn step(&mut self, wish: Wish, around: Surroundings, told: bool) -> Result<(), Refused> {
        let Self { memory, described, world, scans, scan, features, movers, view } = self;
        let (Some(described), Some(world)) = (described, world) else { return Err(Refused) };
        let exact = World::exact().map_err(|_| Refused)?;
        let around = around.bounded();
        let odometry = world.advance(&exact, wish);
        scan.take(world, around);

        let described = described.get_mut();
        let [assumed, ..] = &mut described.sensors;
        *assumed = Some(sensor(if told { around } else { Surroundings::USUAL }).map_err(|_| Refused)?);
        let mut filter = memory.filter(described)?;
        let control = Control { speed_mps: odometry.speed_mps, turn: odometry.rate_radps, ..Control::STILL };
        let slam = filter.services();
        slam.predict(control, INTERVAL_S).map_err(|_| Refused)?;
        let report = slam.scan(0, Measurements::RangeBearing(scan.measurements())).map_err(|_| Refused)?;

        *scans = scans.saturating_add(1);
        features.found = slam.features(&mut features.features).features;
        movers.found = slam.movers(&mut movers.features).features;
        view.show(*scans, world, scan, &mut filter, (features, movers), &report);
        Ok(())
    }

    /// The view after the last scan; empty before the first.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// The digest of the filter's state; 0 before the start.
    #[must_use]
    pub fn digest(&mut self) -> u64 {
        self.filter().map_or(0, |mut filter| filter.services().digest())
    }
}
