//! States that an earlier filter has used: a filter continues from them if they fit, and refuses them otherwise.

use crate::tests::alone::{Alone, Lidar, Models};
use crate::*;
use nalgebra::Vector2;
use std::boxed::Box;
use std::string::ToString;

type Memory = State<PlanarPose<f64>, 8, 16, MapMemory<Static<Vector2<f64>>, 8, 64, 8, 64>>;
type Filter<'s> = Alone<'s, Unicycle<f64>, Lidar<f64>>;
const BIRTHS: Births<f64> = Births::of_static(0.01);
type CarModels = Models<Unicycle<f64>, Lidar<f64>>;

const AHEAD: UnicycleControl<f64> = UnicycleControl { speed_mps: 1.0, rate_radps: 0.1 };

fn models() -> CarModels {
    let window = RangeBearingWindow::full_circle(20.0, 0.9).unwrap();
    Models {
        motion: Unicycle::new(Step::Arc, ControlNoise::white(0.3, 0.05)).unwrap(),
        sensing: Sensing::range_bearing([0.2, 0.02], window, 2.0).unwrap(),
    }
}

fn config(particles: usize, samples: usize) -> Config<f64> {
    Config { particles, samples, ..Config::default() }
}

fn informed(particles: usize, samples: usize, drawn: f64) -> Config<f64> {
    let proposal = Proposal::Informed(Informed { sampled_fraction: drawn, ..Informed::default() });
    Config { proposal, ..config(particles, samples) }
}

fn scan() -> [Vector2<f64>; 2] {
    [Vector2::new(5.0, 1.0), Vector2::new(9.0, -2.0)]
}

/// The state of a filter with this configuration after one scan and, if `moves_on`, another prediction.
fn worked(config: Config<f64>, moves_on: bool) -> Box<Memory> {
    let mut state = Box::new(Memory::new());
    let mut filter = Filter::new(models(), BIRTHS, config, &mut *state).unwrap();
    filter.reset(PlanarPose::ZERO, 1).unwrap();
    filter.predict(&AHEAD, 0.1).unwrap();
    filter.scan(&scan()).unwrap();
    if moves_on {
        filter.predict(&AHEAD, 0.1).unwrap();
    }
    state
}

fn refused(state: &mut Memory, config: Config<f64>) -> Option<SetupError> {
    Filter::new(models(), BIRTHS, config, state).err()
}

#[test]
fn another_number_of_particles_is_refused_until_the_state_is_cleared() {
    let mut state = worked(config(8, 2), true);
    let error = refused(&mut state, config(2, 8)).unwrap();
    assert_eq!(error, SetupError::HeldParticles { held: 8, configured: 2 });
    assert_eq!(error.to_string(), "the state has 8 particles, but 2 are configured; clear it first");
    state.clear();
    let mut filter = Filter::new(models(), BIRTHS, config(2, 8), &mut *state).unwrap();
    assert_eq!(filter.scan(&scan()), Err(ScanError::NotStarted));
    filter.reset(PlanarPose::ZERO, 1).unwrap();
    let report = filter.predict(&AHEAD, 0.5).unwrap();
    assert_eq!((report.candidates, report.rejected), (16, 0));
    assert!(filter.estimate_pose().unwrap().mean.x_m > 0.2, "the vehicle moves");
    // Fewer particles than configured are refused too, unless the configured number is adapted.
    let mut state = worked(config(2, 2), false);
    assert_eq!(refused(&mut state, config(8, 2)), Some(SetupError::HeldParticles { held: 2, configured: 8 }));
    assert_eq!(refused(&mut state, config(2, 8)), None);
}

#[test]
fn samples_between_prediction_and_scan_keep_their_number() {
    let mut state = worked(config(8, 2), true);
    assert_eq!(refused(&mut state, config(8, 1)), Some(SetupError::HeldSamples { held: 2, configured: 1 }));
    assert_eq!(refused(&mut state, informed(8, 2, 1.0)), Some(SetupError::HeldSamples { held: 2, configured: 1 }));
    assert_eq!(refused(&mut state, config(8, 2)), None);
    // After the scan any number of samples is accepted, and either proposal.
    let mut state = worked(config(8, 2), false);
    assert_eq!(refused(&mut state, config(8, 1)), None);
    assert_eq!(refused(&mut state, informed(8, 2, 0.5)), None);
}

#[test]
fn poses_with_covariances_need_the_informed_proposal() {
    let mut state = worked(informed(8, 1, 0.5), false);
    assert_eq!(refused(&mut state, config(8, 1)), Some(SetupError::HeldCovariance));
    assert_eq!(refused(&mut state, informed(8, 2, 1.0)), None);
    let mut state = worked(informed(8, 1, 1.0), false);
    assert_eq!(refused(&mut state, config(8, 1)), None);
    let mut state = worked(informed(8, 1, 1.0), true);
    assert_eq!(refused(&mut state, config(8, 1)), Some(SetupError::HeldCovariance));
}

#[test]
fn a_state_that_fits_continues_with_the_same_bits() {
    for (config, moves_on) in [(config(8, 2), true), (config(8, 2), false), (informed(8, 2, 0.5), true)] {
        let digest = |interrupted: bool| {
            let mut state = worked(config, moves_on);
            let mut filter = Filter::new(models(), BIRTHS, config, &mut *state).unwrap();
            if interrupted {
                filter = Filter::new(models(), BIRTHS, config, &mut *state).unwrap();
            }
            for _ in 0..5 {
                filter.scan(&scan()).unwrap();
                filter.predict(&AHEAD, 0.1).unwrap();
            }
            filter.digest()
        };
        assert_eq!(digest(true), digest(false));
    }
}

/// A program that stores the state and borrows a filter for every step gets the same bits, and the same errors for a state that
/// does not fit.
#[test]
fn a_filter_borrowed_for_every_step_is_the_same() {
    let Models { motion, sensing } = models();
    for config in [config(8, 2), informed(8, 2, 0.5)] {
        let mut kept = worked(config, true);
        let mut filter = Filter::new(models(), BIRTHS, config, &mut *kept).unwrap();
        let mut state = worked(config, true);
        let mut scratch = DetectorMemory::<Vector2<f64>, 8>::new();
        let mut detector = Detector::new(sensing, BIRTHS).unwrap().over(&mut scratch).unwrap();
        for _ in 0..5 {
            filter.scan(&scan()).unwrap();
            filter.predict(&AHEAD, 0.1).unwrap();
            ScPhd::reborrow(motion, config, &mut *state).unwrap().scan(&mut detector, &scan()).unwrap();
            ScPhd::reborrow(motion, config, &mut *state).unwrap().predict(&AHEAD, 0.1).unwrap();
            let borrowed = ScPhd::reborrow(motion, config, &mut *state).unwrap().digest();
            assert_eq!(borrowed, filter.digest());
        }
    }
    let mut state = worked(config(8, 2), true);
    let refusal = ScPhd::reborrow(motion, config(2, 8), &mut *state).err();
    assert_eq!(refusal, Some(SetupError::HeldParticles { held: 8, configured: 2 }));
    let refusal = ScPhd::reborrow(motion, config(8, 1), &mut *state).err();
    assert_eq!(refusal, Some(SetupError::HeldSamples { held: 2, configured: 1 }));
    let mut uncertain = worked(informed(8, 1, 1.0), true);
    let refusal = ScPhd::reborrow(motion, config(8, 1), &mut *uncertain).err();
    assert_eq!(refusal, Some(SetupError::HeldCovariance));
    let refusal = ScPhd::reborrow(motion, config(9, 1), &mut *state).err();
    assert_eq!(refusal, Some(SetupError::TooManyParticles { particles: 9, capacity: 8 }));
}

/// All kinds of memory damage are detected.
#[test]
fn a_damaged_state_is_refused() {
    type Damage = fn(&mut Filter<'_>);
    let damages: [(&str, Damage); 13] = [
        ("a weight", |filter| filter.memory.candidates[3].ln_weight = f64::NAN),
        ("weights that do not sum to one", |filter| filter.memory.candidates[3].ln_weight = 0.0),
        ("a pose", |filter| filter.memory.candidates[15].pose.x_m = f64::INFINITY),
        ("a spread", |filter| filter.memory.pose_covariances[0] = Symmetric::from_diagonal([f64::NAN; 3])),
        ("the heaviest", |filter| filter.memory.cursor.heaviest = 8),
        ("the number of particles", |filter| filter.memory.cursor.particles = 7),
        ("the number of samples", |filter| filter.memory.cursor.children = usize::MAX),
        ("the time waited", |filter| filter.memory.cursor.waited_s = -1.0),
        ("the random stream", |filter| filter.memory.cursor.noise = None),
        ("a page given back that is held", |filter| {
            let id = filter.memory.static_maps.table.pages(0)[0];
            (0..8).for_each(|_| filter.memory.static_maps.pool.release(id));
        }),
        ("a page held once too often", |filter| {
            let id = filter.memory.static_maps.table.pages(0)[0];
            filter.memory.static_maps.pool.share(id);
        }),
        ("a page that leaked", |filter| assert!(filter.memory.static_maps.pool.take().is_some())),
        ("a component", |filter| {
            let id = filter.memory.static_maps.table.pages(0)[0];
            let page = filter.memory.static_maps.pool.held_mut().nth(id.index()).unwrap();
            let first = page.components()[0];
            page.fill([Component { ln_weight: f64::NAN, ..first }].iter());
        }),
    ];
    for (name, damage) in damages {
        let mut state = worked(config(8, 2), true);
        let mut filter = Filter::new(models(), BIRTHS, config(8, 2), &mut *state).unwrap();
        damage(&mut filter);
        assert!(refused(&mut state, config(8, 2)).is_some(), "{name}");
        // The error is repeated, and the state can be cleared and used again.
        assert!(refused(&mut state, config(8, 2)).is_some(), "{name}");
        state.clear();
        let mut filter = Filter::new(models(), BIRTHS, config(8, 2), &mut *state).unwrap();
        filter.reset(PlanarPose::ZERO, 1).unwrap();
        filter.predict(&AHEAD, 0.1).unwrap();
        assert!(filter.scan(&scan()).unwrap().maps_updated > 0, "{name}");
    }
}

#[test]
fn models_are_changed_as_a_whole_and_checked() {
    let mut state = worked(config(8, 2), false);
    let mut filter = Filter::new(models(), BIRTHS, config(8, 2), &mut *state).unwrap();
    let sharper = Sensing { sensor: RangeBearing::new(0.1, 0.01).unwrap(), ..*filter.detector.sensing() };
    filter.detector.retune(sharper).unwrap();
    assert_eq!(filter.detector.sensing(), &sharper);
    let slower = Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.05)).unwrap();
    filter.retune(slower).unwrap();
    assert_eq!(filter.motion(), &slower);
    assert!(filter.scan(&scan()).is_ok());
}
