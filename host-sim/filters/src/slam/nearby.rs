//! A filter in single precision over a log far from the origin of its coordinates.
//!
//! The resolution of single precision is a hundredth of a millimetre near the origin, but half a metre at the northings of a
//! survey grid. Therefore such a filter works in coordinates relative to a nearby origin, and inputs and outputs are shifted.

use super::contract::{PoseAndCovariance, Refusal, ScanOutcome, Search, Slam, refusal};
use super::filter::Precision;
use crate::threads::Threads;
use scphd::errors::Implausible;
use scphd_log::dimensions::PoseFix;
use scphd_score::record::{MapFeature, MovingFeature};

/// Least coordinate of the initial pose, m, at which a log has coordinates with an own origin. There single precision rounds to
/// tenths of a millimetre, which affects a filter that adds small steps to large numbers.
const FAR_M: f64 = 1000.0;

/// The origin of the coordinates: whole metres, so that shifting does not round.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Origin([f64; 2]);

impl Origin {
    /// Chooses the origin for a log with this initial pose; `None` if that is near enough.
    fn of([x, y, _]: [f64; 3]) -> Option<Self> {
        (x.abs().max(y.abs()) >= FAR_M).then(|| Self([x.round(), y.round()]))
    }

    /// A pose relative to the origin.
    fn local_pose(self, [x, y, heading]: [f64; 3]) -> [f64; 3] {
        let [x, y] = self.local_place([x, y]);
        [x, y, heading]
    }

    fn local_place(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Self([origin_x, origin_y]) = self;
        [x - origin_x, y - origin_y]
    }

    /// A position relative to the origin in coordinates of the log.
    fn place(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Self([origin_x, origin_y]) = self;
        [x + origin_x, y + origin_y]
    }

    fn pose(self, [x, y, heading]: [f64; 3]) -> [f64; 3] {
        let [x, y] = self.place([x, y]);
        [x, y, heading]
    }
}

/// The filter that `start` makes of an initial pose, with coordinates of the log at any distance.
pub(crate) fn started_nearby(
    precision: Precision,
    initial_pose: [f64; 3],
    start: impl FnOnce([f64; 3]) -> Result<Box<dyn Slam>, Refusal>,
) -> Result<Box<dyn Slam>, Refusal> {
    match Origin::of(initial_pose).filter(|_| precision == Precision::F32) {
        None => start(initial_pose),
        Some(origin) => Ok(Box::new(Nearby { origin, filter: start(origin.local_pose(initial_pose))? })),
    }
}

/// A filter with coordinates relative to an own origin.
struct Nearby {
    origin: Origin,
    /// Started at the initial pose relative to the origin.
    filter: Box<dyn Slam>,
}

impl Slam for Nearby {
    fn predict(&mut self, control: [f64; 3], dt_s: f64) -> Result<Option<Implausible>, Refusal> {
        self.filter.predict(control, dt_s)
    }

    fn observe(&mut self, fix: &PoseFix) -> Result<bool, Refusal> {
        let fix = match *fix {
            PoseFix::Position(place) => PoseFix::Position(self.origin.local_place(place)),
            PoseFix::Heading(heading) => PoseFix::Heading(heading),
        };
        self.filter.observe(&fix)
    }

    fn relocate(&mut self, pose: &[f64; 3], covariance: &[[f64; 3]; 3]) -> Result<(), Refusal> {
        self.filter.relocate(&self.origin.local_pose(*pose), covariance)
    }

    fn restart(&mut self, pose: &[f64; 3], covariance: &[[f64; 3]; 3]) -> Result<(), Refusal> {
        self.filter.restart(&self.origin.local_pose(*pose), covariance)
    }

    fn scan(&mut self, sensor: usize, detections: &[[f64; 2]]) -> Result<ScanOutcome, Refusal> {
        self.filter.scan(sensor, detections)
    }

    fn pose(&mut self) -> Result<PoseAndCovariance, Refusal> {
        let (pose, covariance) = self.filter.pose()?;
        Ok((self.origin.pose(pose), covariance))
    }

    fn map(&mut self) -> Result<(f64, Vec<MapFeature>), Refusal> {
        let (expected, mut features) = self.filter.map()?;
        features.iter_mut().for_each(|feature| feature.mean = self.origin.place(feature.mean));
        Ok((expected, features))
    }

    fn moving(&mut self) -> Result<Vec<MovingFeature>, Refusal> {
        let mut features = self.filter.moving()?;
        features.iter_mut().for_each(|feature| feature.position = self.origin.place(feature.position));
        Ok(features)
    }

    fn particles(&mut self) -> Result<Vec<([f64; 3], f64)>, Refusal> {
        let particles = self.filter.particles()?.into_iter();
        Ok(particles.map(|(pose, weight)| (self.origin.pose(pose), weight)).collect())
    }

    fn work_on(&mut self, threads: &Threads) {
        self.filter.work_on(threads);
    }

    /// A map has the coordinates of its filter, and the next drive may have another origin.
    fn start_in(&mut self, _file: &[u8], _pose_is_known: bool) -> Result<(), Refusal> {
        Err(too_far())
    }

    fn map_file(&mut self) -> Result<Vec<u8>, Refusal> {
        Err(too_far())
    }

    fn search(&self) -> Option<Search> {
        self.filter.search()
    }

    fn digest(&mut self) -> Option<u64> {
        self.filter.digest()
    }

    fn state_bytes(&self) -> Option<u64> {
        self.filter.state_bytes()
    }
}

fn too_far() -> Refusal {
    refusal("the log begins a kilometre or more from the origin of its coordinates, where maps need --precision f64")
}

#[cfg(test)]
mod tests {
    use super::Origin;

    #[test]
    fn shifted_inputs_and_outputs_are_consistent() {
        assert_eq!(Origin::of([999.0, -20.0, 3.0]), None);
        let origin = Origin::of([500_000.25, 5_500_000.5, 0.5]).unwrap();
        let near = origin.local_pose([500_000.25, 5_500_000.5, 0.5]);
        assert_eq!(near, [0.25, -0.5, 0.5]);
        assert_eq!(origin.pose(near), [500_000.25, 5_500_000.5, 0.5]);
    }
}
