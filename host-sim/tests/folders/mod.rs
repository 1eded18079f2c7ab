//! Log folders as texts, for tests that change them.

use std::fs;
use std::path::Path;

/// Numbers of frames and landmarks of [`stereo`].
pub const FRAMES: usize = 24;
pub const LANDMARKS: usize = 12;

/// Focal length, px, principal point, px, and baseline, m, of [`stereo`].
const FOCAL: f64 = 480.0;
const CENTRE: [f64; 2] = [320.0, 240.0];
const BASELINE: f64 = 0.24;

/// The files of a folder, by name.
pub type Files = Vec<(&'static str, Vec<u8>)>;

/// Writes the files into a folder, which is created if necessary.
pub fn put(dir: &Path, files: &Files) {
    fs::create_dir_all(dir).unwrap();
    for (name, bytes) in files {
        fs::write(dir.join(name), bytes).unwrap();
    }
}

/// A stereo rig with a forward view moves to the right along a wall with landmarks, at ten frames a second.
///
/// The rig's axes are the camera's (x to the right, y down, z ahead), and the map's are the rig's. Without noise, except for
/// rounding of pixels to three decimals.
pub fn stereo() -> Files {
    let landmarks: Vec<[f64; 3]> = (0..LANDMARKS)
        .map(|k| {
            let k = k as f64;
            [0.25 * k - 1.0, 0.6 * (1.7 * k).sin(), 1.8 + 0.4 * (2.9 * k).cos()]
        })
        .collect();
    let (speed, interval) = (0.3, 0.1);
    let (mut odometry, mut scans) =
        (String::from("t_s,vx_mps,vy_mps,vz_mps,wx_radps,wy_radps,wz_radps\n"), String::from("scan,t_s\n"));
    let mut truth = String::from("t_s,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad\n");
    let mut detections = String::from("scan,ul_px,vl_px,ur_px,vr_px,label_landmark\n");
    for frame in 0..FRAMES {
        let t = interval * frame as f64;
        let x = speed * t;
        odometry.push_str(&format!("{t:.3},{speed},0,0,0,0,0\n"));
        scans.push_str(&format!("{frame},{t:.3}\n"));
        truth.push_str(&format!("{t:.3},{x:.6},0,0,0,0,0\n"));
        for (label, landmark) in landmarks.iter().enumerate() {
            let [right, down, ahead] = [landmark[0] - x, landmark[1], landmark[2]];
            let left = [FOCAL * right / ahead + CENTRE[0], FOCAL * down / ahead + CENTRE[1]];
            let other = FOCAL * (right - BASELINE) / ahead + CENTRE[0];
            if (20.0..620.0).contains(&left[0]) && (20.0..460.0).contains(&left[1]) && other > 20.0 {
                let [u, v] = left;
                detections.push_str(&format!("{frame},{u:.3},{v:.3},{other:.3},{v:.3},{label}\n"));
            }
        }
    }
    let rows: String = landmarks.iter().map(|[x, y, z]| format!("{x},{y},{z}\n")).collect();
    let head = format!(
        "name = \"stereo\"\n\n[camera]\nfu = {FOCAL:?}\nfv = {FOCAL:?}\ncu = {:?}\ncv = {:?}\nbaseline_m = {BASELINE}\n\
         C_cv = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\nrho_cv = [0, 0, 0]\npixel_variance = [4.0, 4.0, 4.0, 4.0]\n\
         velocity_variance = [0.01, 0.01, 0.01]\nrate_variance = [0.01, 0.01, 0.01]\n",
        CENTRE[0], CENTRE[1]
    );
    vec![
        ("log.toml", head.into_bytes()),
        ("odometry.csv", odometry.into_bytes()),
        ("scans.csv", scans.into_bytes()),
        ("detections.csv", detections.into_bytes()),
        ("truth.csv", truth.into_bytes()),
        ("landmarks.csv", format!("x_m,y_m,z_m\n{rows}").into_bytes()),
    ]
}
