//! Figure 5.9: the update of the same predicted particles with different likelihoods.
//!
//! The reference runs up to the scan, because its steps can be executed separately: the state before the update is the same for
//! all likelihoods.

use crate::plot::{Chart, Colour, Figure, Interval, Mark};
use scphd_filters::settings::{Likelihood, Settings};
use scphd_filters::slam::reference_of;
use scphd_log::events::{Event, events};
use scphd_log::log::Log;
use scphd_log::truth;
use scphd_reference::{Candidate, OwnDraws, Recursion};
use std::f64::consts::PI;

/// Bandwidth h of the kernel, m (figure 5.9).
pub const BANDWIDTH_M: f64 = 0.05;
/// Number of points of a curve.
const POINTS: usize = 600;
const HEIGHT_PX: f64 = 360.0;

/// The update that is shown, and the number of particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// The scan, from 0.
    pub scan: usize,
    /// Number of particles until then.
    pub particles: usize,
    /// Number of candidates of each in the last prediction.
    pub samples: usize,
}

/// The candidates of one update, and their weights after it.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighed {
    /// Positions, m.
    pub positions: Vec<[f64; 2]>,
    /// Weights before the update.
    pub predicted: Vec<f64>,
    /// Weights after the update by each likelihood.
    pub updated: Vec<(Likelihood, Vec<f64>)>,
    /// The true position, m.
    pub truth: Option<[f64; 2]>,
}

/// Runs the reference with the single-cluster likelihood up to a scan, and weighs the candidates with each likelihood.
pub fn weigh(log: &Log, settings: &Settings, moment: &Moment, seed: u64) -> Option<Weighed> {
    let with = |likelihood, samples| {
        let mut settings = settings.clone();
        settings.filter.likelihood = likelihood;
        settings.filter.particles = moment.particles;
        settings.filter.samples = samples;
        reference_of(&settings, &log.vehicle)
    };
    let reference = with(Likelihood::SingleCluster, 1);
    let many = with(Likelihood::SingleCluster, moment.samples);
    let mut draws = OwnDraws::new(seed);
    let mut state = reference.initial(log.initial_pose);
    let mut scans = 0;
    for event in events(log) {
        match event {
            Event::Predict { control, dt_s, .. } => {
                let model = if scans == moment.scan { &many } else { &reference };
                model.predict(&mut state, &control, dt_s, &mut draws);
            }
            Event::Fix { .. } => {}
            Event::Scan { index } if index < moment.scan => {
                reference.scan(&mut state, &log.scans[index].detections, &mut draws);
                scans = index + 1;
            }
            Event::Scan { index } => {
                let scan = &log.scans[index];
                let candidates = state.current();
                let exp = |weights: &[f64]| weights.iter().map(|weight| weight.exp()).collect::<Vec<_>>();
                let likelihoods = [Likelihood::SingleCluster, Likelihood::RbSingle, Likelihood::RbEmpty];
                return Some(Weighed {
                    positions: candidates
                        .iter()
                        .map(|candidate: &Candidate| [candidate.pose[0], candidate.pose[1]])
                        .collect(),
                    predicted: exp(&candidates.iter().map(|candidate| candidate.ln_weight).collect::<Vec<_>>()),
                    updated: likelihoods
                        .map(|likelihood| {
                            let weighing = with(likelihood, moment.samples).weigh(&state, &scan.detections);
                            (likelihood, exp(&weighing.ln_weights))
                        })
                        .to_vec(),
                    truth: truth::at(&log.truth, scan.t_s).map(|truth| truth.position),
                });
            }
        }
    }
    None
}

/// Density at `x` of weighted points smoothed by a Gaussian kernel, 1/m.
pub fn density(points: impl Iterator<Item = (f64, f64)>, x: f64) -> f64 {
    let peak = 1.0 / ((2.0 * PI).sqrt() * BANDWIDTH_M);
    points.map(|(at, weight)| weight * peak * (-0.5 * ((x - at) / BANDWIDTH_M).powi(2)).exp()).sum()
}

/// Densities along x and along y before and after the update.
pub fn figure(log: &Log, moment: &Moment, weighed: &Weighed) -> Figure {
    let charts = ["x (m)", "y (m)"].iter().enumerate().map(|(axis, name)| {
        let along = |weights: &[f64]| -> Vec<(f64, f64)> {
            weighed.positions.iter().map(|position| position[axis]).zip(weights.iter().copied()).collect()
        };
        let reach = Interval::around(weighed.positions.iter().map(|position| position[axis])).unwrap_or(Interval::UNIT);
        // The truth is shown unless it would compress the range of the particles.
        let near = |truth: &f64| reach.padded(0.3).contains(*truth);
        let reach = weighed
            .truth
            .map(|truth| truth[axis])
            .filter(near)
            .and_then(|truth| Interval::around([reach.low(), reach.high(), truth]))
            .unwrap_or(reach);
        let reach = reach.padded(0.05);
        let curve = |weights: &[f64]| -> Vec<[f64; 2]> {
            let points = along(weights);
            let step = reach.span() / POINTS as f64;
            let at = |k: usize| reach.low() + step * k as f64;
            (0..=POINTS).map(|k| [at(k), density(points.iter().copied(), at(k))]).collect()
        };
        let mut marks = vec![Mark::dashed("predicted", Colour::GREY, curve(&weighed.predicted))];
        for (place, (likelihood, weights)) in weighed.updated.iter().enumerate().rev() {
            let name = match likelihood {
                Likelihood::SingleCluster => "SC-PHD",
                Likelihood::RbSingle => "RB-PHD, single feature",
                Likelihood::RbMulti => "RB-PHD, several features",
                Likelihood::RbEmpty => "RB-PHD, empty map",
            };
            marks.push(Mark::line(name, Colour::of_curve(place), curve(weights)));
        }
        let highest = marks.iter().filter_map(|mark| mark.highest()).fold(0.0, f64::max);
        if let Some(truth) = weighed.truth {
            let upright = vec![[truth[axis], 0.0], [truth[axis], highest]];
            marks.push(Mark::dashed("true position", Colour::TRUTH, upright));
        }
        let y = Interval::new(0.0, 1.06 * highest);
        let chart = Chart {
            x_label: (*name).into(),
            y_label: "density (1/m)".into(),
            x: Some(reach),
            y,
            equal_scale: false,
            marks,
        };
        (chart, HEIGHT_PX)
    });
    let title =
        format!("{}: particles of scan {} before and after its update, h = {BANDWIDTH_M} m", log.name, moment.scan);
    Figure { title, charts: charts.collect() }
}
