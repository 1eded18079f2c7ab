//! Logs of a stereo camera that moves in space.
//!
//! | file | content |
//! |---|---|
//! | `log.toml` | name, whether it is simulated, as for a log in the plane, and `[camera]`: see below |
//! | `odometry.csv` | `t_s,vx_mps,vy_mps,vz_mps,wx_radps,wy_radps,wz_radps`: velocities and rates along the vehicle's axes |
//! | `scans.csv` | `scan,t_s` |
//! | `detections.csv` | `scan,ul_px,vl_px,ur_px,vr_px` |
//! | `truth.csv` | `t_s,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad`: position, and the rotation from the map to the vehicle as axis times angle |
//! | `landmarks.csv` | optional: `x_m,y_m,z_m` |
//!
//! `[camera]` has `fu`, `fv`, `cu`, `cv` (px), `baseline_m`, the rotation `C_cv` from the vehicle's axes to the camera's, the
//! position `rho_cv` of the camera in the vehicle's frame (m), and the variances of the noise: `pixel_variance` (px²), of the
//! velocities `velocity_variance` (m²/s²), and of the rates `rate_variance` (rad²/s²).
//!
//! The vehicle's frame here is that of a vehicle whose camera looks 45° down and ahead. The rig looks straight down most of the
//! time and straight ahead for the first seconds; in its own frame, or in that of a camera that looks down, roll and yaw could
//! not be distinguished in one of the two positions. Velocities and rates are transformed to this frame.
//!
//! **Roll and pitch are those of the truth**, because the thesis relies on the inertial unit for both. Yaw is the integral of the
//! measured rates from the true initial yaw, and the yaw rate is the rotation about the vertical that remains from the measured
//! rates after the change of roll and pitch in a step.

use super::error::{LogError, Place, Problem};
use super::head::{Section, name, simulated, syntax};
use super::scans::{Clock, each_detection, scan_times};
use super::table::{Table as Csv, text};
use super::units::{self, ODOMETRY_INTERVAL_S, Stamp, WHOLE_TURN_RAD};
use crate::angle::wrap;
use crate::dimensions::Underwater;
use crate::log::{Scan, TruePose};
use crate::underwater::{Camera, Instruments, Landmark, Log, Nominal};
use nalgebra::{Matrix3, Vector3};
use scphd::models::{projection, rotation};
use std::path::Path;
use toml::Table;

pub fn has_camera(dir: &Path) -> bool {
    let table = text(dir, "log.toml").ok().flatten().and_then(|text| text.parse::<Table>().ok());
    table.is_some_and(|table| table.contains_key("camera") && !table.contains_key("sensor"))
}

/// Depths between which features are detected reliably, m, from the features that the real camera missed.
const DEPTH_M: [f64; 2] = [0.3, 3.5];
/// Size of the images of all available logs, px.
const SIZE_PX: [f64; 2] = [640.0, 480.0];
/// Independent standard deviations of column and row in an image of the real log, px: those of the differences between both images
/// divided by √2, with known truth. The rest of the noise, which is the greater part, is common to both images, and to all features
/// of a frame: it is an error of the attitude, not of the pixels.
const OWN_PX: [f64; 2] = [2.4, 1.3];
/// Greatest difference of the rows of a pair, px: far less than the noise of each row, most of which is common.
const ROW_TOLERANCE_PX: f64 = 13.0;

pub fn read_underwater(dir: &Path) -> Result<Log, LogError> {
    let content = text(dir, "log.toml")?.ok_or_else(|| Place::File("log.toml").error(Problem::Missing))?;
    let table: Table = content.parse().map_err(|error| syntax(&content, &error))?;
    let top = Section { name: "".into(), table: &table };
    let section = top.section("camera")?;
    top.has_only(&TOP_KEYS)?;
    section.has_only(&CAMERA_KEYS)?;
    let name = name(&top)?;
    let simulated = simulated(&top)?;
    let rig = Rig::of(&section)?;
    let camera = camera(&section, &rig)?;
    let velocity = variances(&section, "velocity_variance")?;
    let rate = variances(&section, "rate_variance")?;
    let (truth, tilts) = truth(dir, &rig)?;
    let (rows, stamps) = instruments(dir, &truth, &tilts, &rig, rate)?;
    let start = truth.first().and_then(|row| Some((row, row.heading_rad?)));
    let (start, start_yaw_rad) = start.ok_or_else(|| Place::File("truth.csv").error(Problem::Empty))?;
    let (scans, scan_stamps) = frames(dir)?;
    units::common_clock(&stamps, &scan_stamps)?;
    let speeds = rows.iter().map(|row| row.velocity_mps.map_or(0.0, |velocity| Vector3::from(velocity).norm()));
    units::way(&stamps, speeds, &scan_stamps, DEPTH_M[1], "vx_mps")?;
    Ok(Log {
        name,
        camera,
        nominal: Nominal::of_instruments(
            velocity.iter().copied().fold(0.0, f64::max).sqrt(),
            0.02,
            rate.iter().copied().fold(0.0, f64::max).sqrt(),
        ),
        start: (start.position, start_yaw_rad),
        simulated,
        instruments: rows,
        scans,
        truth,
        landmarks: landmarks(dir)?,
    })
}

const TOP_KEYS: [&str; 7] = ["name", "kind", "simulated", "source", "note", "truth", "camera"];
const CAMERA_KEYS: [&str; 10] =
    ["fu", "fv", "cu", "cv", "baseline_m", "C_cv", "rho_cv", "pixel_variance", "velocity_variance", "rate_variance"];

/// Three variances, at least one of them above 0.
fn variances(section: &Section, key: &str) -> Result<[f64; 3], LogError> {
    let variances: [f64; 3] = section.numbers(key, "three variances")?;
    for variance in variances {
        section.check(key, variance, "0 to 1e6", |v| (0.0..=1e6).contains(&v))?;
    }
    section.check(key, variances.iter().copied().fold(0.0, f64::max), "one that is more than 0", |v| v > 0.0)?;
    Ok(variances)
}

/// The rotation from the vehicle's axes (x ahead, y to the left, z upwards) to those of the image of a camera that looks 45° down
/// and ahead.
fn to_image() -> Matrix3<f64> {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    Matrix3::new(0.0, -1.0, 0.0, -half, 0.0, -half, half, 0.0, -half)
}

/// Tolerance of rotations, which logs have with few digits.
const ROTATION_SLACK: f64 = 1e-3;

/// The camera's pose in the rig.
struct Rig {
    /// The rotation from the rig's axes to those of the vehicle.
    turn: Matrix3<f64>,
    /// Position of the left camera in the rig, m.
    place: Vector3<f64>,
}

impl Rig {
    fn of(section: &Section) -> Result<Self, LogError> {
        let place: [f64; 3] = section.numbers("rho_cv", "three finite numbers")?;
        let value = section.get("C_cv")?;
        let rows = value.as_array().filter(|rows| rows.len() == 3);
        let numbers: Option<Vec<f64>> = rows.and_then(|rows| {
            let flat =
                rows.iter().map(|row| row.as_array().filter(|row| row.len() == 3)).collect::<Option<Vec<_>>>()?;
            flat.into_iter().flatten().map(super::head::finite).collect()
        });
        let numbers = numbers.ok_or_else(|| section.ill_typed("C_cv", value, "three rows of three finite numbers"))?;
        let turn: Matrix3<f64> = Matrix3::from_row_slice(&numbers);
        let off = (turn * turn.transpose() - Matrix3::identity()).abs().max();
        if !(off <= ROTATION_SLACK && turn.determinant() > 0.0) {
            return Err(section.key("C_cv").error(Problem::NoRotation));
        }
        for coordinate in place {
            section.check("rho_cv", coordinate, "-1000 to 1000 m", |x| x.abs() <= 1e3)?;
        }
        Ok(Self { turn: to_image().transpose() * turn, place: place.into() })
    }
}

fn camera(section: &Section, rig: &Rig) -> Result<Camera, LogError> {
    let [fu, fv, cu, cv] = [section.number("fu")?, section.number("fv")?, section.number("cu")?, section.number("cv")?];
    let baseline_m = section.number("baseline_m")?;
    section.check("baseline_m", baseline_m, "more than 0 and at most 1000 m", |b| b > 0.0 && b <= 1e3)?;
    for (key, focal) in [("fu", fu), ("fv", fv)] {
        section.check(key, focal, "more than 0 and at most 1e6 px", |f| f > 0.0 && f <= 1e6)?;
    }
    for (key, centre) in [("cu", cu), ("cv", cv)] {
        section.check(key, centre, "-1e6 to 1e6 px", |c| c.abs() <= 1e6)?;
    }
    let to_image = to_image();
    let calibration = Matrix3::new(fu, 0.0, cu, 0.0, fv, cv, 0.0, 0.0, 1.0);
    let left = rig.turn * rig.place;
    let right = left + to_image.transpose() * Vector3::new(baseline_m, 0.0, 0.0);
    let variances: [f64; 4] = section.numbers("pixel_variance", "four variances")?;
    for variance in variances {
        section.check("pixel_variance", variance, "more than 0 and at most 1e6", |v| v > 0.0 && v <= 1e6)?;
    }
    Ok(Camera {
        projections: [left, right].map(|place| {
            let p = projection(&calibration, &to_image, &place);
            std::array::from_fn(|row| std::array::from_fn(|column| p[(row, column)]))
        }),
        size_px: SIZE_PX,
        pixel_sigmas: std::array::from_fn(|k| OWN_PX[k % 2].min(variances[k].sqrt())),
        common_sigmas: std::array::from_fn(|k| {
            let mean = 0.5 * (variances[k] + variances[k + 2]);
            (mean - OWN_PX[k] * OWN_PX[k]).max(0.0).sqrt()
        }),
        depth_m: DEPTH_M,
        focal_baseline: fu * baseline_m,
        row_tolerance_px: ROW_TOLERANCE_PX,
    })
}

/// The rotation by axis times angle. With those of `truth.csv`, which are for the rotation from the map to the vehicle with the
/// opposite sign convention, it is the rotation from the vehicle to the map.
fn attitude(axis_angle: Vector3<f64>) -> Matrix3<f64> {
    let angle = axis_angle.norm();
    if angle == 0.0 {
        return Matrix3::identity();
    }
    let (s, c, axis) = (libm::sin(angle), libm::cos(angle), axis_angle / angle);
    Matrix3::identity() * c + axis * axis.transpose() * (1.0 - c) + axis.cross_matrix() * s
}

/// Roll, pitch and yaw of a rotation from the vehicle to the map.
fn angles(turned: &Matrix3<f64>) -> [f64; 3] {
    let level = libm::hypot(turned[(0, 0)], turned[(1, 0)]);
    [
        libm::atan2(turned[(2, 1)], turned[(2, 2)]),
        libm::atan2(-turned[(2, 0)], level),
        libm::atan2(turned[(1, 0)], turned[(0, 0)]),
    ]
}

/// The true trajectory, and roll and pitch at its rows.
type Way = (Vec<TruePose<Underwater>>, Vec<[f64; 2]>);

fn truth(dir: &Path, rig: &Rig) -> Result<Way, LogError> {
    let table = Csv::read(dir, "truth.csv")?;
    let time = table.column("t_s")?;
    let position = [table.column("x_m")?, table.column("y_m")?, table.column("z_m")?];
    let rotation = [table.column("rx_rad")?, table.column("ry_rad")?, table.column("rz_rad")?];
    let mut clock = Clock::new();
    let (mut truth, mut tilts) = (Vec::new(), Vec::new());
    for row in table.rows() {
        let t_s = clock.tick(&row, row.number(&time)?)?;
        let [x, y, z] = position.each_ref().map(|column| row.number(column));
        let [rx, ry, rz] = rotation.each_ref().map(|column| row.number(column));
        let axis_angle = Vector3::new(rx?, ry?, rz?);
        units::radians(axis_angle.norm(), WHOLE_TURN_RAD, || row.cell("rx_rad"))?;
        let [roll, pitch, yaw_rad] = angles(&(attitude(axis_angle) * rig.turn.transpose()));
        truth.push(TruePose { t_s, position: [x?, y?, z?], heading_rad: Some(yaw_rad) });
        tilts.push([roll, pitch]);
    }
    Ok((truth, tilts))
}

/// A row of `odometry.csv`: time, velocity and rates in the vehicle's frame, roll and pitch.
struct Row {
    t_s: f64,
    velocity: Vector3<f64>,
    rates: Vector3<f64>,
    tilt: [f64; 2],
}

fn instruments(
    dir: &Path,
    truth: &[TruePose<Underwater>],
    tilts: &[[f64; 2]],
    rig: &Rig,
    rate_variance: [f64; 3],
) -> Result<(Vec<Instruments>, Vec<Stamp>), LogError> {
    let table = Csv::read(dir, "odometry.csv")?;
    let time = table.column("t_s")?;
    let velocity = [table.column("vx_mps")?, table.column("vy_mps")?, table.column("vz_mps")?];
    let rates = [table.column("wx_radps")?, table.column("wy_radps")?, table.column("wz_radps")?];
    let mut clock = Clock::new();
    let (mut rows, mut stamps): (Vec<Row>, Vec<Stamp>) = (Vec::new(), Vec::new());
    for row in table.rows() {
        let t_s = clock.tick(&row, row.number(&time)?)?;
        let [vx, vy, vz] = velocity.each_ref().map(|column| row.number(column));
        let [wx, wy, wz] = rates.each_ref().map(|column| row.number(column));
        let at = truth.partition_point(|true_row| true_row.t_s <= t_s).saturating_sub(1);
        let tilt = *tilts.get(at).ok_or_else(|| Place::File("truth.csv").error(Problem::Empty))?;
        let (velocity, rates) = (rig.turn * Vector3::new(vx?, vy?, vz?), rig.turn * Vector3::new(wx?, wy?, wz?));
        rows.push(Row { t_s, velocity, rates, tilt });
        stamps.push(Stamp { place: row.cell("t_s"), t_s });
    }
    units::interval(&stamps, ODOMETRY_INTERVAL_S)?;
    let variance = rig.turn * Matrix3::from_diagonal(&Vector3::from(rate_variance)) * rig.turn.transpose();
    let mut yaw_rad = truth.first().and_then(|row| row.heading_rad).unwrap_or(0.0);
    let mut instruments = Vec::with_capacity(rows.len());
    for (place, row) in rows.iter().enumerate() {
        let [roll_rad, pitch_rad] = row.tilt;
        let level: Matrix3<f64> = rotation(roll_rad, pitch_rad, 0.0);
        let next = rows.get(place + 1).filter(|next| next.t_s > row.t_s);
        let turned_rad = next.map_or(0.0, |next| about_the_vertical(row, next));
        let yaw_rate_radps = next.map_or(0.0, |next| turned_rad / (next.t_s - row.t_s));
        let sigma = (level * variance * level.transpose())[(2, 2)].sqrt();
        instruments.push(Instruments {
            t_s: row.t_s,
            roll_rad,
            pitch_rad,
            yaw_rad,
            yaw_rate_radps,
            yaw_rate_sigma_radps: Some(sigma),
            velocity_mps: Some(row.velocity.into()),
            z_m: None,
        });
        yaw_rad = wrap(yaw_rad + turned_rad);
    }
    Ok((instruments, stamps))
}

/// The change of yaw for which the rates of a row agree best with roll and pitch of the next row, rad.
fn about_the_vertical(row: &Row, next: &Row) -> f64 {
    let [from, to]: [Matrix3<f64>; 2] = [row, next].map(|row| rotation(row.tilt[0], row.tilt[1], 0.0));
    let left = from * attitude(row.rates * (next.t_s - row.t_s)) * to.transpose();
    libm::atan2(left[(1, 0)] - left[(0, 1)], left[(0, 0)] + left[(1, 1)])
}

fn frames(dir: &Path) -> Result<(Vec<Scan<Underwater>>, Vec<Stamp>), LogError> {
    let (numbers, stamps) = scan_times(&super::table::Table::read(dir, "scans.csv")?)?;
    let mut scans: Vec<Scan<_>> = stamps.iter().map(|stamp| Scan { t_s: stamp.t_s, ..Scan::default() }).collect();
    each_detection(dir, &numbers, ["ul_px", "vl_px", "ur_px", "vr_px"], |index, _, pixels, _| {
        scans[index].detections.push(pixels);
        Ok(())
    })?;
    Ok((scans, stamps))
}

fn landmarks(dir: &Path) -> Result<Vec<Landmark>, LogError> {
    let Some(table) = Csv::read_optional(dir, "landmarks.csv")? else { return Ok(Vec::new()) };
    let columns = [table.column("x_m")?, table.column("y_m")?, table.column("z_m")?];
    table
        .rows()
        .map(|row| {
            let [x, y, z] = columns.each_ref().map(|column| row.number(column));
            Ok(Landmark { position: [x?, y?, z?], detectability: 1.0 })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_and_angle_rotate_as_documented() {
        // C_vi = cos a I + (1 − cos a) n nᵀ − sin a [n]×, whose transpose is used here.
        let r: Vector3<f64> = Vector3::new(0.3, -1.2, 0.8);
        let (a, n) = (r.norm(), r.normalize());
        let map_to_vehicle =
            Matrix3::identity() * a.cos() + n * n.transpose() * (1.0 - a.cos()) - n.cross_matrix() * a.sin();
        assert!((attitude(r) - map_to_vehicle.transpose()).norm() < 1e-14);
        let [roll, pitch, yaw] = angles(&attitude(r));
        assert!((rotation(roll, pitch, yaw) - attitude(r)).norm() < 1e-14);
        assert_eq!(attitude(Vector3::zeros()), Matrix3::identity());
    }

    /// Features projected with the true poses agree with the measured pixels, and the drift has the expected size.
    #[test]
    fn the_real_log_is_read_with_the_right_axes() {
        let Some(dir) = scphd_shared_data::find("starry_night") else { return };
        assert!(has_camera(&dir));
        let log = read_underwater(&dir).unwrap();
        assert_eq!((log.scans.len(), log.instruments.len(), log.landmarks.len()), (1900, 1900, 20));
        let table = Csv::read(&dir, "detections.csv").unwrap();
        let label = table.column("label_landmark").unwrap();
        let labels: Vec<i64> = table.rows().map(|row| row.integer(&label).unwrap()).collect();
        let (mut place, mut squares, mut count) = (0, [0.0; 4], 0.0);
        for (scan, (truth, tilt)) in log.scans.iter().zip(log.truth.iter().zip(&log.instruments)) {
            let turned: Matrix3<f64> = rotation(tilt.roll_rad, tilt.pitch_rad, truth.heading_rad.unwrap());
            for keypoints in &scan.detections {
                let feature = Vector3::from(log.landmarks[labels[place] as usize].position);
                let point = turned.tr_mul(&(feature - Vector3::from(truth.position))).push(1.0);
                for (side, matrix) in log.camera.projections.iter().enumerate() {
                    let p = nalgebra::Matrix3x4::from_fn(|row, column| matrix[row][column]) * point;
                    for (k, pixel) in [p.x / p.z, p.y / p.z].into_iter().enumerate() {
                        squares[2 * side + k] += (keypoints[2 * side + k] - pixel).powi(2);
                    }
                }
                (place, count) = (place + 1, count + 1.0);
            }
        }
        for (k, square) in squares.iter().enumerate() {
            let (measured, stated) =
                ((square / count).sqrt(), log.camera.pixel_sigmas[k].hypot(log.camera.common_sigmas[k % 2]));
            assert!((measured / stated - 1.0).abs() < 0.06, "{measured} px, {stated} stated");
        }
        // Over ten seconds the integrated velocities agree with the truth.
        let (mut position, rows) = (Vector3::from(log.truth[0].position), &log.instruments[..212]);
        for (pair, truth) in rows.windows(2).zip(&log.truth) {
            let turned: Matrix3<f64> = rotation(pair[0].roll_rad, pair[0].pitch_rad, truth.heading_rad.unwrap());
            position += turned * Vector3::from(pair[0].velocity_mps.unwrap()) * (pair[1].t_s - pair[0].t_s);
        }
        let off = (position - Vector3::from(log.truth[211].position)).norm();
        assert!(off < 0.15, "{off}");
    }
}
