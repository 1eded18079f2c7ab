//! The view as a list of numbers: a header, then lists one after the other. `page.js` reads it in this order.

use crate::filter::{FEATURES, Features, Filter, Movers};
use crate::sensor::{RANGE_M, Scan, Source};
use crate::world::{INTERVAL_S, World};
use scphd::Real;
use scphd::models::{PlanarPose, Pose};
use scphd::numerics::Symmetric;
use scphd::storage::Candidate;
use scphd_vehicle::Scanned;

/// Numbers of the header:
///
/// | | |
/// |---|---|
/// | 0, 1 | scans; time, s |
/// | 2–4 | estimated x, y, m, and heading, rad |
/// | 5–8 | covariance of the pose: xx, xy, yy, m², and of the heading, rad² |
/// | 9–11, 12–14 | the true pose; that of odometry alone |
/// | 15 | effective number of particles; 0 of a joint map |
/// | 16–21 | lengths of the lists: particles, features, moving features, detections, landmarks, walkers |
/// | 22, 23 | pages of static features in use, and their total number; of a joint map features |
/// | 24 | range of the sensor, m |
/// | 25 | health, as bits |
///
/// Then the lists: particles (x, y, heading, weight), features (x, y, xx, xy, yy, weight, label), moving features (the same, and
/// velocity x, y), detections (x, y from the estimated pose, source: 0 clutter, 1 landmark, 2 walker), landmarks (x, y) and
/// walkers (x, y).
pub const HEAD: usize = 26;
/// Number of numbers with all lists at their longest.
const ROOM: usize = HEAD + 64 * 4 + 96 * 7 + 32 * 9 + 96 * 3 + 48 * 2 + 4 * 2;

/// The list of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    numbers: [f32; ROOM],
    used: usize,
}

impl View {
    /// An empty view.
    pub const EMPTY: Self = Self { numbers: [0.0; ROOM], used: 0 };

    /// The numbers.
    #[must_use]
    pub fn numbers(&self) -> &[f32] {
        self.numbers.get(..self.used).unwrap_or(&[])
    }

    fn put(&mut self, numbers: &[f32]) {
        let free = self.numbers.get_mut(self.used..).unwrap_or(&mut []);
        self.used += free.iter_mut().zip(numbers).map(|(slot, number)| *slot = *number).count();
    }

    /// The view after a scan.
    pub(crate) fn show(
        &mut self,
        scans: u32,
        world: &World,
        scan: &Scan,
        filter: &mut Filter<'_>,
        (features, movers): (&Features, &Movers),
        report: &Scanned<f32>,
    ) {
        self.used = 0;
        let (mean, covariance) =
            filter.services().pose().map_or((PlanarPose::ZERO, Symmetric::ZERO), |pose| (pose.mean, pose.covariance));
        let (n_eff, used, total) = match report {
            Scanned::Mixture(report) => (report.n_eff, report.pages_used, report.pages),
            Scanned::Joint(_) => (0.0, features.found(), FEATURES),
        };
        let candidates = filter.particles();
        let count = |number: usize| f32::from(u16::try_from(number).unwrap_or(u16::MAX));
        self.put(&[scans as f32, scans as f32 * INTERVAL_S, mean.x_m, mean.y_m, mean.heading_rad]);
        self.put(&[covariance.get(0, 0), covariance.get(0, 1), covariance.get(1, 1), covariance.get(2, 2)]);
        for pose in [&world.pose, &world.reckoned] {
            self.put(&[pose.x_m, pose.y_m, pose.heading_rad]);
        }
        self.put(&[n_eff]);
        self.put(&[candidates.len(), features.found(), movers.found()].map(count));
        self.put(&[scan.measurements().len(), world.landmarks.len(), world.walkers.len()].map(count));
        self.put(&[count(used), count(total), RANGE_M, f32::from(report.health().bits())]);
        for Candidate { pose, ln_weight, .. } in candidates {
            self.put(&[pose.x_m, pose.y_m, pose.heading_rad, Real::exp(*ln_weight)]);
        }
        for feature in features.iter() {
            let of = |row, column| feature.covariance.get(row, column);
            self.put(&[feature.mean.x, feature.mean.y, of(0, 0), of(0, 1), of(1, 1)]);
            self.put(&[Real::exp(feature.ln_weight), feature.label as f32]);
        }
        for mover in movers.iter() {
            let of = |row, column| mover.covariance.get(row, column);
            self.put(&[mover.mean.x, mover.mean.y, of(0, 0), of(0, 1), of(1, 1)]);
            self.put(&[Real::exp(mover.ln_weight), mover.label as f32, mover.mean.z, mover.mean.w]);
        }
        for (measurement, source) in scan.measurements().iter().zip(scan.sources()) {
            let (sine, cosine) = Real::sin_cos(mean.heading_rad + measurement.y);
            let source = match source {
                Source::Clutter => 0.0,
                Source::Landmark => 1.0,
                Source::Walker => 2.0,
            };
            self.put(&[mean.x_m + measurement.x * cosine, mean.y_m + measurement.x * sine, source]);
        }
        world.landmarks.iter().for_each(|place| self.put(place));
        world.walkers.iter().for_each(|walker| self.put(&walker.place));
    }
}
