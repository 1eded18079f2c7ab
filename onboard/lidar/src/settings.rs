//! What the finder takes for a post.

use core::fmt;

/// What the finder takes for a post, or for a reflector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PostSettings {
    /// Radius of the posts, m: above 0.
    pub radius_m: f32,
    /// By how much the width that a cluster of points shows may differ from the posts' diameter, m, beside what the step from point to
    /// point leaves open: at least 0.
    pub tolerance_m: f32,
    /// A point is of the same thing as the one beside it where their ranges differ by no more than this, m: above 0, and above what
    /// the noise of two readings can be.
    pub gap_m: f32,
    /// Points that a post must have: at least 1. More keep single false readings out, and let the view end sooner:
    /// [`Resolution::detection_probability`](crate::Resolution::detection_probability).
    pub min_points: u16,
    /// Readings darker than this, in the lidar's own unit, are of no post: 0 for posts that do not reflect, about 200 for reflectors of an
    /// LD06.
    pub min_intensity: f32,
    /// The nearest post, m: at least 0.
    pub range_min_m: f32,
    /// The farthest post, m: above the nearest.
    pub range_max_m: f32,
}

impl PostSettings {
    /// For posts of this radius, m, that do not reflect, as far as an LD06 reaches: two points at least.
    #[must_use]
    pub const fn of_radius(radius_m: f32) -> Self {
        Self {
            radius_m,
            tolerance_m: 0.5 * radius_m,
            gap_m: 0.15,
            min_points: 2,
            min_intensity: 0.0,
            range_min_m: 0.1,
            range_max_m: 12.0,
        }
    }

    /// Whether a finder can work with it.
    ///
    /// # Errors
    /// Names the field that is out of range.
    pub fn check(&self) -> Result<(), SettingsError> {
        let wrong = |field, range| Err(SettingsError { field, range });
        let Self { radius_m, tolerance_m, gap_m, min_points, min_intensity, range_min_m, range_max_m } = *self;
        // What is not a number fails every comparison.
        if !(radius_m > 0.0 && radius_m.is_finite()) {
            wrong("radius_m", "above 0")
        } else if !(tolerance_m >= 0.0 && tolerance_m.is_finite()) {
            wrong("tolerance_m", "at least 0")
        } else if !(gap_m > 0.0 && gap_m.is_finite()) {
            wrong("gap_m", "above 0")
        } else if min_points == 0 {
            wrong("min_points", "at least 1")
        } else if !(min_intensity >= 0.0 && min_intensity.is_finite()) {
            wrong("min_intensity", "at least 0")
        } else if !(range_min_m >= 0.0 && range_min_m.is_finite()) {
            wrong("range_min_m", "at least 0")
        } else if !(range_max_m > range_min_m && range_max_m.is_finite()) {
            wrong("range_max_m", "above range_min_m")
        } else {
            Ok(())
        }
    }

    /// From the mean of so many readings to the axis, m: how far before it they are on average where they are a step apart, span so much,
    /// and lie about the middle of the post, or beside it by as much as its width leaves open.
    pub(crate) fn depth_m(&self, rays: usize, span_rad: f32, range_m: f32, step_rad: f32) -> f32 {
        let (width, span, step) = (2.0 * self.radius_m, range_m * span_rad, range_m * step_rad);
        let open = (width - span).max(0.0);
        let aside = 0.5 * open.min(2.0 * step - open).max(0.0);
        let (mut sum, mut count) = (0.0, 0.0);
        let places = rays.min(ENOUGH_RAYS);
        // Each ray stands in the middle of a step.
        let covered = if rays > 1 { span * rays as f32 / (rays - 1) as f32 } else { 0.0 };
        for place in 0..places {
            let across = covered * ((place as f32 + 0.5) / places as f32 - 0.5);
            for shift in SHIFTS {
                let x = across + shift * aside;
                sum += libm::sqrtf((self.radius_m * self.radius_m - x * x).max(0.0));
                count += 1.0;
            }
        }
        // Rays beside the axis are longer than what lies along it, by the mean of range · (1 − cos).
        let slant = range_m * span_rad * span_rad / 24.0;
        if count > 0.0 { sum / count + slant } else { 0.0 }
    }
}

/// As many places as stand for more rays.
const ENOUGH_RAYS: usize = 16;

/// Places that stand for all between −1 and 1.
const SHIFTS: [f32; 4] = [-0.75, -0.25, 0.25, 0.75];

/// A field of the settings is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct SettingsError {
    /// The field, by its name.
    pub field: &'static str,
    /// What it must be.
    pub range: &'static str,
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} must be {}", self.field, self.range)
    }
}

impl core::error::Error for SettingsError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_checked() {
        let good = PostSettings::of_radius(0.05);
        assert_eq!(good.check(), Ok(()));
        for (settings, field) in [
            (PostSettings { radius_m: 0.0, ..good }, "radius_m"),
            (PostSettings { radius_m: f32::INFINITY, ..good }, "radius_m"),
            (PostSettings { tolerance_m: f32::NAN, ..good }, "tolerance_m"),
            (PostSettings { gap_m: -1.0, ..good }, "gap_m"),
            (PostSettings { min_points: 0, ..good }, "min_points"),
            (PostSettings { min_points: 0, ..good }, "min_points"),
            (PostSettings { min_intensity: f32::NAN, ..good }, "min_intensity"),
            (PostSettings { range_min_m: -0.1, ..good }, "range_min_m"),
            (PostSettings { range_max_m: 0.1, ..good }, "range_max_m"),
        ] {
            assert_eq!(settings.check().unwrap_err().field, field);
        }
    }
}
