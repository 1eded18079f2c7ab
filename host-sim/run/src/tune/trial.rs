//! A run over the whole log, and its prediction of the held-out part.

use super::foresight::{Look, Sighting, scores};
use super::learn::Learn;
use super::over::{Step, over};
use super::search::Foreseen;
use crate::session::{Filter, SessionError, with_roomy_stack};
use scphd_filters::kind::Kind;
use scphd_filters::slam::Slam;
use scphd_log::dimensions::{Planar, distance};
use scphd_log::truth;
use std::ops::Range;

/// Runs the whole log. Returns the prediction of the scans that are not in `learn`.
pub fn trial<K: Learn>(
    log: &K::Log,
    settings: &K::Settings,
    filter: (Filter, u64),
    learn: &Range<usize>,
) -> Result<Foreseen, SessionError> {
    let (filter, seed) = filter;
    let run = || {
        let mut slam = K::slam(filter, log, settings, seed).map_err(SessionError::Start)?;
        trial_of::<K>(&mut *slam, log, settings, learn)
    };
    with_roomy_stack(run).map_err(SessionError::Thread)?
}

/// Runs the whole log with a filter that has processed nothing of it.
pub fn trial_of<K: Learn>(
    slam: &mut dyn Slam<K>,
    log: &K::Log,
    settings: &K::Settings,
    learn: &Range<usize>,
) -> Result<Foreseen, SessionError> {
    let (looks, poses) = run::<K>(slam, log, settings)?;
    let scores = scores(&looks, K::view_measure(log));
    let scans = scores.into_iter().zip(&looks).map(|(score, look)| (score, look.predicted.len()));
    let held_out = |index: &usize| !learn.contains(index);
    let rest: Vec<_> = scans.enumerate().filter(|(index, _)| held_out(index)).map(|(_, scan)| scan).collect();
    let squares: Vec<f64> = (0..poses.len())
        .filter(held_out)
        .filter_map(|index| {
            let truth = truth::at(K::truth(log), K::scans(log)[index].t_s)?.position;
            Some(distance(&truth, &poses[index]).powi(2))
        })
        .collect();
    let rmse = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    Ok(Foreseen::of(&rest, (!squares.is_empty()).then_some(rmse)))
}

/// The measurements and the pose of every scan of a run.
type Looks<K> = (
    Vec<Look<<K as scphd_log::dimensions::Dimensions>::Position>>,
    Vec<<K as scphd_log::dimensions::Dimensions>::Pose>,
);

fn run<K: Learn>(slam: &mut dyn Slam<K>, log: &K::Log, settings: &K::Settings) -> Result<Looks<K>, SessionError> {
    // The noise is the same for all settings, so that none has an advantage.
    let scheme = K::scheme(log);
    let eye = &*K::eye(log, &scheme).map_err(SessionError::Start)?;
    let (mut looks, mut poses) = (Vec::new(), Vec::new());
    over::<K>(slam, log, settings, usize::MAX, false, |step| {
        let Step::Seen { scan, taken, before: (before, _), after, .. } = step else { return };
        let places = |pose| taken.detections.iter().filter_map(move |z| eye.place(scan, &pose, z));
        let predicted = places(before).map(|(place, covariance)| Sighting { place, covariance });
        looks.push(Look {
            t_s: taken.t_s,
            predicted: predicted.collect(),
            settled: places(after).map(|(place, _)| place).collect(),
        });
        poses.push(after);
    })?;
    Ok((looks, poses))
}

type OfLog<K> =
    fn(&mut dyn Slam<K>, &<K as Kind>::Log, &<K as Kind>::Settings, &Range<usize>) -> Result<Foreseen, SessionError>;

/// Compiled here, with optimisation: the crate of the command line, which would compile it otherwise, has none.
#[used]
static IN_THE_PLANE: OfLog<Planar> = trial_of::<Planar>;
