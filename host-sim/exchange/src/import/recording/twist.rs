//! Comparison of speed and turn rate with the poses of the same messages.
//!
//! Many drivers fill only one of them correctly. Wrong twists are zero or rounding errors, have no sign when the vehicle
//! reverses, are in the axes of the odometry's frame, or have no turn rate; wrong poses stand still. Over segments of a second
//! both must agree on the motion. If they do not, the poses are used, provided they move as a vehicle does.

use scphd_log::angle::wrap;
use scphd_log::log::{Odometry as Row, Vehicle};

/// A sideways speed above this share of the forward speed means a holonomic vehicle.
const SIDEWAYS: f64 = 0.1;
/// Distance, m, and turn, rad, above which a vehicle has moved.
const MOVED: f64 = 1e-3;
/// Duration of a segment, s: shorter ones are noise, in longer ones motions cancel out.
const PIECE_S: f64 = 1.0;
/// Greatest relative difference of distances and of turns: wheels and filters cause less, errors cause more.
const DIFFER: f64 = 0.25;
/// A segment differs by itself above this relative difference; at least this number of them, and this share of all, mean an
/// intermittent error.
const PIECE_DIFFERS: f64 = 0.5;
const PIECES: usize = 3;
const PIECES_SHARE: f64 = 0.01;
/// A segment counts with at least this share of the usual distance, or with this turn, rad.
const COUNTS: f64 = 0.25;
const TURNS_RAD: f64 = 0.05;
/// Least sum of turns that is compared, rad.
const TURNED_RAD: f64 = 0.5;
/// A step between two poses is a jump if its speed exceeds this multiple of the quantile of most steps by this, m/s: poses were
/// corrected or set.
const JUMP: f64 = 3.0;
const JUMP_MPS: f64 = 1.0;
/// The quantile of most steps, and segments.
const MOST: f64 = 0.75;
/// With a greater share of jumps, or of sideways motion, the poses are not those of a vehicle.
const JUMPS_SHARE: f64 = 0.02;
const ACROSS_SHARE: f64 = 0.3;
/// A distance by the twist below this share of that by the poses counts as none, and vice versa.
const NOTHING: f64 = 0.01;

/// Data of a message.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sample {
    /// Speed, m/s, turn rate, rad/s, or steering angle, rad, and speed to the left, m/s.
    pub control: [f64; 3],
    /// x m, y m, heading rad, if the message has a pose.
    pub pose: Option<[f64; 3]>,
}

/// The odometry of messages.
#[derive(Debug)]
pub(super) struct Rows {
    pub(super) rows: Vec<Row>,
    /// Whether the vehicle also moves sideways.
    pub(super) aside: bool,
    /// Messages to the user.
    pub(super) told: Vec<String>,
}

/// The rows of messages in order of time, for a given vehicle or any.
pub(super) fn rows(topic: &str, samples: &[(f64, Sample)], vehicle: Option<Vehicle>) -> Rows {
    let mut told = Vec::new();
    let may = vehicle.is_none_or(|vehicle| vehicle == Vehicle::Holonomic);
    let greatest = |of: usize| samples.iter().map(|(_, sample)| sample.control[of].abs()).fold(0.0, f64::max);
    let mut aside = greatest(2) > SIDEWAYS * greatest(0);
    let poses: Option<Vec<(f64, [f64; 3])>> = samples.iter().map(|(t_s, sample)| Some((*t_s, sample.pose?))).collect();
    let mut of_poses_alone = None;
    if let Some(poses) = poses.filter(|poses| moves(poses)) {
        match verdict(samples, &poses) {
            Verdict::Same => {}
            Verdict::AheadAlone => aside = false,
            Verdict::Poses(why, across) => {
                told.push(format!("{topic}: the odometry {why}: they are made of its poses"));
                aside = across;
                of_poses_alone = Some(of_poses(samples, &poses));
            }
            Verdict::Twist(why) => told
                .push(format!("{topic}: poses and velocities contradict each other: {why}: the velocities are taken")),
        }
    }
    if aside {
        told.push(match (may, vehicle) {
            (true, None) => "the vehicle moves to the side too: the log is a holonomic vehicle's".to_owned(),
            (true, Some(_)) => "the vehicle moves to the side too".to_owned(),
            (false, _) => "the vehicle moves to the side, which that of the head does not: that is left out".to_owned(),
        });
    }
    let by_twist = || samples.iter().map(|(t_s, sample)| Row { t_s: *t_s, control: sample.control }).collect();
    let mut rows = of_poses_alone.unwrap_or_else(by_twist);
    if vehicle != Some(Vehicle::Holonomic) && !(aside && may) {
        rows.iter_mut().for_each(|row| row.control[2] = 0.0);
    }
    Rows { rows, aside: aside && may, told }
}

pub(super) fn moves(poses: &[(f64, [f64; 3])]) -> bool {
    let Some((_, first)) = poses.first() else { return false };
    poses.iter().any(|(_, pose)| {
        (pose[0] - first[0]).hypot(pose[1] - first[1]) > MOVED || wrap(pose[2] - first[2]).abs() > MOVED
    })
}

enum Verdict {
    Same,
    /// They agree, except for a sideways speed that the poses do not have.
    AheadAlone,
    /// The poses are right: the error of the velocities, and whether the poses move sideways.
    Poses(String, bool),
    /// The velocities are right: the error of the poses.
    Twist(String),
}

/// A motion relative to its start: m ahead, m to the left, rad.
type Moved = [f64; 3];

fn then([x, y, turn]: Moved, [ahead, left, more]: Moved) -> Moved {
    let (s, c) = turn.sin_cos();
    [x + c * ahead - s * left, y + s * ahead + c * left, turn + more]
}

fn between(from: [f64; 3], to: [f64; 3]) -> Moved {
    let ((s, c), dx, dy) = (from[2].sin_cos(), to[0] - from[0], to[1] - from[1]);
    [c * dx + s * dy, -s * dx + c * dy, wrap(to[2] - from[2])]
}

/// The motion with constant speeds and turn rate over a time, s.
fn driven([ahead, left]: [f64; 2], rate: f64, dt_s: f64) -> Moved {
    let turn = rate * dt_s;
    let (s, c) = (0.5 * turn).sin_cos();
    // The chord of the arc; its direction is the heading after half of the turn.
    let chord = if turn.abs() < 1e-6 { 1.0 } else { s / (0.5 * turn) };
    let (ahead, left) = (ahead * dt_s * chord, left * dt_s * chord);
    [c * ahead - s * left, s * ahead + c * left, turn]
}

/// Difference between two descriptions of the same motion.
#[derive(Debug, Clone, Copy, Default)]
struct Differ {
    /// Relative differences of the distances and of the turns.
    way: f64,
    turns: f64,
    /// Number of segments that differ by themselves, and of those that count.
    pieces: [usize; 2],
}

impl Differ {
    fn of(pieces: &[[Moved; 2]]) -> Self {
        let length = |moved: &Moved| moved[0].hypot(moved[1]);
        let mut ways: Vec<f64> = pieces.iter().map(|[a, b]| length(a).max(length(b))).collect();
        ways.sort_by(f64::total_cmp);
        let usual = ways.get((MOST * ways.len() as f64) as usize).copied().unwrap_or(0.0);
        let (mut off, mut way, mut off_rad, mut turned, mut counted) = (0.0, 0.0, 0.0, 0.0, [0; 2]);
        for [a, b] in pieces {
            let (apart, size) = ((a[0] - b[0]).hypot(a[1] - b[1]), length(a).max(length(b)));
            off += apart;
            way += size;
            if size > COUNTS * usual && size > MOVED {
                counted[1] += 1;
                counted[0] += usize::from(apart > PIECE_DIFFERS * size);
            }
            if a[2].abs().max(b[2].abs()) > TURNS_RAD {
                off_rad += wrap(a[2] - b[2]).abs();
                turned += a[2].abs().max(b[2].abs());
            }
        }
        let share = |part: f64, all: f64| if all > 0.0 { part / all } else { 0.0 };
        let turns = if turned > TURNED_RAD { share(off_rad, turned) } else { 0.0 };
        Self { way: share(off, way), turns, pieces: counted }
    }

    fn is_same(&self) -> bool {
        let [differ, all] = self.pieces;
        let now_and_then = differ >= PIECES && differ as f64 > PIECES_SHARE * all as f64;
        self.way <= DIFFER && self.turns <= DIFFER && !now_and_then
    }
}

/// A reading of a sample: the speeds along x and y, m/s, and the turn rate, rad/s.
type Reading<'a> = &'a dyn Fn(usize, &Sample) -> ([f64; 2], f64);

fn verdict(samples: &[(f64, Sample)], poses: &[(f64, [f64; 3])]) -> Verdict {
    let steps: Vec<(f64, Moved)> =
        poses.windows(2).map(|pair| (pair[1].0 - pair[0].0, between(pair[0].1, pair[1].1))).collect();
    let jumps = jumps(&steps);
    let jumped = jumps.iter().filter(|jump| **jump).count();
    let by_twist: f64 = steps.iter().zip(samples).map(|((dt_s, _), (_, sample))| sample.control[0].abs() * dt_s).sum();
    let whole = steps.iter().zip(&jumps).filter(|(_, jump)| !**jump);
    let by_poses: f64 = whole.map(|((_, moved), _)| moved[0].hypot(moved[1])).sum();
    if jumped as f64 > JUMPS_SHARE * steps.len() as f64 && by_twist > NOTHING * by_poses {
        return Verdict::Twist(format!("{jumped} of {} steps of the poses are jumps", steps.len()));
    }
    // Both motions over segments without a jump, for the twist as written and for other readings.
    let told = |of: Reading| -> Vec<[Moved; 2]> {
        let mut pieces = Vec::new();
        let (mut lasts_s, mut broken, mut piece) = (0.0, false, [[0.0; 3]; 2]);
        for (k, (dt_s, step)) in steps.iter().enumerate() {
            let (speeds, rate) = of(k, &samples[k].1);
            piece = [then(piece[0], driven(speeds, rate, *dt_s)), then(piece[1], *step)];
            lasts_s += dt_s;
            broken |= jumps[k];
            if lasts_s >= PIECE_S || k + 1 == steps.len() {
                pieces.extend((!broken).then_some(piece));
                (lasts_s, broken, piece) = (0.0, false, [[0.0; 3]; 2]);
            }
        }
        pieces
    };
    let pieces = told(&|_, sample| ([sample.control[0], sample.control[2]], sample.control[1]));
    let as_is = Differ::of(&pieces);
    let ahead_alone = Differ::of(&told(&|_, sample| ([sample.control[0], 0.0], sample.control[1])));
    if as_is.is_same() {
        return Verdict::Same;
    }
    if ahead_alone.is_same() {
        return Verdict::AheadAlone;
    }
    let way = |of: usize| pieces.iter().map(|piece| piece[of][0].hypot(piece[of][1])).sum::<f64>();
    let turn = |of: usize| pieces.iter().map(|piece| piece[of][2].abs()).sum::<f64>();
    let (ways, turns) = ([way(0), way(1)], [turn(0), turn(1)]);
    if ways[1] < NOTHING * ways[0] && turns[1] < NOTHING * turns[0] + MOVED {
        return Verdict::Twist(format!("the poses drive {:.2} m, the velocities {:.2} m", ways[1], ways[0]));
    }
    let across: f64 = pieces.iter().map(|[_, moved]| across(moved)).sum();
    let goes_across = across > ACROSS_SHARE * ways[1];
    if ways[0] < NOTHING * ways[1] && turns[0] < NOTHING * turns[1] + MOVED {
        let why = format!("has no velocities ({:.2e} m by them, {:.2} m by its poses)", ways[0], ways[1]);
        return Verdict::Poses(why, goes_across);
    }
    let sideways = samples.iter().any(|(_, sample)| sample.control[2].abs() > MOVED);
    if goes_across && !sideways {
        let share = 100.0 * across / ways[1];
        return Verdict::Twist(format!("{share:.0} % of the way of the poses goes across their headings"));
    }
    let turned = |k: usize, sample: &Sample| {
        let (s, c) = poses[k].1[2].sin_cos();
        let [x, rate, y] = sample.control;
        ([c * x + s * y, -s * x + c * y], rate)
    };
    let signed = |k: usize, sample: &Sample| {
        let back = steps[k].1[0] < 0.0;
        ([if back { -sample.control[0].abs() } else { sample.control[0].abs() }, sample.control[2]], sample.control[1])
    };
    let turning = |k: usize, sample: &Sample| {
        let (dt_s, step) = steps[k];
        ([sample.control[0], sample.control[2]], if dt_s > 0.0 { step[2] / dt_s } else { 0.0 })
    };
    let why = if turns[0] < NOTHING * turns[1] && Differ::of(&told(&turning)).is_same() {
        "they have no turn rate".to_owned()
    } else if Differ::of(&told(&signed)).is_same() {
        "they have lost the sign of the speed".to_owned()
    } else if Differ::of(&told(&turned)).is_same() {
        "they are in the axes of the odometry's frame, not of the vehicle's".to_owned()
    } else {
        let [differ, all] = as_is.pieces;
        format!(
            "{:.0} % of the way, {:.0} % of the turns, {differ} of {all} seconds; {:.2} m by them, {:.2} m by the poses",
            100.0 * as_is.way,
            100.0 * as_is.turns,
            ways[0],
            ways[1]
        )
    };
    Verdict::Poses(format!("has velocities that contradict its poses: {why}"), goes_across)
}

/// Sideways distance of a motion, relative to the heading after half of the turn.
fn across([ahead, left, turn]: &Moved) -> f64 {
    let (s, c) = (0.5 * turn).sin_cos();
    (c * left - s * ahead).abs()
}

/// For each step, whether it is a jump.
fn jumps(steps: &[(f64, Moved)]) -> Vec<bool> {
    let speed = |(dt_s, moved): &(f64, Moved)| if *dt_s > 0.0 { moved[0].hypot(moved[1]) / dt_s } else { 0.0 };
    let mut speeds: Vec<f64> = steps.iter().map(speed).filter(|speed| *speed > 0.0).collect();
    speeds.sort_by(f64::total_cmp);
    let most = speeds.get((MOST * speeds.len() as f64) as usize).copied().unwrap_or(0.0);
    let is_jump = |step: &(f64, Moved)| {
        (step.0 <= 0.0 && step.1[0].hypot(step.1[1]) > MOVED) || speed(step) > JUMP * most + JUMP_MPS
    };
    steps.iter().map(is_jump).collect()
}

/// Speeds and turn rates of the arcs between poses; at a jump those of the message.
fn of_poses(samples: &[(f64, Sample)], poses: &[(f64, [f64; 3])]) -> Vec<Row> {
    let steps: Vec<(f64, Moved)> =
        poses.windows(2).map(|pair| (pair[1].0 - pair[0].0, between(pair[0].1, pair[1].1))).collect();
    let rows = steps.iter().zip(jumps(&steps)).zip(samples).filter(|(((dt_s, _), _), _)| *dt_s > 0.0);
    rows.map(|((&(dt_s, [ahead, left, turn]), jump), (t_s, sample))| {
        if jump {
            return Row { t_s: *t_s, control: sample.control };
        }
        // The direction of the chord is the heading after half of the turn.
        let half = 0.5 * turn;
        let (s, c) = (libm::sin(half), libm::cos(half));
        let longer = if half.abs() < 1e-6 { 1.0 } else { half / s };
        let [speed, to_left] = [ahead * c + left * s, left * c - ahead * s].map(|chord| chord * longer / dt_s);
        Row { t_s: *t_s, control: [speed, turn / dt_s, to_left] }
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_connect_the_poses() {
        let of = |poses: &[(f64, [f64; 3])]| of_poses(&vec![(0.0, Sample::default()); poses.len()], poses);
        let driven = Vehicle::UnicycleArc.step([0.0, 0.0, 3.0], [2.0, 0.5, 0.0], 0.4);
        let poses = [(1.0, [0.0, 0.0, 3.0]), (1.4, driven), (1.4, driven), (2.0, driven)];
        let rows = of(&poses);
        let controls: Vec<[f64; 3]> = rows.iter().map(|row| row.control).collect();
        assert!((controls[0][0] - 2.0).abs() < 1e-12 && (controls[0][1] - 0.5).abs() < 1e-12, "{controls:?}");
        assert_eq!(controls[1..], [[0.0; 3]]);
    }

    /// Two minutes of a vehicle that drives curves, reverses now and then and stands; correct messages.
    fn drive() -> Vec<(f64, Sample)> {
        let mut pose = [1.0, 2.0, 0.5];
        let row = |k: u32| {
            let t_s = 0.05 * f64::from(k);
            let speed = if k % 600 < 120 {
                -0.5
            } else if k % 600 < 150 {
                0.0
            } else {
                1.0
            };
            let control = [speed, 0.4 * (0.2 * t_s).sin(), 0.0];
            let sample = Sample { control, pose: Some(pose) };
            pose = Vehicle::UnicycleArc.step(pose, control, 0.05);
            (t_s, sample)
        };
        (0..2400).map(row).collect()
    }

    type Change<'a> = &'a dyn Fn(usize, &mut Sample);

    fn changed(change: impl Fn(usize, &mut Sample)) -> (Vec<Row>, Vec<String>) {
        let mut samples = drive();
        samples.iter_mut().enumerate().for_each(|(k, (_, sample))| change(k, sample));
        let Rows { rows, told, aside } = rows("/odom", &samples, None);
        assert!(!aside);
        (rows, told)
    }

    #[test]
    fn velocities_that_contradict_the_poses_are_replaced_by_theirs() {
        let (right, told) = changed(|_, _| {});
        assert!(told.is_empty() && right.len() == 2400, "{told:?}");
        let noise = |k: usize| (k as f64 * 12.9898).sin();
        let cases: [(&str, Change); 9] = [
            ("no velocities", &|_, sample| sample.control = [0.0; 3]),
            ("no velocities", &|k, sample| sample.control = [1e-12 * noise(k), 1e-13 * noise(k + 1), 0.0]),
            ("lost the sign", &|_, sample| sample.control[0] = sample.control[0].abs()),
            ("axes of the odometry", &|_, sample| {
                let (s, c) = sample.pose.unwrap()[2].sin_cos();
                sample.control[2] = s * sample.control[0];
                sample.control[0] *= c;
            }),
            ("no turn rate", &|_, sample| sample.control[1] = 0.0),
            ("contradict", &|_, sample| sample.control[1] *= 57.3),
            ("contradict", &|_, sample| sample.control[0] *= 100.0),
            ("contradict", &|_, sample| sample.control[1] *= -1.0),
            // An intermittent error.
            ("contradict", &|k, sample| {
                if (1000..1100).contains(&k) {
                    sample.control = [0.0; 3];
                }
            }),
        ];
        for (words, change) in cases {
            let (found, told) = changed(change);
            assert!(
                told.len() == 1 && told[0].contains(words) && told[0].contains("made of its poses"),
                "{words}: {told:?}"
            );
            for (found, right) in found.iter().zip(&right) {
                let off = [0, 1].map(|k| (found.control[k] - right.control[k]).abs());
                assert!(found.t_s == right.t_s && off.iter().all(|off| *off < 1e-9), "{words}: {found:?} {right:?}");
            }
        }
    }

    #[test]
    fn poses_that_do_not_move_as_a_vehicle_are_not_used() {
        let noise = |k: usize| 0.2 * (k as f64 * 12.9898).sin();
        let kept: [(&str, Change); 6] = [
            // Noise, wheels worn by a tenth, a correction now and then: both agree.
            ("", &|k, sample| {
                sample.control[0] += noise(k);
                sample.control[1] += noise(k + 7);
            }),
            ("", &|_, sample| sample.control[0] *= 1.1),
            ("", &|k, sample| sample.pose.as_mut().unwrap()[0] += 5.0 * (k / 500) as f64),
            ("", &|_, sample| sample.pose = None),
            ("across their headings", &|_, sample| sample.pose.as_mut().unwrap()[2] = 0.0),
            ("are jumps", &|k, sample| sample.pose.as_mut().unwrap()[1] += if k % 20 == 0 { 40.0 } else { 0.0 }),
        ];
        for (words, change) in kept {
            let (found, told) = changed(change);
            let mut written = drive();
            written.iter_mut().enumerate().for_each(|(k, (_, sample))| change(k, sample));
            assert!(found.iter().zip(&written).all(|(row, (_, sample))| row.control == sample.control), "{words}");
            match words {
                "" => assert!(told.is_empty(), "{told:?}"),
                _ => assert!(told[0].contains(words) && told[0].contains("velocities are taken"), "{words}: {told:?}"),
            }
        }
        // A jump of poses that are used has no effect.
        let (found, _) = changed(|k, sample| {
            sample.control[0] = sample.control[0].abs();
            sample.pose.as_mut().unwrap()[0] += if k >= 1200 { 30.0 } else { 0.0 };
        });
        assert!(found.iter().all(|row| row.control[0].abs() < 1.001), "no speed of a jump");
    }

    #[test]
    fn a_vehicle_that_moves_sideways_is_holonomic() {
        let mut pose = [1.0, 2.0, 0.5];
        let samples: Vec<(f64, Sample)> = (0..600_u32)
            .map(|k| {
                let t_s = 0.05 * f64::from(k);
                let control = [0.6, 0.4 * (0.3 * t_s).sin(), 0.8 * (0.5 * t_s).cos()];
                let sample = Sample { control, pose: Some(pose) };
                pose = Vehicle::Holonomic.step(pose, control, 0.05);
                (t_s, sample)
            })
            .collect();
        let with = |change: &dyn Fn(&mut Sample), vehicle| {
            let mut samples = samples.clone();
            samples.iter_mut().for_each(|(_, sample)| change(sample));
            rows("/odom", &samples, vehicle)
        };
        let changes: [&dyn Fn(&mut Sample); 3] =
            [&|_| {}, &|sample| sample.pose = None, &|sample| sample.control = [0.0; 3]];
        for change in changes {
            let found = with(change, None);
            assert!(found.aside && found.told.iter().any(|told| told.contains("holonomic")), "{:?}", found.told);
            for (row, (_, sample)) in found.rows.iter().zip(&samples) {
                assert!((0..3).all(|k| (row.control[k] - sample.control[k]).abs() < 1e-9), "{row:?} {sample:?}");
            }
        }
        let of_a_car = with(&|_| {}, Some(Vehicle::UnicycleArc));
        assert!(!of_a_car.aside && of_a_car.told[0].contains("left out") && of_a_car.rows[0].control[2] == 0.0);
        // A sideways speed that the poses do not have.
        let (drift, told) = changed(|_, sample| sample.control[2] = 1.2 * sample.control[0].abs());
        assert!(drift.iter().all(|row| row.control[2] == 0.0), "{told:?}");
    }
}
