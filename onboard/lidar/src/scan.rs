//! What the finder takes: a planar scan, whoever made it.

/// Two steps and a half without a beam, and what is between was not received.
pub(crate) const MISSING_STEPS: f32 = 2.5;

/// One beam of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Beam {
    /// Direction, rad to the left of the lidar's axis.
    pub bearing_rad: f32,
    /// Range, m; 0 where nothing came back.
    pub range_m: f32,
    /// How bright it came back, in the lidar's own unit; 0 where the lidar does not say.
    pub intensity: f32,
}

/// A scan in a plane: beams side by side, numbered in the order in which they lie. [`LaserScan`](crate::LaserScan) has equal steps
/// between them, [`Revolution`](crate::Revolution) the angles that an LD06 sent.
pub trait Scan {
    /// Number of beams.
    fn beams(&self) -> usize;

    /// A beam by its number; `None` beyond the last.
    fn beam(&self, number: usize) -> Option<Beam>;

    /// Angle from a beam to the next, rad, the mean of the scan: negative where they run clockwise, seen from above.
    fn step_rad(&self) -> f32;

    /// Angle from one beam on to another in the direction of the scan, rad: at least 0, but for beams that overlap by less than a step.
    fn between_rad(&self, from: usize, to: usize) -> f32;

    /// How long before the end of the scan a beam was sent, s.
    fn before_end_s(&self, number: usize) -> f32;

    /// Whether the last beam is beside the first, so that the view has no ends.
    fn is_closed(&self) -> bool {
        false
    }
}
