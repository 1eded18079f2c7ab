//! The input of the finder: a planar scan of any source.

/// Greatest angle between adjacent beams, in steps: beyond it, the beams between them were not received.
pub(crate) const MISSING_STEPS: f32 = 2.5;

/// One beam of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Beam {
    /// Direction, rad to the left of the lidar's axis.
    pub bearing_rad: f32,
    /// Range, m; 0 without a return.
    pub range_m: f32,
    /// Intensity of the return, in the lidar's own unit; 0 if the lidar does not measure it.
    pub intensity: f32,
}

/// A planar scan: beams in the order of their angles. [`LaserScan`](crate::LaserScan) has a constant angle between beams,
/// [`Revolution`](crate::Revolution) the angles that an LD06 sent.
pub trait Scan {
    /// Number of beams.
    fn beams(&self) -> usize;

    /// A beam by its index; `None` beyond the last.
    fn beam(&self, number: usize) -> Option<Beam>;

    /// Mean angle between beams, rad; negative if clockwise, seen from above.
    fn step_rad(&self) -> f32;

    /// Angle from one beam to another in the direction of the scan, rad; not negative, except for beams that overlap by less than
    /// a step.
    fn between_rad(&self, from: usize, to: usize) -> f32;

    /// Time from a beam to the end of the scan, s.
    fn before_end_s(&self, number: usize) -> f32;

    /// Whether the last beam is adjacent to the first, so that the view has no ends.
    fn is_closed(&self) -> bool {
        false
    }
}
