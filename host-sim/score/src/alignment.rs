//! A map compared with the truth after the best alignment: a rotation about the vertical and a shift, in the plane and in space,
//! because a vehicle in space knows the vertical.
//!
//! A filter that starts from a slightly wrong pose, or whose log has its truth in another frame, builds a map that is rotated and
//! shifted as a whole. What remains after the alignment is the error of the map itself.

use crate::cutoff::Cutoff;
use crate::moving::median;
use scphd_log::dimensions::Coordinates;

/// Greatest distance of a feature from its landmark, m.
pub const MATCHED_WITHIN_M: f64 = 0.5;
/// Gates of the assignments for the alignment, m, from coarse to fine.
const GATES_M: [f64; 4] = [4.0, 2.0, 1.0, MATCHED_WITHIN_M];
/// Greatest number of iterations at one gate; an assignment repeats itself after a few.
const MOST_FITS: usize = 50;

/// A rotation of x and y and a shift of all coordinates, in D ≥ 2 dimensions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<P> {
    /// Rotation about the vertical through the origin, rad.
    pub turn_rad: f64,
    /// Shift after the rotation, m.
    pub shift_m: P,
}

impl<P: Coordinates> Motion<P> {
    pub fn rest() -> Self {
        Self { turn_rad: 0.0, shift_m: P::with(|_| 0.0) }
    }

    pub fn apply(&self, point: P) -> P {
        let (s, c) = libm::sincos(self.turn_rad);
        let point = point.as_ref();
        let (x, y) = (point[0], point[1]);
        let turned = |k| [c * x - s * y, s * x + c * y].get(k).copied().unwrap_or_else(|| point[k]);
        P::with(|k| turned(k) + self.shift_m.as_ref()[k])
    }

    /// The motion that brings the first points of the pairs nearest to the second ones, in the sense of least squares (Kabsch;
    /// the rotation is the direction of Σ ā·b and Σ ā×b in the plane of x and y). `None` without pairs; only a shift for one
    /// pair.
    pub fn fit(pairs: &[(P, P)]) -> Option<Self> {
        if pairs.is_empty() {
            return None;
        }
        let (firsts, seconds): (Vec<P>, Vec<P>) = pairs.iter().copied().unzip();
        let (centre_from, centre_to) = (centre(&firsts), centre(&seconds));
        let (from, to) = (centre_from.as_ref(), centre_to.as_ref());
        let (mut along, mut across) = (0.0, 0.0);
        for (a, b) in pairs {
            let (a, b) = (a.as_ref(), b.as_ref());
            let (a, b) = ([a[0] - from[0], a[1] - from[1]], [b[0] - to[0], b[1] - to[1]]);
            along += a[0] * b[0] + a[1] * b[1];
            across += a[0] * b[1] - a[1] * b[0];
        }
        let turn_rad = libm::atan2(across, along);
        let turned = Self { turn_rad, ..Self::rest() }.apply(centre_from);
        Some(Self { turn_rad, shift_m: P::with(|k| to[k] - turned.as_ref()[k]) })
    }
}

fn centre<P: Coordinates>(points: &[P]) -> P {
    P::with(|k| points.iter().map(|point| point.as_ref()[k]).sum::<f64>() / points.len() as f64)
}

/// Assignment of the features of a map to landmarks, and their errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticScore<P> {
    /// Landmarks with a feature within [`MATCHED_WITHIN_M`], each feature used once.
    pub matched: usize,
    /// Features without a landmark.
    pub spurious: usize,
    /// Median distance of the matched features, m.
    pub position_error_median_m: Option<f64>,
    /// The alignment that was applied to the features.
    pub motion: Motion<P>,
}

/// Aligns `features` with `landmarks` (m) and matches them.
///
/// Alternates between the optimal assignment within a gate and the best motion for it until nothing changes, with narrower and
/// narrower gates.
pub fn score<P: Coordinates>(features: &[P], landmarks: &[P]) -> StaticScore<P> {
    let mut motion = Motion::rest();
    let matched = |motion: &Motion<P>, gate_m: f64| {
        let moved: Vec<P> = features.iter().map(|&feature| motion.apply(feature)).collect();
        Cutoff::new(1.0, gate_m).pairs(&moved, landmarks)
    };
    for gate_m in GATES_M {
        let mut before = Vec::new();
        for _ in 0..MOST_FITS {
            let pairs: Vec<_> = matched(&motion, gate_m).into_iter().map(|(a, b, _)| (a, b)).collect();
            // Two points of each set can always be aligned: at least three pairs are needed for a fit.
            if pairs == before || pairs.len() < 3 {
                break;
            }
            let points: Vec<_> = pairs.iter().map(|&(a, b)| (features[a], landmarks[b])).collect();
            motion = Motion::fit(&points).unwrap_or(motion);
            before = pairs;
        }
    }
    let distances: Vec<f64> = matched(&motion, MATCHED_WITHIN_M).into_iter().map(|(_, _, distance)| distance).collect();
    StaticScore {
        matched: distances.len(),
        spurious: features.len() - distances.len(),
        position_error_median_m: median(&distances),
        motion,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_log::noise::Noise;

    fn map(noise: &mut Noise) -> Vec<[f64; 2]> {
        (0..20).map(|_| [noise.between(-20.0, 20.0), noise.between(-20.0, 20.0)]).collect()
    }

    #[test]
    fn a_known_motion_is_recovered() {
        let mut noise = Noise::new(4);
        for _ in 0..50 {
            let landmarks = map(&mut noise);
            let known = Motion { turn_rad: noise.between(-3.1, 3.1), shift_m: [noise.between(-9.0, 9.0), 4.0] };
            let pairs: Vec<_> = landmarks.iter().map(|&from| (from, known.apply(from))).collect();
            let found = Motion::fit(&pairs).unwrap();
            assert!((found.turn_rad - known.turn_rad).abs() < 1e-12);
            assert!((0..2).all(|k| (found.shift_m[k] - known.shift_m[k]).abs() < 1e-11));
        }
        assert_eq!(Motion::<[f64; 2]>::fit(&[]), None);
        assert_eq!(Motion::fit(&[([1.0, 2.0], [4.0, 6.0])]).unwrap(), Motion { turn_rad: 0.0, shift_m: [3.0, 4.0] });
    }

    #[test]
    fn a_rotated_map_with_false_and_missing_features_is_aligned_with_the_landmarks() {
        let mut noise = Noise::new(8);
        let landmarks: Vec<[f64; 2]> = (0..15).map(|k| [f64::from(k % 4) * 7.0, f64::from(k / 4) * 6.0]).collect();
        let astray = Motion { turn_rad: 0.05, shift_m: [0.8, -0.6] };
        let mut features: Vec<[f64; 2]> = landmarks[..13].iter().map(|&at| astray.apply(at)).collect();
        for feature in &mut features {
            *feature = feature.map(|coordinate| coordinate + 0.02 * noise.normal());
        }
        features.extend([[3.4, 15.0], [-30.0, 2.0]]);
        let score = score(&features, &landmarks);
        assert_eq!((score.matched, score.spurious), (13, 2));
        assert!((score.motion.turn_rad + 0.05).abs() < 0.003, "{score:?}");
        assert!(score.position_error_median_m.unwrap() < 0.05);
    }

    #[test]
    fn a_map_in_space_is_rotated_about_the_vertical_and_shifted() {
        let mut noise = Noise::new(9);
        let floor: Vec<[f64; 3]> = map(&mut noise).into_iter().map(|[x, y]| [x, y, 0.1 * x]).collect();
        let astray = Motion { turn_rad: -0.04, shift_m: [0.3, 0.2, -0.7] };
        let features: Vec<[f64; 3]> = floor.iter().map(|&at| astray.apply(at)).collect();
        let found = score(&features, &floor);
        assert_eq!((found.matched, found.spurious), (20, 0));
        assert!(
            (found.motion.turn_rad - 0.04).abs() < 1e-9 && (found.motion.shift_m[2] - 0.7).abs() < 1e-9,
            "{found:?}"
        );
        // The result without heights is the same in the plane.
        let flat = |points: &[[f64; 3]]| points.iter().map(|&[x, y, _]| [x, y]).collect::<Vec<_>>();
        let planar = score(&flat(&features), &flat(&floor));
        assert_eq!((planar.matched, planar.motion.turn_rad), (20, found.motion.turn_rad));
    }

    #[test]
    fn empty_sets_are_not_aligned() {
        let empty = score(&[], &[[1.0, 1.0]]);
        assert_eq!((empty.matched, empty.spurious, empty.position_error_median_m), (0, 0, None));
        let few = score(&[[0.0, 0.0], [5.0, 3.0]], &[[0.0, 3.0], [5.0, 0.0]]);
        assert_eq!((few.matched, few.motion), (0, Motion::rest()));
    }
}
