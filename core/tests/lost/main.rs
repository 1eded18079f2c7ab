//! Whether a filter finds out that its vehicle was carried away, and how often it says so of one that was not.
//!
//! The watch was made on the seeds 0 to 199, what is claimed is measured on those from 2000 on (`--ignored two_hundred`).

mod reports;
mod world;

use nalgebra::Vector2;
use scphd::models::{ControlNoise, PlanarPose, Pose, Sensing, Step, Unicycle, UnicycleControl};
use scphd::settings::Persistence;
use scphd::{Births, Config, Detector, DetectorMemory, Health, JointConfig, JointSlam, ScPhd, joint_memory, memory};
use std::ops::Range;
use world::{DT_S, Setting, Trouble, World};

const MEASUREMENTS: usize = 96;

joint_memory! { type JointMemory: Unicycle<f32> { measurement: Vector2<f32>, features: 90, measurements: MEASUREMENTS } }
memory! {
    type Mixture: Unicycle<f32> { particles: 4, samples: 1, features { pages: 256, pages_per_map: 64, in_view: 512 } }
}

/// The filters under test, in single precision.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Filter {
    /// Four informed particles.
    Mixture,
    /// A joint map that knows of no hiding.
    Joint,
    /// A joint map that knows that landmarks hide.
    Hiding,
}

const FILTERS: [Filter; 3] = [Filter::Mixture, Filter::Joint, Filter::Hiding];

/// Drives a filter through a world; tells of every scan its number, what the report says, and how far the estimate is off, m.
fn drive(filter: Filter, world: &mut World, scans: usize, mut told: impl FnMut(usize, &mut World, Health, f64)) {
    let setting = world.setting;
    let window = setting.stated_window();
    let sensing = Sensing::range_bearing([0.1, 0.015], window, setting.clutter as f32).unwrap();
    let births = Births::of_static(sensing.clutter.intensity());
    let motion = Unicycle::new(Step::Arc, ControlNoise::white(0.15, 0.05)).unwrap();
    let dt = DT_S as f32;
    let control = |[speed, rate]: [f64; 2]| UnicycleControl { speed_mps: speed as f32, rate_radps: rate as f32 };
    if filter == Filter::Mixture {
        let (mut state, mut scratch) = (Box::new(Mixture::new()), DetectorMemory::<Vector2<f32>, MEASUREMENTS>::new());
        let mut eyes = Detector::new(sensing, births).unwrap().over(&mut scratch).unwrap();
        let mut slam = ScPhd::new(motion, Config::informed(4), &mut *state).unwrap();
        slam.reset(PlanarPose::ZERO, 1).unwrap();
        for scan in 0..scans {
            slam.predict(&control(world.go()), dt).unwrap();
            let health = slam.scan(&mut eyes, &world.look()).unwrap().health;
            let mean = slam.estimate_pose().unwrap().mean;
            let off_m = world.distance(mean.x_m, mean.y_m);
            told(scan, world, health, off_m);
        }
    } else {
        let mut state = Box::new(JointMemory::new());
        let eyes = Detector::new(sensing, births).unwrap();
        let persistence = Persistence { visible_s: 20.0, occluded_s: 2.0, lifetime_s: 300.0 };
        let persistence = if filter == Filter::Hiding { persistence } else { Persistence::FOR_EVER };
        let mut slam =
            JointSlam::new(motion, JointConfig { persistence, ..JointConfig::default() }, &mut *state).unwrap();
        slam.reset(PlanarPose::ZERO).unwrap();
        for scan in 0..scans {
            slam.predict(&control(world.go()), dt).unwrap();
            let health = slam.scan(&eyes, &world.look()).unwrap().health;
            let mean = slam.estimate_pose().unwrap().mean;
            let off_m = world.distance(mean.x_m, mean.y_m);
            told(scan, world, health, off_m);
        }
    }
}

/// After how many scans a vehicle that was carried away is found lost, if at all; and whether it was before.
fn carried(filter: Filter, setting: Setting, seed: u64) -> (Option<usize>, bool) {
    let mut world = World::new(setting, Trouble::NONE, seed);
    let when = 200 + world.pick(100);
    let (mut found, mut before) = (None, false);
    drive(filter, &mut world, when + 40, |scan, world, health, _| {
        let lost = health.contains(Health::LOST);
        if scan <= when {
            before |= lost;
        } else if lost && found.is_none() {
            found = Some(scan - when);
        }
        if scan == when {
            world.carry_away();
        }
    });
    (found, before)
}

/// Alarms raised over a drive in which nobody is carried away: suspected; lost, and off by less than a metre; lost, and off by more;
/// scans.
fn undisturbed(filter: Filter, setting: Setting, trouble: Trouble, scans: usize, seed: u64) -> [usize; 4] {
    let mut world = World::new(setting, trouble, seed);
    let (mut alarms, mut before) = ([0; 3], Health::GOOD);
    drive(filter, &mut world, scans, |_, _, health, off_m| {
        let begins = |condition: Health| health.contains(condition) && !before.contains(condition);
        let (lost, truly) = (begins(Health::LOST), off_m >= 1.0);
        let now = [begins(Health::DIVERGENCE_SUSPECTED), lost && !truly, lost && truly];
        (0..3).for_each(|k| alarms[k] += usize::from(now[k]));
        before = health;
    });
    [alarms[0], alarms[1], alarms[2], scans]
}

/// Of so many trials, how many vehicles were found lost within 20 scans: printed by setting, and in all.
fn carried_away(filter: Filter, seeds: Range<u64>) -> [usize; 2] {
    let mut all = [0; 2];
    for (number, setting) in Setting::ALL.into_iter().enumerate() {
        let mut waits: Vec<usize> = Vec::new();
        let mut before = 0;
        for seed in seeds.clone().filter(|&seed| seed as usize % Setting::ALL.len() == number) {
            let (found, alarmed) = carried(filter, setting, seed);
            waits.push(found.unwrap_or(usize::MAX));
            before += usize::from(alarmed);
        }
        waits.sort_unstable();
        let within = |scans: usize| waits.iter().filter(|&&wait| wait <= scans).count();
        let (trials, median) = (waits.len(), waits[waits.len() / 2]);
        println!(
            "{filter:?}, setting {number}: {} of {trials} within 20 scans, {} within 10, median {median}; {before} before",
            within(20),
            within(10),
        );
        all = [all[0] + within(20), all[1] + trials];
    }
    all
}

/// The same over all troubles: printed by trouble, and in all; but not where trouble is double.
fn left_alone(filter: Filter, seeds: Range<u64>, scans: usize) -> [usize; 4] {
    let mut all = [0; 4];
    for trouble in Trouble::ALL {
        let mut sum = [0; 4];
        for seed in seeds.clone() {
            let setting = Setting::ALL[seed as usize % Setting::ALL.len()];
            let one = undisturbed(filter, setting, trouble, scans, seed);
            (0..4).for_each(|k| sum[k] += one[k]);
        }
        let [suspected, lost, truly, scans] = sum;
        let name = trouble.name;
        println!("{filter:?}, {name}: suspected {suspected}, lost {lost} times in {scans} scans, and truly {truly}");
        if !trouble.is_double() {
            (0..4).for_each(|k| all[k] += sum[k]);
        }
    }
    all
}

#[test]
fn of_ten_vehicles_that_are_carried_away_nine_are_found_lost_within_twenty_scans() {
    for filter in FILTERS {
        let [found, trials] = carried_away(filter, 1000..1010);
        assert!(trials == 10 && found >= 9, "{filter:?}: {found} of {trials}");
    }
}

#[test]
fn in_troubled_worlds_nobody_cries_wolf() {
    for filter in FILTERS {
        let [_, lost, _, scans] = left_alone(filter, 1000..1001, 300);
        assert!(lost == 0, "{filter:?}: {lost} in {scans} scans");
    }
}

/// And some 100 000 scans undisturbed, for every filter.
#[test]
#[ignore = "a few minutes; the seeds of judgement"]
fn two_hundred_are_carried_away_and_the_others_left_alone() {
    let (mut alarms, mut all) = ([0; 4], Vec::new());
    for filter in FILTERS {
        let [found, trials] = carried_away(filter, 2000..2200);
        println!("{filter:?}: {found} of {trials}");
        all.push((filter, found, trials));
        let of_filter = left_alone(filter, 2000..2020, 600);
        (0..4).for_each(|k| alarms[k] += of_filter[k]);
    }
    let [suspected, lost, truly, scans] = alarms;
    println!("suspected {suspected}, lost {lost} times in {scans} scans, and truly {truly}");
    assert!(all.iter().all(|(_, found, trials)| 100 * found >= 95 * trials), "{all:?}");
    assert!(lost * 10_000 <= scans, "{alarms:?}");
}
