//! The true trajectory of the vehicle.

use libm::{atan2, cos, sin};
use nalgebra::{Matrix3, Vector3};
use scphd::models::rotation;
use scphd_log::angle::wrap;
use scphd_log::noise::Noise;
use std::f64::consts::PI;

/// A state of the true vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vehicle {
    pub position: Vector3<f64>,
    pub roll_rad: f64,
    pub pitch_rad: f64,
    pub yaw_rad: f64,
    /// Velocity along its axes until the next row, m/s.
    pub velocity_mps: Vector3<f64>,
    pub yaw_rate_radps: f64,
}

impl Vehicle {
    /// The rotation from its axes to those of the map.
    pub fn rotation(&self) -> Matrix3<f64> {
        rotation(self.roll_rad, self.pitch_rad, self.yaw_rad)
    }
}

/// Position and yaw of the vehicle, row by row.
pub(super) type Course = Vec<(Vector3<f64>, f64)>;

/// Size and sampling of a trajectory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    pub rows: usize,
    pub row_s: f64,
    pub size_m: f64,
}

/// The corners of `lines` parallel lines over a rectangle, in alternating directions.
fn lines([length, width]: [f64; 2], lines: usize) -> Vec<[f64; 2]> {
    let line = |index: usize| {
        let across = width * (index as f64 / (lines - 1) as f64 - 0.5);
        let ends = [[-0.5 * length, across], [0.5 * length, across]];
        if index.is_multiple_of(2) { ends } else { [ends[1], ends[0]] }
    };
    (0..lines).flat_map(line).collect()
}

/// Two crossed lawnmowers over a rectangle: the strips of the second cross all of the first.
pub(super) fn lawnmower(size_m: f64, noise: &mut Noise) -> Vec<[f64; 2]> {
    let (length, width) = (0.8 * size_m, noise.between(0.6, 0.8) * size_m);
    let along = 3 + usize::from(noise.happens(0.5));
    let across = lines([width, length], 3 + usize::from(noise.happens(0.5)));
    let first = lines([length, width], along);
    // From the last corner of the first to the nearest one of the second.
    let end = first[first.len() - 1];
    let sign = |far: f64, at: f64| if far * at < 0.0 { -1.0 } else { 1.0 };
    let [cx, cy] = [across[0][1], across[0][0]];
    let (sx, sy) = (sign(end[0], cx), sign(end[1], cy));
    first.into_iter().chain(across.into_iter().map(|[a, b]| [sx * b, sy * a])).collect()
}

/// Five to seven positions around the centre, in a random order.
pub(super) fn loops(size_m: f64, noise: &mut Noise) -> Vec<[f64; 2]> {
    let count = 5 + (noise.uniform() * 3.0) as usize;
    let mut places: Vec<[f64; 2]> = (0..count)
        .map(|corner| {
            let angle = 2.0 * PI * (corner as f64 + noise.between(-0.3, 0.3)) / count as f64;
            let radius = noise.between(0.22, 0.45) * size_m;
            [radius * cos(angle), radius * sin(angle)]
        })
        .collect();
    noise.shuffle(&mut places);
    places
}

/// Length of a closed path, m.
pub(super) fn length_m(places: &[[f64; 2]]) -> f64 {
    let next = places.iter().cycle().skip(1);
    places.iter().zip(next).map(|(a, b)| libm::hypot(b[0] - a[0], b[1] - a[1])).sum()
}

/// Steers along the positions repeatedly with up to `speed_mps`, at the height `height_m` of time (s) and position.
pub(super) fn steered(
    clock: Clock,
    places: &[[f64; 2]],
    speed_mps: f64,
    height_m: impl Fn(f64, [f64; 2]) -> f64,
) -> Course {
    let towards = |from: [f64; 2], to: [f64; 2]| atan2(to[1] - from[1], to[0] - from[0]);
    let (mut place, mut next, mut rate) = (places[0], 1, 0.0_f64);
    let mut yaw = towards(places[0], places[1]);
    let mut z = height_m(0.0, place);
    // The least radius of turns is 6 % of the world's size; a turn begins within half a second.
    let sharpest = speed_mps / (0.06 * clock.size_m);
    let change = sharpest * clock.row_s / 0.5;
    let mut course = Vec::with_capacity(clock.rows);
    for row in 0..clock.rows {
        course.push((Vector3::new(place[0], place[1], z), yaw));
        let goal = places[next % places.len()];
        if libm::hypot(goal[0] - place[0], goal[1] - place[1]) < 0.09 * clock.size_m {
            next += 1;
        }
        let error = wrap(towards(place, places[next % places.len()]) - yaw);
        let wanted = (speed_mps * 20.0 * error / clock.size_m).clamp(-sharpest, sharpest);
        rate += (wanted - rate).clamp(-change, change);
        let t_s = row as f64 * clock.row_s;
        let speed = speed_mps * (1.0 + 0.15 * sin(0.2 * t_s));
        place = [place[0] + speed * cos(yaw) * clock.row_s, place[1] + speed * sin(yaw) * clock.row_s];
        yaw = wrap(yaw + rate * clock.row_s);
        // The climb rate is at most half of the speed.
        let climb = 0.5 * speed_mps * clock.row_s;
        z += (height_m(t_s, place) - z).clamp(-climb, climb);
    }
    course
}

/// Circles around the centre, which the vehicle faces, up and down between two heights.
pub(super) fn orbit(clock: Clock, radius_m: f64, heights_m: [f64; 2], noise: &mut Noise) -> Course {
    let duration = clock.rows as f64 * clock.row_s;
    let rounds = noise.between(2.2, 3.5);
    let way = if noise.happens(0.5) { 1.0 } else { -1.0 };
    let (first, rise) = (noise.between(-PI, PI), noise.between(0.7, 1.6));
    let (breath, gaze) = (noise.between(0.0, 2.0 * PI), noise.between(0.0, 2.0 * PI));
    let at = |row: usize| {
        let t_s = row as f64 * clock.row_s;
        let turns = t_s / duration;
        let angle = first + way * 2.0 * PI * rounds * turns;
        let radius = radius_m * (1.0 + 0.05 * sin(0.15 * t_s + breath));
        let share = 0.5 - 0.5 * cos(2.0 * PI * rise * turns);
        let z = heights_m[0] + share * (heights_m[1] - heights_m[0]);
        let yaw = wrap(angle + PI + 0.1 * sin(0.2 * t_s + gaze));
        (Vector3::new(radius * cos(angle), radius * sin(angle), z), yaw)
    };
    (0..clock.rows).map(at).collect()
}

/// The states along a course: with roll and pitch, and the velocity to the next row. The last row is the end of the course.
pub(super) fn driven(course: &Course, row_s: f64, noise: &mut Noise) -> Vec<Vehicle> {
    let mut sway = || (noise.between(0.01, 0.04), noise.between(0.5, 1.2), noise.between(0.0, 2.0 * PI));
    let (roll, pitch) = (sway(), sway());
    let swayed = |(size, rate, phase): (f64, f64, f64), row: usize| size * sin(rate * row as f64 * row_s + phase);
    let states = course.windows(2).enumerate().map(|(row, pair)| {
        let (position, yaw_rad) = pair[0];
        let mut vehicle = Vehicle {
            position,
            roll_rad: swayed(roll, row),
            pitch_rad: swayed(pitch, row),
            yaw_rad,
            velocity_mps: Vector3::zeros(),
            yaw_rate_radps: wrap(pair[1].1 - yaw_rad) / row_s,
        };
        vehicle.velocity_mps = vehicle.rotation().tr_mul(&(pair[1].0 - position)) / row_s;
        vehicle
    });
    states.collect()
}
