//! The session on the host: the view agrees with the filter, and the filter with the truth.

use scphd_web::{HEAD, PARTICLES, Refused, Session, Surroundings, Wish};

fn started(seed: u64, particles: usize) -> Box<Session> {
    let mut session = Box::new(Session::NEW);
    session.start(seed, particles).unwrap();
    session
}

fn off(head: &[f32], from: usize) -> f64 {
    f64::from(head[from] - head[9]).hypot(f64::from(head[from + 1] - head[10]))
}

/// RMSE of the filter and of odometry alone over this number of scans.
fn errors(seed: u64, particles: usize, around: Surroundings, scans: u32) -> [f64; 2] {
    let mut session = started(seed, particles);
    let mut squares = [0.0; 2];
    for _ in 0..scans {
        session.step(Wish::Automatic, around, true).unwrap();
        let head = session.view().numbers();
        squares = [squares[0] + off(head, 2).powi(2), squares[1] + off(head, 12).powi(2)];
    }
    squares.map(|square| (square / f64::from(scans)).sqrt())
}

#[test]
fn the_filter_is_more_accurate_than_odometry() {
    for (particles, worst_m) in [(0, 0.5), (PARTICLES, 1.0)] {
        for seed in 1..=4 {
            let [filter, odometry] = errors(seed, particles, Surroundings::USUAL, 800);
            println!("{particles} particles, seed {seed}: {filter:.3} m, odometry {odometry:.3} m");
            assert!(filter < worst_m && filter < 0.5 * odometry, "{particles}, seed {seed}: {filter}, {odometry}");
        }
        let [filter, odometry] = errors(1, particles, Surroundings { clutter: 25.0, detection: 0.7 }, 800);
        println!("{particles} particles, in clutter: {filter:.3} m, odometry {odometry:.3} m");
        assert!(filter < odometry, "{particles}, in clutter: {filter}, {odometry}");
    }
}

#[test]
fn the_length_of_the_view_agrees_with_its_header() {
    let widths = [4, 7, 9, 3, 2, 2];
    for particles in [0, 16] {
        let mut session = started(1, particles);
        assert!(session.view().numbers().is_empty());
        let mut greatest = 0;
        for scan in 0..600 {
            session.step(Wish::Automatic, Surroundings { clutter: 30.0, detection: 0.99 }, scan % 2 == 0).unwrap();
            let numbers = session.view().numbers();
            let lists: usize = (0..6).map(|list| numbers[16 + list] as usize * widths[list]).sum();
            assert_eq!(numbers.len(), HEAD + lists);
            assert_eq!((numbers[0], numbers[16]), ((scan + 1) as f32, particles as f32));
            assert!(numbers.iter().all(|number| number.is_finite()));
            let weights: f32 = (0..particles).map(|particle| numbers[HEAD + 4 * particle + 3]).sum();
            assert!(particles == 0 || (weights - 1.0).abs() < 1e-3, "{weights}");
            greatest = greatest.max(numbers[17] as usize);
        }
        assert!(greatest > 10, "{greatest} features");
    }
}

#[test]
fn equal_seeds_give_equal_drives() {
    let drive = |seed, particles| {
        let mut session = started(seed, particles);
        (0..50).for_each(|_| session.step(Wish::Automatic, Surroundings::USUAL, true).unwrap());
        session.digest()
    };
    assert_eq!((drive(1, 0), drive(1, 64)), (drive(1, 0), drive(1, 64)));
    assert_ne!(drive(1, 0), drive(2, 0));
    assert_ne!(drive(1, 64), drive(2, 64));
    assert_ne!(drive(1, 64), drive(1, 32));
}

#[test]
fn a_restarted_session_is_a_new_one() {
    let mut session = started(1, 64);
    (0..30).for_each(|_| session.step(Wish::Automatic, Surroundings::USUAL, true).unwrap());
    for particles in [8, 0, 64] {
        session.start(5, particles).unwrap();
        let mut fresh = started(5, particles);
        for _ in 0..30 {
            session.step(Wish::Automatic, Surroundings::USUAL, true).unwrap();
            fresh.step(Wish::Automatic, Surroundings::USUAL, true).unwrap();
        }
        assert_eq!((session.digest(), session.view()), (fresh.digest(), fresh.view()));
    }
}

#[test]
fn invalid_arguments_are_refused() {
    let mut session = Box::new(Session::NEW);
    assert_eq!(session.step(Wish::Automatic, Surroundings::USUAL, true), Err(Refused));
    assert_eq!(session.start(1, PARTICLES + 1), Err(Refused));
    session.start(1, 4).unwrap();
    let wild = Wish::Manual { speed_mps: f32::NAN, rate_radps: f32::INFINITY };
    let around = Surroundings { clutter: f32::INFINITY, detection: f32::NAN };
    (0..20).for_each(|_| session.step(wild, around, true).unwrap());
    assert!(session.view().numbers().iter().all(|number| number.is_finite()));
}
