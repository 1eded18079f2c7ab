//! Reactions of a vehicle to the warnings, as docs/health.md describes them.

use crate::filters::{Control, ODOMETRY, Slam};
use crate::relocaliser::Relocaliser;
use crate::world::DT_S;
use scphd::Health;
use scphd::models::PlanarPose;
use scphd::numerics::Symmetric;
use scphd::numerics::nalgebra::{Vector2, Vector3};
use scphd_sequencer::OdometryWatch;
use std::collections::VecDeque;

/// Warnings after which the covariance of the pose is increased.
const DOUBTFUL: [Health; 3] = [Health::INNOVATION_HIGH, Health::DIVERGENCE_SUSPECTED, Health::LOST];
/// Warnings after which scans are not used.
const DIVERGED: [Health; 2] = [Health::DIVERGENCE_SUSPECTED, Health::LOST];
/// Warnings with which high innovations say little about the pose.
const DIM: [Health; 3] = [Health::CLUTTER_HIGH, Health::DETECTIONS_LOW, Health::COMPONENTS_LOST];

/// Number of scans between snapshots, and number of snapshots.
const EVERY: usize = 5;
const KEPT: usize = 6;
/// Number of scans for which odometry is doubted after high innovations, because its fault lasts.
const HELD: usize = 10;
/// Least share of the expected detections with which a scan is used again.
const TRUSTED: f32 = 0.6;

/// Covariance of an unknown motion.
pub fn by(meters: f32, radians: f32) -> Symmetric<Vector3<f32>> {
    Symmetric::from_diagonal([meters * meters, meters * meters, radians * radians])
}

/// A snapshot, and the predictions since then.
type Past = (Vec<u8>, Vec<(Control, f32)>);

pub struct Vehicle {
    pub slam: Box<dyn Slam>,
    /// Locates the vehicle in the previous map while scans are not used.
    relocaliser: Relocaliser,
    past: VecDeque<Past>,
    scans: usize,
    /// Number of scans left out so far, while they are not used.
    left_out: Option<usize>,
    /// Number of scans for which odometry is still doubted.
    doubtful: usize,
    watch: OdometryWatch<PlanarPose<f32>>,
    /// Whether an odometry bias is suspected.
    pub biased: bool,
}

impl Vehicle {
    pub fn new(slam: Box<dyn Slam>, relocaliser: Relocaliser) -> Self {
        Self {
            slam,
            relocaliser,
            past: VecDeque::new(),
            scans: 0,
            left_out: None,
            doubtful: 0,
            watch: OdometryWatch::new(),
            biased: false,
        }
    }

    pub fn predict(&mut self, control: &Control, dt: f32) -> Health {
        self.past.iter_mut().for_each(|(_, since)| since.push((*control, dt)));
        if self.left_out.is_some() {
            self.relocaliser.predict(control, dt);
        }
        self.slam.predict(control, dt)
    }

    pub fn scan(&mut self, measurements: &[Vector2<f32>]) -> Health {
        self.scans += 1;
        let Some(left_out) = self.left_out else { return self.trusted(measurements) };
        // Odometry may be faulty: the scan determines the pose, and must then agree with the map from there. The trial is undone.
        let before = self.slam.save();
        let steps = (left_out + 1) as f32;
        self.slam.scatter(&by((0.3 * steps).min(3.0), (0.1 * steps).min(0.5)));
        self.slam.try_scan(measurements);
        let told = self.slam.pose();
        self.slam.restore(&before);
        self.slam.relocate(told, &by(0.1, 0.03));
        let (health, share) = self.slam.try_scan(measurements);
        self.slam.restore(&before);
        if share >= TRUSTED && !is(health, &DOUBTFUL) {
            self.left_out = None;
            self.slam.relocate(told, &by(0.3, 0.1));
            self.past.push_back((self.slam.save(), Vec::new()));
            return self.slam.scan(measurements).0;
        }
        self.left_out = Some(left_out + 1);
        if let Some(place) = self.relocaliser.scan(measurements) {
            self.left_out = None;
            self.slam.relocate(place.pose.mean, &place.pose.covariance);
            self.past.push_back((self.slam.save(), Vec::new()));
        }
        health
    }

    /// Stops the use of scans until the pose in the present map is found.
    pub fn search(&mut self) {
        self.relocaliser.begin(&self.slam.map());
        self.past.clear();
        self.left_out = Some(0);
    }

    fn trusted(&mut self, measurements: &[Vector2<f32>]) -> Health {
        if self.scans.is_multiple_of(EVERY) {
            self.past.push_back((self.slam.save(), Vec::new()));
            if self.past.len() > KEPT {
                self.past.pop_front();
            }
        }
        let predicted = self.slam.pose();
        let (health, _) = self.slam.scan(measurements);
        let [forward, turn] = ODOMETRY.map(|sigma| sigma * (DT_S as f32).sqrt());
        self.biased = self.watch.scan(&predicted, &self.slam.pose(), &Vector3::new(forward, 0.0, turn)).is_suspected();
        if is(health, &DIVERGED)
            && let Some((snapshot, since)) = self.past.pop_front()
        {
            // Restores the previous map, predicts to the present by odometry, and uses no scans until they agree.
            self.slam.restore(&snapshot);
            self.search();
            since.iter().for_each(|(control, dt)| _ = self.slam.predict(control, *dt));
        } else if self.biased || is(health, &DOUBTFUL) && !is(health, &DIM) {
            self.doubtful = HELD;
        }
        if self.doubtful > 0 && self.left_out.is_none() && !is(health, &DIM) {
            self.doubtful -= 1;
            self.slam.scatter(&by(0.3, 0.1));
        }
        health
    }
}

fn is(health: Health, any: &[Health]) -> bool {
    any.iter().any(|&condition| health.contains(condition))
}
