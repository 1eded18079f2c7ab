//! Measurement model of a post: number of beams on it, probability of detection, and noise.

use crate::settings::PostSettings;

/// Angular resolution and noise of a lidar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Angle between beams, rad, the magnitude of [`Scan::step_rad`](crate::Scan::step_rad); above 0. At 4 500 points per second
    /// and 10 Hz it is 0.8°.
    pub step_rad: f32,
    /// Standard deviation of a single range, m.
    pub range_sigma_m: f32,
    /// Share of the beams with a return among those that hit an object: above 0, at most 1.
    pub returned: f32,
}

impl Resolution {
    /// An LD06 at 10 Hz: by its manual 4 500 points per second, and a standard deviation of 10 mm from 0.3 m on. The mean may
    /// have an error of up to 45 mm, which is the same for all posts nearby; it is not noise, and not included.
    pub const LD06: Self = Self { step_rad: 0.013_962_634, range_sigma_m: 0.01, returned: 0.99 };

    /// Angular width of a post at this range (m) in steps; the greatest width if the lidar is inside the post.
    #[must_use]
    pub fn steps_wide(&self, settings: &PostSettings, range_m: f32) -> f32 {
        let sine = (settings.radius_m / range_m).min(1.0);
        2.0 * libm::asinf(sine) / self.step_rad
    }

    /// The probability of detection of a post at this range, m, without occlusion. The phase of the beams is random: a post with
    /// a width of `w` steps has `⌊w⌋` beams on it, and one more with a probability of the fraction of `w`. The required number of
    /// beams must have a return; with one beam more than required on the post, detection is nearly certain.
    #[must_use]
    pub fn detection_probability(&self, settings: &PostSettings, range_m: f32) -> f32 {
        if !(range_m >= settings.range_min_m && range_m <= settings.range_max_m) {
            return 0.0;
        }
        let spare = self.steps_wide(settings, range_m) - f32::from(settings.min_points);
        let enough = (spare + 1.0).clamp(0.0, 1.0);
        let missed = 1.0 - libm::powf(self.returned, f32::from(settings.min_points));
        enough * (1.0 - missed * (1.0 - spare).clamp(0.0, 1.0))
    }

    /// The greatest range, m, at which a post is detected with at least this probability, if all beams have a return.
    #[must_use]
    pub fn reach_m(&self, settings: &PostSettings, probability: f32) -> f32 {
        let wide = f32::from(settings.min_points) - 1.0 + probability.clamp(0.0, 1.0);
        let sine = libm::sinf((0.5 * wide * self.step_rad).min(core::f32::consts::FRAC_PI_2));
        if sine > 0.0 { (settings.radius_m / sine).min(settings.range_max_m) } else { settings.range_max_m }
    }

    /// Standard deviation of the bearing of a detected post at this range, rad. The position of the outer beams within the post
    /// is unknown: if the width exceeds a whole number of steps by the fraction `f`, the variance is `(f³ + (1−f)³)` times that
    /// of a uniform distribution over a step, step²/12. If one beam more is required than is certainly on the post, only `f`
    /// remains. An outer beam without a return moves the centre by half a step.
    #[must_use]
    pub fn bearing_sigma_rad(&self, settings: &PostSettings, range_m: f32) -> f32 {
        let wide = self.steps_wide(settings, range_m);
        let needed = f32::from(settings.min_points);
        let cubes = if wide < needed {
            let left = (wide - (needed - 1.0)).max(0.0);
            left * left
        } else {
            let left = wide - libm::floorf(wide);
            cube(left) + cube(1.0 - left) + 6.0 * (1.0 - self.returned)
        };
        self.step_rad * libm::sqrtf(cubes / 12.0)
    }

    /// Standard deviation of the range of a detected post at this range, m: from the noise of its readings, and from the unknown
    /// position of the beams on the round front, less than a tenth of the radius for a single reading (tested below with beams at
    /// all phases).
    #[must_use]
    pub fn post_range_sigma_m(&self, settings: &PostSettings, range_m: f32) -> f32 {
        let rays = self.steps_wide(settings, range_m).max(f32::from(settings.min_points));
        let front = SHAPE * settings.radius_m;
        libm::sqrtf((self.range_sigma_m * self.range_sigma_m + front * front) / rays)
    }

    /// The greatest standard deviations of range (m) and bearing (rad) of posts within the limits of the range: for a filter
    /// whose sensor has the same noise at every range.
    #[must_use]
    pub fn worst_sigmas(&self, settings: &PostSettings) -> [f32; 2] {
        let PostSettings { range_min_m, range_max_m, .. } = *settings;
        let far = range_max_m.min(self.reach_m(settings, 0.0));
        let mut worst = [0.0_f32; 2];
        for place in 1..=WITHIN_VIEW {
            let range_m = range_min_m + (far - range_min_m) * f32::from(place) / f32::from(WITHIN_VIEW);
            let here = [self.post_range_sigma_m(settings, range_m), self.bearing_sigma_rad(settings, range_m)];
            worst.iter_mut().zip(here).for_each(|(worst, here)| *worst = worst.max(here));
        }
        worst
    }
}

/// Number of ranges at which the greatest noise is computed.
const WITHIN_VIEW: u16 = 16;

/// Standard deviation of a single range from the round front, as a share of the radius.
const SHAPE: f32 = 0.1;

fn cube(x: f32) -> f32 {
    x * x * x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thin_post_is_detected_within_its_reach() {
        let posts = PostSettings::of_radius(0.05);
        let lidar = Resolution { returned: 1.0, ..Resolution::LD06 };
        assert_eq!(lidar.detection_probability(&posts, 2.0), 1.0);
        assert_eq!(lidar.detection_probability(&posts, 13.0), 0.0);
        assert_eq!(lidar.detection_probability(&posts, f32::NAN), 0.0);
        for probability in [0.1, 0.5, 0.9] {
            let reach = lidar.reach_m(&posts, probability);
            let back = lidar.detection_probability(&posts, reach);
            assert!((back - probability).abs() < 1e-3, "{reach} {back}");
        }
        // With one point required instead of two, the range is about three times as great.
        let single = PostSettings { min_points: 1, ..posts };
        assert!(lidar.reach_m(&single, 0.5) > 2.9 * lidar.reach_m(&posts, 0.5).min(4.0));
    }

    /// Compared with beams on a circle at every phase.
    #[test]
    fn noise_is_that_of_beams_on_a_circle() {
        let posts = PostSettings::of_radius(0.1);
        let lidar = Resolution { range_sigma_m: 0.0, returned: 1.0, ..Resolution::LD06 };
        for range in [2.0_f32, 3.3, 5.1, 7.0, 10.0, 12.0] {
            let half = (posts.radius_m / range).asin();
            let (mut squares, mut seen, mut bias) = ([0.0; 2], 0.0, 0.0);
            for phase in 0..10_000 {
                let first = -half + lidar.step_rad * (phase as f32 + 0.5) / 10_000.0;
                let rays: std::vec::Vec<f32> =
                    (0..).map(|k| first + k as f32 * lidar.step_rad).take_while(|angle| *angle < half).collect();
                let [Some(first), Some(last)] = [rays.first(), rays.last()] else { continue };
                let depths = rays.iter().map(|angle| {
                    let aside = range * angle.sin();
                    range * angle.cos() - (posts.radius_m.powi(2) - aside * aside).max(0.0).sqrt()
                });
                if rays.len() < 2 {
                    continue;
                }
                let mean = depths.sum::<f32>() / rays.len() as f32
                    + posts.depth_m(rays.len(), last - first, range, lidar.step_rad)
                    - range;
                squares[0] += (0.5 * (first + last)).powi(2);
                squares[1] += mean * mean;
                bias += mean;
                seen += 1.0;
            }
            let [bearing, depth] = squares.map(|square| (square / seen).sqrt());
            let expected = lidar.bearing_sigma_rad(&posts, range);
            assert!((bearing / expected - 1.0).abs() < 0.02, "{range} m: {bearing} for {expected}");
            assert!((bias / seen).abs() < 0.004, "{range} m: {}", bias / seen);
            // Beams with constant spacing are better than the same number at random positions.
            let bound = lidar.post_range_sigma_m(&posts, range);
            assert!(depth < bound, "{range} m: {depth} for {bound}");
        }
    }
}
