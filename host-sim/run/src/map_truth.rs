//! The true map from scan to scan, as the thesis defines it for the map error (5.3.1).

use scphd_filters::kind::{Kind, View};
use scphd_log::dimensions::{Dimensions, Planar};
use scphd_log::log::TruePose;
use scphd_log::truth::tracks::Tracks;

#[derive(Debug, Clone, PartialEq)]
pub struct TrueMap<D: Dimensions = Planar> {
    /// Static landmarks that are or have been in view, m.
    pub landmarks: Vec<D::Position>,
    /// Moving landmarks in view: subject and position, m.
    pub movers: Vec<(i64, D::Position)>,
}

impl<D: Dimensions> TrueMap<D> {
    /// Positions of all landmarks, m.
    pub fn points(&self) -> Vec<D::Position> {
        self.landmarks.iter().copied().chain(self.movers.iter().map(|&(_, position)| position)).collect()
    }
}

/// The true map, updated scan by scan.
///
/// A static landmark counts from its first observation, a moving one only while it is in view, as seen from the true pose. A log
/// does not tell which detections are of landmarks, so the first scan in view stands for the first observation; with p_D 0.95
/// that is less than a tenth of a scan early on average.
pub struct MapTruth<'a, K: Kind = Planar> {
    view: View<'a, K>,
    landmarks: Vec<K::Position>,
    seen: Vec<bool>,
    tracks: Tracks<K>,
    movers_known: bool,
    /// Whether the landmarks in view were known at any scan.
    told: bool,
}

impl<K: Kind> std::fmt::Debug for MapTruth<'_, K> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MapTruth").field("seen", &self.seen).finish_non_exhaustive()
    }
}

impl<'a, K: Kind> MapTruth<'a, K> {
    /// Starts before the first scan of `log`.
    pub fn new(log: &'a K::Log, settings: &K::Settings) -> Self {
        let landmarks = K::landmarks(log);
        let moving = K::moving(log);
        Self {
            view: K::view(log, settings),
            seen: vec![false; landmarks.len()],
            landmarks,
            tracks: Tracks::new(moving.unwrap_or_default()),
            movers_known: moving.is_some(),
            told: false,
        }
    }

    /// The static landmarks that have been in view so far, m; `None` if this is not known for any scan.
    pub fn seen(&self) -> Option<Vec<K::Position>> {
        self.told.then(|| self.landmarks.iter().zip(&self.seen).filter(|(_, seen)| **seen).map(|(&at, _)| at).collect())
    }

    pub fn knows_landmarks(&self) -> bool {
        !self.landmarks.is_empty()
    }

    /// Whether the moving landmarks are known, possibly to be none.
    pub fn knows_movers(&self) -> bool {
        self.movers_known
    }

    /// The true map at the next scan, taken at `t_s` from `pose`; `None` if the landmarks in view are not known.
    pub fn at(&mut self, t_s: f64, pose: Option<&TruePose<K>>) -> Option<TrueMap<K>> {
        let pose = pose?;
        if !self.knows_landmarks() && !self.knows_movers() {
            return None;
        }
        for (landmark, seen) in self.landmarks.iter().zip(&mut self.seen) {
            *seen = *seen || (self.view)(pose, *landmark)?;
        }
        self.told = true;
        let mut movers = Vec::new();
        for (subject, position) in self.tracks.at(t_s) {
            if (self.view)(pose, position)? {
                movers.push((subject, position));
            }
        }
        Some(TrueMap { landmarks: self.seen()?, movers })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_filters::settings::Settings;
    use scphd_log::log::{Log, MovingLandmark};
    use scphd_worlds::scenario;

    #[test]
    fn static_landmarks_remain_and_moving_ones_leave_the_true_map() {
        let mut log = scenario::survey(1);
        let settings = Settings::for_log(&log);
        log.landmarks = vec![[10.0, 0.0], [40.0, 0.0], [0.0, 100.0]];
        // From 20 m left of the start to 20 m right of it in four seconds, then at rest.
        log.moving = (0..=5)
            .map(|k| MovingLandmark {
                subject: 3,
                t_s: f64::from(k),
                position: [0.0, 20.0 - f64::from(k.min(4)) * 10.0],
            })
            .collect();
        let mut truth: MapTruth<'_> = MapTruth::new(&log, &settings);
        assert!(truth.knows_landmarks() && truth.knows_movers());
        // The vehicle moves from 0 to 50 m; the range of the sensor is 15 m.
        let mut at =
            |t_s: f64, x: f64| truth.at(t_s, Some(&TruePose { t_s, position: [x, 0.0], heading_rad: None })).unwrap();
        assert_eq!(at(0.0, 0.0), TrueMap { landmarks: vec![[10.0, 0.0]], movers: vec![] });
        assert_eq!(at(1.0, 0.0).movers, [(3, [0.0, 10.0])]);
        assert_eq!(at(2.0, 0.0).points(), [[10.0, 0.0], [0.0, 0.0]]);
        assert_eq!(at(2.5, 0.0).movers, [(3, [0.0, -5.0])]);
        assert_eq!(at(3.0, 20.0).movers, []);
        assert_eq!(at(4.0, 50.0).landmarks, [[10.0, 0.0], [40.0, 0.0]]);
        assert_eq!(at(5.0, 50.0).landmarks.len(), 2);
        assert_eq!(truth.at(5.0, None), None);
        assert_eq!(truth.seen(), Some(vec![[10.0, 0.0], [40.0, 0.0]]));
    }

    #[test]
    fn unknown_landmarks_and_poses_give_no_true_map() {
        let mut log = scenario::survey(1);
        let settings = Settings::for_log(&log);
        let truth_of = |log: &Log| {
            let mut truth = MapTruth::<Planar>::new(log, &settings);
            let known = truth.at(0.0, log.truth.first());
            (truth.knows_landmarks(), truth.knows_movers(), known.is_some(), truth.seen().is_some())
        };
        assert!(truth_of(&log).1, "a simulation knows that there are none");
        log.simulated = false;
        assert_eq!(truth_of(&log), (true, false, true, true));
        log.landmarks.clear();
        assert_eq!(truth_of(&log), (false, false, false, false));
    }
}
