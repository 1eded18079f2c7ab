//! Moving landmarks of a simulation.

use scphd_log::log::MovingLandmark;

/// A landmark that moves on a circle at constant speed: a smooth track that never leaves the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mover {
    /// Centre of the circle, m.
    pub centre_m: [f64; 2],
    pub radius_m: f64,
    /// Speed, m/s; counterclockwise where positive.
    pub speed_mps: f64,
    /// Direction from the centre at time 0, rad.
    pub phase_rad: f64,
}

impl Mover {
    pub fn at(&self, t_s: f64) -> [f64; 2] {
        let angle = self.phase_rad + self.speed_mps / self.radius_m * t_s;
        [self.centre_m[0] + self.radius_m * libm::cos(angle), self.centre_m[1] + self.radius_m * libm::sin(angle)]
    }
}

/// The tracks of all moving landmarks, with a row at each of `times`. They are numbered after the static ones, because subjects and
/// the labels of landmarks are one set of numbers.
pub(super) fn tracks(movers: &[Mover], static_landmarks: usize, times: &[f64]) -> Vec<MovingLandmark> {
    let rows = |(index, mover): (usize, &Mover)| {
        let mover = *mover;
        let subject = (static_landmarks + index) as i64;
        times.iter().map(move |&t_s| MovingLandmark { subject, t_s, position: mover.at(t_s) }).collect::<Vec<_>>()
    };
    movers.iter().enumerate().flat_map(rows).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_and_circle() {
        let mover = Mover { centre_m: [3.0, -1.0], radius_m: 10.0, speed_mps: -2.0, phase_rad: 0.0 };
        assert_eq!(mover.at(0.0), [13.0, -1.0]);
        let quarter = mover.at(2.5 * std::f64::consts::PI);
        assert!((quarter[0] - 3.0).abs() < 1e-12 && (quarter[1] + 11.0).abs() < 1e-12, "{quarter:?}");
        let (a, b) = (mover.at(7.0), mover.at(7.001));
        assert!(((b[0] - a[0]).hypot(b[1] - a[1]) / 0.001 - 2.0).abs() < 1e-6);
    }

    #[test]
    fn every_track_has_a_row_at_every_time() {
        let mover = Mover { centre_m: [0.0; 2], radius_m: 5.0, speed_mps: 1.0, phase_rad: 1.0 };
        let rows = tracks(&[mover, Mover { speed_mps: 2.0, ..mover }], 7, &[0.0, 0.5, 1.0]);
        assert_eq!(rows.iter().map(|row| row.subject).collect::<Vec<_>>(), [7, 7, 7, 8, 8, 8]);
        assert_eq!((rows[4].t_s, rows[1].position), (0.5, mover.at(0.5)));
    }
}
