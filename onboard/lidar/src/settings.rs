//! Settings of the finder.

/// Properties of the posts or reflectors to find.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PostSettings {
    /// Radius of the posts, m: above 0.
    pub radius_m: f32,
    /// Tolerance of the width of a cluster, m, in addition to that from the angle between beams: at least 0.
    pub tolerance_m: f32,
    /// Greatest difference of the ranges of adjacent beams on one object, m: above 0, and above the noise of two readings.
    pub gap_m: f32,
    /// Number of points that a post must have: at least 1. A greater number excludes single false readings, and shortens the range:
    /// [`Resolution::detection_probability`](crate::Resolution::detection_probability).
    pub min_points: u16,
    /// Least intensity of a beam on a post, in the lidar's own unit: 0 for posts without reflectors, about 200 for reflectors of
    /// an LD06.
    pub min_intensity: f32,
    /// Least range of a post, m: at least 0.
    pub range_min_m: f32,
    /// Greatest range of a post, m: above the least.
    pub range_max_m: f32,
}

impl PostSettings {
    /// For posts of this radius, m, without reflectors, with the range of an LD06 and at least two points.
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

    /// Checks all fields.
    ///
    /// # Errors
    /// Names the field that is out of range.
    pub fn check(&self) -> Result<(), SettingsError> {
        let wrong = |field, range| Err(SettingsError { field, range });
        let Self { radius_m, tolerance_m, gap_m, min_points, min_intensity, range_min_m, range_max_m } = *self;
        // The comparisons are written so that NaN fails them.
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

    /// Mean distance from the readings to the axis of the post, m, for this number of beams with this span and step. The cluster
    /// is about the centre of the post, or beside it by at most the excess of the post's width.
    pub(crate) fn depth_m(&self, rays: usize, span_rad: f32, range_m: f32, step_rad: f32) -> f32 {
        let (width, span, step) = (2.0 * self.radius_m, range_m * span_rad, range_m * step_rad);
        let open = (width - span).max(0.0);
        let aside = 0.5 * open.min(2.0 * step - open).max(0.0);
        let (mut sum, mut count) = (0.0, 0.0);
        let places = rays.min(ENOUGH_RAYS);
        // Each beam is at the centre of a step.
        let covered = if rays > 1 { span * rays as f32 / (rays - 1) as f32 } else { 0.0 };
        for place in 0..places {
            let across = covered * ((place as f32 + 0.5) / places as f32 - 0.5);
            for shift in SHIFTS {
                let x = across + shift * aside;
                sum += libm::sqrtf((self.radius_m * self.radius_m - x * x).max(0.0));
                count += 1.0;
            }
        }
        // Ranges beside the axis are longer than their component along it, by the mean of range · (1 − cos).
        let slant = range_m * span_rad * span_rad / 24.0;
        if count > 0.0 { sum / count + slant } else { 0.0 }
    }
}

/// Greatest number of positions that are evaluated instead of all beams.
const ENOUGH_RAYS: usize = 16;

/// Offsets that represent the interval from −1 to 1.
const SHIFTS: [f32; 4] = [-0.75, -0.25, 0.25, 0.75];

/// A field of the settings is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[error("{field} must be {range}")]
pub struct SettingsError {
    /// Name of the field.
    pub field: &'static str,
    /// Its valid range.
    pub range: &'static str,
}

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
