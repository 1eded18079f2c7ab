//! The final static map compared with the true landmarks, with the same figures in the plane and in space.
//!
//! The landmarks that a map should have are all static ones of the log; if it has their detection rates in view, those that are
//! detected at least every other time.

use crate::alignment::{self, StaticScore};
use crate::cutoff::Cutoff;
use crate::gospa::gospa;
use crate::ospa::{Ospa, ospa};
use scphd_log::dimensions::Coordinates;

/// Order 1 and cut-off 10 m of the OSPA distance: a missing or false feature costs as much as an error of 10 m.
pub const OSPA: Cutoff = Cutoff::new(1.0, 10.0);
/// Order 2 and cut-off 20 m of the GOSPA distance (α = 2), the figures of the published PHD-SLAM benchmark.
pub const GOSPA: Cutoff = Cutoff::new(2.0, 20.0);

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FinalMap<P> {
    /// OSPA distance to all landmarks, m.
    pub ospa: Ospa,
    /// GOSPA distance to all landmarks, m.
    pub gospa_m: f64,
    /// OSPA distance to those that have been in view, m; `None` if these are not known.
    pub ospa_seen_m: Option<f64>,
    /// GOSPA distance to those that have been in view, m.
    pub gospa_seen_m: Option<f64>,
    /// Landmarks found after alignment of the map with all landmarks.
    pub laid_over: StaticScore<P>,
}

impl<P: Coordinates> FinalMap<P> {
    /// Compares the estimated `features` with all `landmarks` and those that have been `seen`, m; `None` if the log has no
    /// landmarks.
    pub fn of(features: &[P], landmarks: &[P], seen: Option<&[P]>) -> Option<Self> {
        (!landmarks.is_empty()).then(|| Self {
            ospa: ospa(features, landmarks, &OSPA),
            gospa_m: gospa(features, landmarks, &GOSPA).distance,
            ospa_seen_m: seen.map(|seen| ospa(features, seen, &OSPA).distance),
            gospa_seen_m: seen.map(|seen| gospa(features, seen, &GOSPA).distance),
            laid_over: alignment::score(features, landmarks),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn landmarks_never_in_view_do_not_count_in_the_seen_figures() {
        let landmarks = [[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 30.0, 1.0], [70.0, 0.0, 2.0]];
        let features = [[0.0, 0.0, 0.3], [30.0, 0.0, 0.3], [0.0, 30.0, 1.3]];
        let found = FinalMap::of(&features, &landmarks, Some(&landmarks[..3])).unwrap();
        assert!((found.ospa.distance - (3.0 * 0.3 + 10.0) / 4.0).abs() < 1e-12);
        assert!((found.ospa_seen_m.unwrap() - 0.3).abs() < 1e-12);
        assert!((found.gospa_seen_m.unwrap() - (3.0_f64 * 0.09).sqrt()).abs() < 1e-12);
        assert!((found.gospa_m - (3.0_f64 * 0.09 + 200.0).sqrt()).abs() < 1e-12);
        // The whole map was 0.3 m too high.
        assert_eq!((found.laid_over.matched, found.laid_over.spurious), (3, 0));
        assert!(found.laid_over.position_error_median_m.unwrap() < 1e-12);
        assert_eq!(FinalMap::of(&features, &landmarks, None).unwrap().ospa_seen_m, None);
        assert_eq!(FinalMap::of(&features, &[], Some(&[])), None);
    }
}
