//! What a vehicle does about the conditions, as docs/health.md has it.

use crate::filters::{Control, Slam};
use scphd::nalgebra::{Vector2, Vector3};
use scphd::{Health, Symmetric};
use std::collections::VecDeque;

/// Conditions on which the pose is made less certain.
const DOUBTFUL: [Health; 3] = [Health::INNOVATION_HIGH, Health::DIVERGENCE_SUSPECTED, Health::LOST];
/// On which scans are no longer trusted.
const DIVERGED: [Health; 2] = [Health::DIVERGENCE_SUSPECTED, Health::LOST];
/// On which high innovations say little of the pose.
const DIM: [Health; 3] = [Health::CLUTTER_HIGH, Health::DETECTIONS_LOW, Health::COMPONENTS_LOST];

/// A snapshot every so many scans, and so many of them.
const EVERY: usize = 5;
const KEPT: usize = 6;
/// Scans that a vehicle may go without, s × 5.
const PATIENCE: usize = 75;
/// A scan is trusted again where so much of what is expected is detected.
const TRUSTED: f32 = 0.6;

/// What a vehicle may have done that nothing is known of.
pub fn by(meters: f32, radians: f32) -> Symmetric<Vector3<f32>> {
    Symmetric::from_diagonal([meters * meters, meters * meters, radians * radians])
}

/// A snapshot, and the predictions since.
type Past = (Vec<u8>, Vec<(Control, f32)>);

pub struct Vehicle {
    pub slam: Box<dyn Slam>,
    past: VecDeque<Past>,
    scans: usize,
    /// Scans left out so far, while they are not trusted.
    left_out: Option<usize>,
}

impl Vehicle {
    pub fn new(slam: Box<dyn Slam>) -> Self {
        Self { slam, past: VecDeque::new(), scans: 0, left_out: None }
    }

    pub fn predict(&mut self, control: &Control, dt: f32) -> Health {
        self.past.iter_mut().for_each(|(_, since)| since.push((*control, dt)));
        self.slam.predict(control, dt)
    }

    pub fn scan(&mut self, measurements: &[Vector2<f32>]) -> Health {
        self.scans += 1;
        let Some(left_out) = self.left_out else { return self.trusted(measurements) };
        // Odometry may be what is wrong: from where the vehicle may be, does the scan fit once it has told the pose? The trial is undone.
        let before = self.slam.save();
        let steps = (left_out + 1) as f32;
        let doubt = by((0.3 * steps).min(3.0), (0.1 * steps).min(0.5));
        self.slam.scatter(&doubt);
        self.slam.look(measurements);
        let (health, share) = self.slam.look(measurements);
        self.slam.restore(&before);
        if share >= TRUSTED && !is(health, &DOUBTFUL) || left_out >= PATIENCE {
            self.left_out = None;
            self.slam.scatter(&doubt);
            return self.slam.scan(measurements).0;
        }
        self.left_out = Some(left_out + 1);
        health
    }

    fn trusted(&mut self, measurements: &[Vector2<f32>]) -> Health {
        if self.scans.is_multiple_of(EVERY) {
            self.past.push_back((self.slam.save(), Vec::new()));
            if self.past.len() > KEPT {
                self.past.pop_front();
            }
        }
        let (health, _) = self.slam.scan(measurements);
        if is(health, &DIVERGED)
            && let Some((snapshot, since)) = self.past.pop_front()
        {
            // Back to the map of before, by odometry to where the vehicle is, and without scans until they fit.
            self.slam.restore(&snapshot);
            since.iter().for_each(|(control, dt)| _ = self.slam.predict(control, *dt));
            self.past.clear();
            self.left_out = Some(0);
        } else if is(health, &DOUBTFUL) && !is(health, &DIM) {
            self.slam.scatter(&by(0.3, 0.1));
        }
        health
    }
}

fn is(health: Health, any: &[Health]) -> bool {
    any.iter().any(|&condition| health.contains(condition))
}
