//! The joint filter and its reference in lockstep: every step of the reference starts from the filter's state. A second reference
//! runs independently from the start.

use super::differences::{Comparison, NO_FIXES, figures, larger, norm, relative};
use nalgebra::DMatrix;
use scphd_filters::kind::Kind;
use scphd_filters::slam::{OpenJoint, Refusal};
use scphd_log::angle::wrap;
use scphd_log::events::Event;
use scphd_reference::joint::{Joint, Models, State};

figures! {
    /// Largest differences between the joint filter and its reference, relative unless the name has a unit.
    /// `docs/results.md` defines the keys.
    JointDifferences {
        scans: usize = "scans",
        predicted_position_m: f64 = "predicted position (m)",
        predicted_heading_rad: f64 = "predicted heading (rad)",
        predicted_covariance: f64 = "predicted covariance (relative)",
        waited_s: f64 = "time since the scan (s)",
        ln_evidence: f64 = "ln evidence (relative)",
        innovation: f64 = "mean squared innovation (relative)",
        estimated_position_m: f64 = "estimated position (m)",
        estimated_heading_rad: f64 = "estimated heading (rad)",
        mean: f64 = "feature mean (relative)",
        pose_covariance: f64 = "pose covariance (relative)",
        feature_covariance: f64 = "feature covariance (relative)",
        cross_covariance: f64 = "cross-covariance (relative)",
        existence: f64 = "probability of a feature",
        detections: f64 = "detections of a feature",
        mover_weight: f64 = "probability of a mover",
        mover_mean: f64 = "mean of a mover (relative)",
        mover_covariance: f64 = "covariance of a mover (relative)",
        features: usize = "features compared",
        movers: usize = "movers compared",
        unmatched: usize = "features unmatched",
        other_views: usize = "scans with other views",
        capacity_events: usize = "scans short of room",
        own_way_position_m: f64 = "position, each on its own way (m)",
        own_way_heading_rad: f64 = "heading, each on its own way (rad)",
    }
}

/// A comparison of the joint filter and its reference over a whole log.
pub type JointComparison = Comparison<JointDifferences>;

/// Processes a log with a joint filter and repeats each step with the reference, of which there is one for every sensor.
pub(super) fn drive<K: Kind, M: Models>(
    log: &K::Log,
    settings: &K::Settings,
    references: &[Joint<M>],
    control_of: fn(&K::Control) -> M::Control,
    filter: &mut dyn OpenJoint<K>,
    progress: &mut dyn FnMut(usize),
) -> Result<JointComparison, Refusal> {
    let all = K::scans(log);
    let mut comparison = Comparison { scans: Vec::with_capacity(all.len()), overall: JointDifferences::default() };
    let mut predictions = JointDifferences::default();
    let mut alone = filter.snapshot()?;
    for event in K::events(log, settings)? {
        match event {
            Event::Predict { control, dt_s, .. } => {
                let mut state = filter.snapshot()?;
                if filter.predict(control, dt_s)?.is_some() {
                    // The time of a rejected step counts nevertheless.
                    alone.waited_s += dt_s;
                    continue;
                }
                let control = control_of(&control);
                references[0].predict(&mut state, &control, dt_s);
                references[0].predict(&mut alone, &control, dt_s);
                predictions.merge(&predicted(&filter.snapshot()?, &state, M::FEATURE));
            }
            Event::Fix { .. } => return Err(Refusal(NO_FIXES.into())),
            Event::Scan { index } => {
                let (sensor, reference) = (all[index].sensor, &references[all[index].sensor]);
                let scan: Vec<&[f64]> = all[index].detections.iter().map(AsRef::as_ref).collect();
                let mut state = filter.snapshot()?;
                let said = filter.scan(sensor, &all[index].detections)?;
                let outcome = reference.scan(&mut state, &scan);
                reference.scan(&mut alone, &scan);
                let after = filter.snapshot()?;
                let mut step = differences(&after, &state, M::FEATURE);
                let ln_evidence = said.ln_evidence.unwrap_or(f64::NAN);
                step.ln_evidence = (ln_evidence - outcome.ln_evidence).abs() / outcome.ln_evidence.abs().max(1.0);
                step.innovation = relative(said.innovation.unwrap_or(0.0), outcome.innovation);
                let same_view = (said.usage.in_view, said.usage.no_birth) == (outcome.in_view, outcome.no_birth);
                step.other_views = usize::from(!same_view);
                step.capacity_events = usize::from(said.health.contains(scphd::Health::COMPONENTS_LOST));
                (step.own_way_position_m, step.own_way_heading_rad) = apart(&after, &alone, M::FEATURE);
                step.scans = 1;
                step.merge(&predictions);
                comparison.overall.merge(&step);
                comparison.scans.push(step);
                predictions = JointDifferences::default();
                progress(comparison.scans.len());
            }
        }
    }
    Ok(comparison)
}

/// Distance (m) and angle (rad) between two poses; or the difference of the coordinates behind the heading if that is greater.
fn apart(ours: &State, theirs: &State, dimension: usize) -> (f64, f64) {
    let uncertain = uncertain(ours, dimension);
    let off: Vec<f64> = ours.pose.iter().zip(&theirs.pose).take(uncertain).map(|(a, b)| a - b).collect();
    let (position, rest) = off.split_at(dimension);
    (norm(position), rest[1..].iter().fold(wrap(rest[0]).abs(), |most, off| larger(most, off.abs())))
}

/// Number of uncertain coordinates of the pose.
fn uncertain(state: &State, dimension: usize) -> usize {
    state.covariance.nrows() - dimension * state.places.len()
}

fn predicted(ours: &State, theirs: &State, dimension: usize) -> JointDifferences {
    let (predicted_position_m, predicted_heading_rad) = apart(ours, theirs, dimension);
    // The prediction keeps the order of the features.
    let same: Vec<usize> = (0..ours.covariance.nrows()).collect();
    let of_all = elements(ours, theirs, &same, &same).fold(0.0, |most, element| larger(most, element.off));
    let predicted_covariance = larger(of_all, scaled_difference(&ours.process_noise, &theirs.process_noise));
    let waited_s = (ours.waited_s - theirs.waited_s).abs();
    JointDifferences {
        predicted_position_m,
        predicted_heading_rad,
        predicted_covariance,
        waited_s,
        ..JointDifferences::default()
    }
}

/// The difference of an element of the covariance.
struct Element {
    row: usize,
    column: usize,
    off: f64,
}

/// The differences of all elements of the covariance in the rows and columns `of_ours`, which correspond to `of_theirs` in the
/// reference.
fn elements<'s>(
    ours: &'s State,
    theirs: &'s State,
    of_ours: &'s [usize],
    of_theirs: &'s [usize],
) -> impl Iterator<Item = Element> + 's {
    let pairs = move || of_ours.iter().zip(of_theirs);
    pairs().flat_map(move |(&row, &their_row)| {
        pairs().map(move |(&column, &their_column)| {
            let off = ours.covariance[(row, column)] - theirs.covariance[(their_row, their_column)];
            let variances = theirs.covariance[(their_row, their_row)] * theirs.covariance[(their_column, their_column)];
            let off = if off == 0.0 { 0.0 } else { off.abs() / variances.sqrt() };
            Element { row, column, off }
        })
    })
}

/// The largest difference of elements of two covariances, each divided by the standard deviations of its row and column.
fn scaled_difference(ours: &DMatrix<f64>, theirs: &DMatrix<f64>) -> f64 {
    let of = |(index, (a, b)): (usize, (&f64, &f64))| {
        let (row, column) = (index % theirs.nrows(), index / theirs.nrows());
        let off = (a - b).abs();
        if off == 0.0 { 0.0 } else { off / (theirs[(row, row)] * theirs[(column, column)]).sqrt() }
    };
    ours.iter().zip(theirs.iter()).enumerate().map(of).fold(0.0, larger)
}

/// Differences of moving-object tracks after a scan.
fn movers(ours: &State, theirs: &State, dimension: usize, differences: &mut JointDifferences) {
    let before = differences.movers;
    for mover in &ours.movers {
        let Some(other) = theirs.movers.iter().find(|other| other.label == mover.label) else {
            differences.unmatched += 1;
            continue;
        };
        let relative = |from: usize| {
            let off: Vec<f64> = (from..from + dimension).map(|k| mover.mean[k] - other.mean[k]).collect();
            norm(&off) / norm(&other.mean.as_slice()[from..from + dimension]).max(1.0)
        };
        let of_mean = larger(relative(0), relative(dimension));
        differences.mover_mean = larger(differences.mover_mean, of_mean);
        let of_covariance = scaled_difference(&mover.covariance, &other.covariance);
        differences.mover_covariance = larger(differences.mover_covariance, of_covariance);
        differences.mover_weight = larger(differences.mover_weight, (mover.weight - other.weight).abs());
        differences.movers += 1;
    }
    differences.unmatched += theirs.movers.len() - (differences.movers - before);
}

fn differences(ours: &State, theirs: &State, dimension: usize) -> JointDifferences {
    let (estimated_position_m, estimated_heading_rad) = apart(ours, theirs, dimension);
    let mut differences = JointDifferences { estimated_position_m, estimated_heading_rad, ..Default::default() };
    let pose = uncertain(ours, dimension);
    let (mut of_ours, mut of_theirs): (Vec<usize>, Vec<usize>) = ((0..pose).collect(), (0..pose).collect());
    for (place, feature) in ours.features.iter().enumerate() {
        let Some(other) = theirs.features.iter().position(|other| other.label == feature.label) else {
            differences.unmatched += 1;
            continue;
        };
        let counterpart = &theirs.features[other];
        of_ours.extend((0..dimension).map(|d| pose + dimension * place + d));
        of_theirs.extend((0..dimension).map(|d| pose + dimension * other + d));
        let (mean, at) = (&ours.places[place], &theirs.places[other]);
        let off: Vec<f64> = mean.iter().zip(at).map(|(a, b)| a - b).collect();
        differences.mean = larger(differences.mean, norm(&off) / norm(at).max(1.0));
        let in_sight = (feature.in_sight - counterpart.in_sight).abs();
        let hidden = (feature.hidden - counterpart.hidden).abs();
        differences.existence = larger(larger(differences.existence, in_sight), hidden);
        let detections = (feature.detections - counterpart.detections).abs();
        differences.detections = larger(differences.detections, detections);
        differences.features += 1;
    }
    differences.unmatched += theirs.features.len() - differences.features;
    movers(ours, theirs, dimension, &mut differences);
    for Element { row, column, off } in elements(ours, theirs, &of_ours, &of_theirs) {
        let of = |index: usize| index.checked_sub(pose).map(|behind| behind / dimension);
        let into = match (of(row), of(column)) {
            (None, None) => &mut differences.pose_covariance,
            (Some(one), Some(other)) if one == other => &mut differences.feature_covariance,
            _ => &mut differences.cross_covariance,
        };
        *into = larger(*into, off);
    }
    differences
}
