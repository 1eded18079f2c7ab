//! Pixels of a stereo camera.

use super::finding::{Findings, percent, quantile, short};
use scphd_log::underwater::Log;

/// Noise moves a pixel across the edge of the image by at most about this number of standard deviations.
const SIGMAS: f64 = 3.0;
/// The same share as in the plane: greatest share of keypoints out of view.
const OUT_SHARE: f64 = 0.03;
/// Least number of keypoints.
const KEYPOINTS: usize = 100;

/// The share of the keypoints that no such camera can see; `None` without keypoints.
pub(super) fn camera(log: &Log, findings: &mut Findings) -> Option<f64> {
    let camera = &log.camera;
    let all: Vec<&[f64; 4]> = log.scans.iter().flat_map(|scan| &scan.detections).collect();
    if all.is_empty() {
        return None;
    }
    let share =
        |bad: &dyn Fn(&[f64; 4]) -> bool| all.iter().filter(|pixels| bad(pixels)).count() as f64 / all.len() as f64;
    let sigma = |k: usize| libm::hypot(camera.pixel_sigmas[k], camera.common_sigmas[k % 2]);
    let beyond = |pixels: &[f64; 4]| {
        (0..4).any(|k| {
            let slack = SIGMAS * sigma(k);
            !(-slack..=camera.size_px[k % 2] + slack).contains(&pixels[k])
        })
    };
    let out = share(&beyond);
    if all.len() < KEYPOINTS {
        return Some(out);
    }
    if out > OUT_SHARE {
        findings.warn(
            "out-of-view",
            "detections.csv",
            format!("{} of the keypoints lie out of the image of {} by {} px", percent(out), camera.size_px[0], camera.size_px[1]),
            "pixels are counted from the upper left corner of an image of that size: scale fu, fv, cu, cv and the pixels to it",
        );
    }
    // In the left image every point is farther to the right.
    let swapped = share(&|pixels| pixels[0] <= pixels[2]);
    if swapped > OUT_SHARE {
        findings.warn(
            "images-exchanged",
            "detections.csv",
            format!(
                "{} of the keypoints lie no farther to the right in the left image than in the right one",
                percent(swapped)
            ),
            "ul_px and vl_px are of the left camera: exchange the images",
        );
        return Some(out);
    }
    // The matcher drops pairs with a greater difference of rows.
    let uneven = share(&|pixels| !((pixels[1] - pixels[3]).abs() <= 2.0 * camera.row_tolerance_px));
    if uneven > OUT_SHARE {
        findings.warn(
            "images-not-rectified",
            "detections.csv",
            format!(
                "in {} of the pairs the rows differ by more than {} px",
                percent(uneven),
                2.0 * camera.row_tolerance_px
            ),
            "rectify both images: a feature has the same row in either",
        );
    }
    let depth_m = quantile(all.iter().map(|pixels| camera.focal_baseline / (pixels[0] - pixels[2])).collect(), 0.5);
    if let Some(depth_m) = depth_m.filter(|depth_m| !(camera.depth_m[0]..=camera.depth_m[1]).contains(depth_m)) {
        findings.warn(
            "depth",
            "log.toml, section camera",
            format!(
                "the median depth is {} m, keypoints are matched between {} m and {} m",
                short(depth_m),
                camera.depth_m[0],
                camera.depth_m[1]
            ),
            "check baseline_m (metres) and fu (pixels): depth is fu times baseline over ul - ur",
        );
    }
    Some(out)
}
