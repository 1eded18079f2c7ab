//! Injected faults of sensors, wheels and clocks: the warnings of the filters and of the sequencer, and whether the estimate
//! recovers. A vehicle drives around a circle among landmarks; after a minute there is a fault for ten seconds.
//!
//! `cargo test -p scphd-sequencer --release --test injection -- --ignored --nocapture` prints the table for seeds from 760 on.
//! Health and the reactions were developed on seeds below 10.

mod fault;
mod filters;
mod relocaliser;
mod vehicle;
#[path = "../../../../core/tests/lost/world.rs"]
#[allow(dead_code)]
mod world;

use fault::Fault;
use filters::{Control, Slam};
use scphd::Health;
use scphd::models::PlanarPose;
use scphd::numerics::Noise;
use scphd::numerics::nalgebra::Vector2;
use scphd_sequencer::{Action, Flags, Sequencer, Settings, Stamp};
use std::ops::Range;
use vehicle::{Vehicle, by};
use world::{DT_S, Setting, Trouble, World};

pub const MEASUREMENTS: usize = 96;

const DT_NS: u64 = (DT_S * 1e9) as u64;
/// Number of scans before, during and after the fault.
const BEFORE: usize = 300;
const FAULT: usize = 50;
const AFTER: usize = 100;
/// Number of scans after which the area is mapped.
const SETTLED: usize = 200;

const WHEELS: u8 = 0;
const LIDAR: u8 = 1;
/// Settings for ten inputs per second.
const SETTINGS: Settings = Settings {
    window_ns: 20_000_000,
    jump_ns: 20_000_000_000,
    jumps_believed: 6,
    frozen_inputs: 10,
    ..Settings::DEFAULT
};

/// Duration without controls after which the position is unknown, s.
const LONG_S: f32 = 2.0;

type Inputs = Sequencer<Control, Vec<Vector2<f32>>, 64, 32>;

type New = fn(Setting, bool) -> Box<dyn Slam>;
const FILTERS: [(&str, New); 2] = [("joint", filters::joint), ("mixture", filters::mixture)];

/// The outputs at one scan.
#[derive(Debug, Clone, Copy)]
struct Said {
    health: Health,
    /// Whether an odometry bias is suspected.
    biased: bool,
    clock: u16,
    off_m: f64,
}

/// Drives once. Returns the outputs at every scan.
fn drive(new: New, fault: Fault, seed: u64) -> Vec<Said> {
    let setting = Setting::ALL[0];
    let mut world = World::new(setting, Trouble::NONE, seed);
    let mut vehicle = Vehicle::new(new(setting, fault == Fault::ShortMemory), relocaliser::Relocaliser::new(setting));
    let (mut draws, mut inputs) = (Noise::seeded(seed ^ 0xfa17), Inputs::new());
    let zero = Control { speed_mps: 0.0, rate_radps: 0.0 };
    inputs.start(SETTINGS, 0, zero).unwrap();
    let (mut last, mut clock_ns, mut jumped_ns) = (Vec::new(), 0_u64, 0_u64);
    let mut said = Vec::new();
    for scan in 0..BEFORE + FAULT + AFTER {
        let on = (BEFORE..BEFORE + FAULT).contains(&scan);
        let now = if on { fault } else { Fault::None };
        if fault == Fault::ClockJump && scan == BEFORE {
            jumped_ns = 60_000_000_000;
        }
        let told = now.odometry(world.go());
        if fault == Fault::Blind && scan == BEFORE {
            world.set_trouble(Trouble { detection: 0.1 / setting.detection, ..Trouble::NONE });
        } else if scan == BEFORE + FAULT {
            world.set_trouble(Trouble::NONE);
        }
        let fresh = world.look();
        let seen = now.scan(fresh, &last, &mut draws, [setting.clutter, setting.range_m]);
        let repeats = seen == last;
        last.clone_from(&seen);
        // A control holds from its time on; earlier ones are output.
        let begin_ns = clock_ns + jumped_ns + 1_000_000;
        clock_ns += DT_NS;
        // A frozen clock has the time at which it stopped.
        let frozen = now == Fault::FrozenClock;
        let stopped_ns = BEFORE as u64 * DT_NS;
        let (of_control, of_scan) = if frozen { (stopped_ns, stopped_ns) } else { (begin_ns, clock_ns + jumped_ns) };
        let number = scan as u32;
        let control = Control { speed_mps: told[0] as f32, rate_radps: told[1] as f32 };
        let _ = inputs.push_control(Stamp::new(WHEELS, of_control).numbered(number), control);
        // A scan that equals the previous one to the bit is not passed to the filter.
        if now != Fault::NoScans && !repeats {
            let _ = inputs.push_event(Stamp::new(LIDAR, of_scan).numbered(number), seen);
        }
        inputs.tick(of_scan + SETTINGS.window_ns + 500_000);
        let mut health = Health::GOOD;
        while let Some(action) = inputs.next_action() {
            match action {
                Action::Predict { control, dt } => health |= vehicle.predict(&control, dt.seconds()),
                // The motion may have continued, stopped, or been anything between.
                Action::Gap { control, dt } => {
                    let dt: f32 = dt.seconds();
                    health |= vehicle.predict(&control, dt);
                    vehicle.slam.scatter(&by(0.1 * dt, 0.03 * dt));
                    if dt > LONG_S {
                        vehicle.search();
                    }
                }
                Action::Event(scan) => health |= vehicle.scan(scan),
            }
        }
        let clock = inputs.take_report().flags.bits();
        if clock & Flags::CLOCK_SET.bits() != 0 {
            vehicle.search();
        }
        let PlanarPose { x_m, y_m, .. } = vehicle.slam.pose();
        said.push(Said { health, biased: vehicle.biased, clock, off_m: world.distance(x_m, y_m) });
    }
    said
}

/// Results of one drive.
#[derive(Debug, Clone, Copy)]
struct Course {
    /// Number of scans until an unusual warning.
    flagged: Option<usize>,
    /// Number of scans after the fault until the error was normal and remained so.
    recovered: Option<usize>,
    /// RMS error before the fault, greatest error during it, RMS error of the last ten seconds.
    errors: [f64; 3],
    /// The unusual warnings.
    health: Health,
    biased: bool,
    clock: u16,
}

fn rms(said: &[Said]) -> f64 {
    (said.iter().map(|said| said.off_m * said.off_m).sum::<f64>() / said.len() as f64).sqrt()
}

fn course(said: &[Said], normal_m: f64, fault: Fault) -> Course {
    let settled = &said[SETTLED..BEFORE];
    let from = if fault == Fault::ShortMemory { 0 } else { BEFORE };
    let (mut usual, mut biased) = (Health::GOOD, false);
    if fault != Fault::ShortMemory {
        settled.iter().for_each(|said| (usual, biased) = (usual | said.health, biased | said.biased));
    }
    let unusual = |said: &Said| said.health.bits() & !usual.bits() != 0 || said.biased && !biased || said.clock != 0;
    let with = &said[from..BEFORE + FAULT];
    let after = &said[BEFORE + FAULT..];
    let bad = after.iter().rposition(|said| said.off_m > 3.0 * normal_m);
    let (mut health, mut clock) = (Health::GOOD, 0);
    with.iter().for_each(|said| (health, clock) = (health | said.health, clock | said.clock));
    Course {
        flagged: with.iter().position(unusual).map(|scan| scan + 1),
        recovered: bad.map_or(Some(0), |bad| (bad + 1 < after.len()).then_some(bad + 1)),
        errors: [rms(settled), with.iter().fold(0.0, |most, said| most.max(said.off_m)), rms(&after[FAULT..])],
        health,
        biased: with.iter().any(|said| said.biased),
        clock,
    }
}

/// Runs a fault over seeds, prints its line, and returns the results.
fn table(name: &str, new: New, fault: Fault, seeds: Range<u64>) -> Vec<Course> {
    let normal_m = {
        let undisturbed: Vec<f64> = seeds.clone().map(|seed| rms(&drive(new, Fault::None, seed)[SETTLED..])).collect();
        (undisturbed.iter().map(|off| off * off).sum::<f64>() / undisturbed.len() as f64).sqrt()
    };
    let courses: Vec<Course> = seeds.map(|seed| course(&drive(new, fault, seed), normal_m, fault)).collect();
    let count = |of: &dyn Fn(&Course) -> bool| courses.iter().filter(|course| of(course)).count();
    let mut waits: Vec<usize> = courses.iter().filter_map(|course| course.flagged).collect();
    waits.sort_unstable();
    let seconds = |scans: usize| scans as f64 * DT_S;
    let flagged = count(&|course| course.flagged.is_some_and(|scans| seconds(scans) <= 2.0));
    let recovered = count(&|course| course.recovered.is_some_and(|scans| seconds(scans) <= 10.0));
    let mean = |k: usize| courses.iter().map(|course| course.errors[k]).sum::<f64>() / courses.len() as f64;
    let median = waits.get(courses.len() / 2).map_or("never".into(), |&scans| format!("{:.1} s", seconds(scans)));
    let biased = count(&|course| course.biased);
    let (mut health, mut clock) = (Health::GOOD, 0);
    courses.iter().for_each(|course| (health, clock) = (health | course.health, clock | course.clock));
    println!(
        "{name:8} {fault:?}: flagged within 2 s {flagged} of {}, median {median}; recovered within 10 s {recovered}; \
         error before {:.2}, with at most {:.2}, after {:.2} m; {health:?} biased {biased} clock {clock:#x}",
        courses.len(),
        mean(0),
        mean(1),
        mean(2),
    );
    courses
}

#[test]
fn faults_are_told_and_the_estimate_comes_back() {
    let told = |course: &Course| course.flagged.is_some_and(|scans| scans <= 10);
    let back = |course: &Course| course.recovered.is_some_and(|scans| scans <= FAULT);
    // After a bias of a sensor some vehicles remain lost: docs/health.md has their number.
    let faults = [
        (Fault::StuckScan, true),
        (Fault::RangeBias, false),
        (Fault::Clutter, true),
        (Fault::Blind, true),
        (Fault::NoScans, true),
        (Fault::FrozenClock, true),
        (Fault::ClockJump, true),
        (Fault::RateBias, true),
    ];
    for (fault, comes_back) in faults {
        let courses = table("joint", filters::joint, fault, 20..22);
        assert!(courses.iter().all(told), "{fault:?}: {courses:?}");
        assert!(fault != Fault::RateBias || courses.iter().all(|course| course.biased), "{fault:?}: {courses:?}");
        assert!(!comes_back || courses.iter().all(back), "{fault:?}: {courses:?}");
    }
    for fault in [Fault::NoScans, Fault::Slip, Fault::StuckOdometry] {
        let courses = table("mixture", filters::mixture, fault, 20..22);
        let wrong = fault != Fault::NoScans;
        let as_it_is = |course: &Course| told(course) && back(course) && course.biased == wrong;
        assert!(courses.iter().all(as_it_is), "{fault:?}: {courses:?}");
    }
}

/// Prints the table. Eight of ten faults are reported within two seconds if they have an effect: too small a pool has none until
/// it is full.
#[test]
#[ignore = "minutes; the seeds of judgement"]
fn the_table_on_the_seeds_of_judgement() {
    let mut untold = Vec::new();
    for fault in Fault::ALL {
        for (name, new) in FILTERS {
            let courses = table(name, new, fault, 760..780);
            let told = |course: &&Course| course.flagged.is_some_and(|scans| scans <= 10);
            let full_later = fault == Fault::ShortMemory && name == "mixture";
            if fault != Fault::None && !full_later && 10 * courses.iter().filter(told).count() < 8 * courses.len() {
                untold.push((name, fault));
            }
        }
    }
    assert!(untold.is_empty(), "{untold:?}");
}
