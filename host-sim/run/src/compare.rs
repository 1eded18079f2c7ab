//! Filter and reference in lockstep: every step of the reference starts from the filter's state and random numbers. Differences
//! afterwards are therefore those of a single step.

mod differences;
mod joint;
mod planar;
mod underwater;

pub use differences::{Comparison, Differences, Figure, Figures};
pub use joint::{JointComparison, JointDifferences};

use differences::{NO_FIXES, distance, larger, norm, relative};
use scphd_filters::kind::Kind;
use scphd_filters::settings::Likelihood;
use scphd_filters::slam::{Precision, Refusal, Snapshot, Transparent};
use scphd_log::dimensions::Coordinates;
use scphd_log::events::Event;
use scphd_log::log::Scan;
use scphd_reference::{Component, Particle, Recursion, Selection, State, Weighing};

/// A kind of vehicle for which the reference has models.
pub trait Lockstep: Kind {
    /// [`compare`] with the filter and the reference of this kind.
    fn lockstep(
        log: &Self::Log,
        settings: &Self::Settings,
        precision: Precision,
        seed: u64,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Comparison, Refusal>;

    /// [`compare_joint`] with the joint filter and its reference of this kind.
    fn joint_lockstep(
        log: &Self::Log,
        settings: &Self::Settings,
        precision: Precision,
        progress: &mut dyn FnMut(usize),
    ) -> Result<JointComparison, Refusal>;
}

/// Runs the filter over a log and repeats each of its steps with the reference. `progress` is called with the number of processed
/// scans.
///
/// # Errors
/// The filter refuses the settings or a step; or the settings ask for what the reference does not have: an informed proposal,
/// forgetting or remembering by confirmed components, or another likelihood than the filter's.
pub fn compare<K: Lockstep>(
    log: &K::Log,
    settings: &K::Settings,
    precision: Precision,
    seed: u64,
    mut progress: impl FnMut(usize),
) -> Result<Comparison, Refusal> {
    K::recursion(settings).check_reference_has_all().map_err(Refusal)?;
    if K::recursion(settings).likelihood != Likelihood::SingleCluster {
        return Err(Refusal("the filter has the single-cluster likelihood alone".into()));
    }
    K::lockstep(log, settings, precision, seed, &mut progress)
}

/// Runs the joint filter over a log and repeats each of its steps with its reference. `progress` is called with the number of
/// processed scans.
pub fn compare_joint<K: Lockstep>(
    log: &K::Log,
    settings: &K::Settings,
    precision: Precision,
    mut progress: impl FnMut(usize),
) -> Result<JointComparison, Refusal> {
    K::joint_lockstep(log, settings, precision, &mut progress)
}

/// A reference for vehicles of a kind, with conversions of controls and poses.
trait Comparable<K: Kind, const N: usize, const V: usize>: Recursion<N, V, Measurement = K::Measurement> {
    /// Converts a control for the reference.
    fn control(control: &K::Control) -> Self::Control;

    /// Converts a pose of the reference.
    fn coordinates(pose: &Self::Pose) -> K::Pose;
}

/// Processes a log with a filter and repeats each step with the reference, of which there is one for every sensor.
fn drive<K, R, const N: usize, const V: usize>(
    log: &K::Log,
    settings: &K::Settings,
    references: &[R],
    filter: &mut dyn Transparent<K, R::Pose, N, V>,
    progress: &mut dyn FnMut(usize),
) -> Result<Comparison, Refusal>
where
    K: Kind,
    R: Comparable<K, N, V>,
{
    let all = K::scans(log);
    let mut comparison = Comparison { scans: Vec::with_capacity(all.len()), overall: Differences::default() };
    let mut predictions = Differences::default();
    let mut predicted = false;
    for event in K::events(log, settings)? {
        match event {
            Event::Predict { control, dt_s, .. } => {
                let before = filter.snapshot()?;
                // If the filter rejects a step, the reference does not repeat it: its next step starts from the filter's state.
                if filter.predict(control, dt_s)?.is_none() {
                    let after = filter.snapshot()?;
                    predictions
                        .merge(&predict::<K, R, N, V>(&references[0], before, &after, predicted, &control, dt_s));
                }
                predicted = true;
            }
            Event::Fix { .. } => return Err(Refusal(NO_FIXES.into())),
            Event::Scan { index } => {
                let mut step = scan(references, filter, predicted, &all[index])?;
                step.merge(&predictions);
                comparison.overall.merge(&step);
                comparison.scans.push(step);
                predictions = Differences::default();
                predicted = false;
                progress(comparison.scans.len());
            }
        }
    }
    Ok(comparison)
}

/// The reference's state at a snapshot of the filter.
fn state_of<P: Copy, const N: usize, const V: usize>(snapshot: &Snapshot<P, N, V>, predicted: bool) -> State<P, N, V> {
    let children = snapshot.candidates.len() / snapshot.maps.len();
    let maps = snapshot.maps.iter().zip(&snapshot.moving).zip(snapshot.candidates.iter().step_by(children));
    let particles = maps.map(|((map, moving), first)| Particle {
        pose: first.pose,
        ln_weight: first.ln_weight,
        map: map.clone(),
        moving: moving.clone(),
    });
    State {
        particles: particles.collect(),
        candidates: predicted.then(|| snapshot.candidates.clone()),
        waited_s: snapshot.waited_s,
        heaviest: snapshot.heaviest,
    }
}

fn predict<K: Kind, R: Comparable<K, N, V>, const N: usize, const V: usize>(
    reference: &R,
    mut before: Snapshot<R::Pose, N, V>,
    after: &Snapshot<R::Pose, N, V>,
    predicted: bool,
    control: &K::Control,
    dt_s: f64,
) -> Differences {
    let mut state = state_of(&before, predicted);
    reference.predict(&mut state, &R::control(control), dt_s, &mut *before.draws);
    let waited_s = (after.waited_s - state.waited_s).abs();
    let mut differences = Differences { waited_s, ..Differences::default() };
    for (ours, theirs) in after.candidates.iter().zip(&state.current()) {
        let (position, heading) = apart::<K>(&R::coordinates(&ours.pose), &R::coordinates(&theirs.pose));
        differences.merge(&Differences {
            predicted_position_m: position,
            predicted_heading_rad: heading,
            particle_weight: (ours.ln_weight - theirs.ln_weight).abs(),
            ..Differences::default()
        });
    }
    differences
}

fn scan<K: Kind, R: Comparable<K, N, V>, const N: usize, const V: usize>(
    references: &[R],
    filter: &mut dyn Transparent<K, R::Pose, N, V>,
    predicted: bool,
    Scan { sensor, detections, .. }: &Scan<K>,
) -> Result<Differences, Refusal> {
    let reference = &references[*sensor];
    let mut before = filter.snapshot()?;
    let mut state = state_of(&before, predicted);
    let outcome = filter.scan(*sensor, detections)?;
    let after = filter.snapshot()?;
    let mut differences = Differences { scans: 1, ..Differences::default() };
    differences.capacity_events = usize::from(
        [scphd::Health::PRUNING_TIGHTENED, scphd::Health::MAP_NOT_UPDATED, scphd::Health::COMPONENTS_LOST]
            .iter()
            .any(|&flag| outcome.health.contains(flag)),
    );

    let weighing = reference.weigh(&state, detections);
    for (&ours, &theirs) in after.ln_likelihoods.iter().zip(&weighing.ln_likelihoods) {
        let scale = ours.abs().max(theirs.abs()).max(1.0);
        differences.ln_likelihood = differences.ln_likelihood.max((ours - theirs).abs() / scale);
    }
    let selection = reference.select(&state, &weighing, &mut *before.draws);
    let agreed = selection.survivors == after.survivors && selection.resampled == outcome.resampled;
    differences.other_survivors = usize::from(!agreed);
    let selection =
        if agreed { selection } else { as_selected(outcome.resampled, &after.survivors, &state, &weighing) };
    reference.update(&mut state, detections, &weighing, &selection);

    for (ours, theirs) in after.candidates.iter().zip(&state.particles) {
        // Relative difference of the weights, also of negligible ones.
        let weight = (ours.ln_weight - theirs.ln_weight).exp_m1().abs();
        differences.particle_weight = differences.particle_weight.max(weight);
    }
    for (particle, theirs) in state.particles.iter().enumerate() {
        if particle == 0 || after.survivors[particle] != after.survivors[particle - 1] {
            differences.merge(&map_differences::<N, N>(&after.maps[particle], &theirs.map));
            let moving = map_differences::<V, N>(&after.moving[particle], &theirs.moving);
            differences.merge(&Differences { components: 0, moving_components: moving.components, ..moving });
        }
    }
    let (pose, _) = filter.pose()?;
    let (position, heading) = apart::<K>(&pose, &R::coordinates(&reference.estimated(&state)));
    (differences.estimated_position_m, differences.estimated_heading_rad) = (position, heading);
    Ok(differences)
}

/// The filter's selection with the reference's weights.
fn as_selected<P: Copy, const N: usize, const V: usize>(
    resampled: bool,
    survivors: &[usize],
    state: &State<P, N, V>,
    weighing: &Weighing,
) -> Selection {
    let equal = -(survivors.len() as f64).ln();
    let samples = state.samples();
    let family = |parent: usize| {
        let total: f64 = weighing.ln_weights[parent * samples..(parent + 1) * samples].iter().map(|w| w.exp()).sum();
        total.ln()
    };
    let ln_weights = survivors.iter().map(|survivor| if resampled { equal } else { family(survivor / samples) });
    Selection { resampled, survivors: survivors.to_vec(), ln_weights: ln_weights.collect() }
}

/// Greatest distance of corresponding components, relative to their distance from the origin.
const COUNTERPART: f64 = 1e-3;

/// Differences of components of `N` numbers, of which the first `D` are a position.
fn map_differences<const N: usize, const D: usize>(ours: &[Component<N>], theirs: &[Component<N>]) -> Differences {
    let mut differences = Differences::default();
    let mut unmatched_mass = 0.0;
    let mut free: Vec<&Component<N>> = theirs.iter().collect();
    let apart = |a: &Component<N>, b: &Component<N>| distance(&a.mean, &b.mean) + (a.ln_weight - b.ln_weight).abs();
    for component in ours {
        let nearest = (0..free.len()).min_by(|&a, &b| apart(component, free[a]).total_cmp(&apart(component, free[b])));
        let counterpart = nearest.filter(|&index| {
            let other = free[index];
            mean_difference::<N, D>(component, other) < COUNTERPART
                && (component.ln_weight - other.ln_weight).abs() < 0.1
        });
        let Some(index) = counterpart else {
            differences.unmatched += 1;
            unmatched_mass += component.weight();
            continue;
        };
        let other = free.swap_remove(index);
        differences.components += 1;
        let weight = (component.ln_weight - other.ln_weight).exp_m1().abs();
        differences.component_weight = differences.component_weight.max(weight);
        differences.mean = differences.mean.max(mean_difference::<N, D>(component, other));
        differences.covariance = differences.covariance.max(covariance_difference(component, other));
    }
    differences.unmatched += free.len();
    unmatched_mass += free.iter().map(|component| component.weight()).sum::<f64>();
    let mass = |map: &[Component<N>]| map.iter().map(Component::weight).sum::<f64>();
    differences.mass = relative(mass(ours), mass(theirs));
    differences.unmatched_mass = if unmatched_mass > 0.0 { unmatched_mass / mass(theirs).max(1.0) } else { 0.0 };
    differences
}

/// The greater of the relative differences of position and, for moving components, velocity.
fn mean_difference<const N: usize, const D: usize>(a: &Component<N>, b: &Component<N>) -> f64 {
    let parts = a.mean.chunks(D).zip(b.mean.chunks(D));
    parts.map(|(a, b)| distance(a, b) / norm(b).max(1.0)).fold(0.0, larger)
}

fn covariance_difference<const N: usize>(a: &Component<N>, b: &Component<N>) -> f64 {
    let (a, b) = (a.covariance.as_flattened(), b.covariance.as_flattened());
    distance(a, b) / norm(b)
}

/// Distance (m) and angle (rad) between two poses; or their difference of an angular rate (rad/s) if that is greater.
fn apart<K: Kind>(a: &K::Pose, b: &K::Pose) -> (f64, f64) {
    let (a_place, b_place) = (K::position(a), K::position(b));
    let turned = scphd_log::angle::wrap(K::heading(a) - K::heading(b)).abs();
    let rest = a.as_ref().iter().zip(b.as_ref()).skip(K::Position::COUNT + 1).map(|(a, b)| (a - b).abs());
    (distance(a_place.as_ref(), b_place.as_ref()), rest.fold(turned, larger))
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_reference::Candidate;

    fn moving(weight: f64, velocity: f64) -> Component<4> {
        let mut covariance = [[0.0; 4]; 4];
        (0..4).for_each(|k| covariance[k][k] = 0.5);
        Component { ln_weight: weight.ln(), mean: [30.0, 40.0, velocity, 0.0], covariance }
    }

    #[test]
    fn velocities_of_moving_components_are_compared_too() {
        let mut other = moving(0.5, 2.0);
        other.mean[2] = 2.0 + 2e-4;
        other.covariance[3][3] += 1e-6;
        // At the same position with another velocity it is another component.
        let ours = [moving(0.5, 2.0), moving(0.25, -1.0)];
        let differences = map_differences::<4, 2>(&ours, &[moving(0.25 + 1e-9, -1.0), other]);
        assert_eq!((differences.components, differences.unmatched), (2, 0));
        assert!((differences.mean - 1e-4).abs() < 1e-7, "{differences:?}");
        assert!((differences.covariance - 1e-6).abs() < 1e-9, "{differences:?}");
        assert!((differences.component_weight - 4e-9).abs() < 1e-12, "{differences:?}");

        let turned = map_differences::<4, 2>(&[moving(0.5, 2.0)], &[moving(0.5, -2.0)]);
        assert_eq!((turned.components, turned.unmatched), (0, 2));
        assert_eq!((turned.mass, turned.unmatched_mass), (0.0, 1.0));
    }

    #[test]
    fn nan_is_the_largest_difference() {
        let mut differences = Differences { mean: 3.0, mass: f64::NAN, ..Differences::default() };
        differences.merge(&Differences { mean: f64::NAN, mass: 1.0, ..Differences::default() });
        assert!(differences.mean.is_nan() && differences.mass.is_nan());
    }

    #[test]
    fn weights_follow_the_selection_of_the_filter() {
        let mut state: State = State::new(2, [0.0; 3]);
        let shares = [0.3, 0.5, 0.05, 0.15].map(f64::ln);
        state.candidates = Some(shares.map(|ln_weight| Candidate { pose: [0.0; 3], ln_weight }).to_vec());
        let weighing =
            Weighing { ln_likelihoods: vec![0.0; 4], ln_weights: shares.to_vec(), n_eff: 2.7, weights_kept: false };
        for (resampled, expected) in [(true, [0.5, 0.5]), (false, [0.8, 0.2])] {
            let selection = as_selected(resampled, &[1, 3], &state, &weighing);
            assert_eq!((selection.resampled, &selection.survivors[..]), (resampled, &[1, 3][..]));
            for (ln_weight, expected) in selection.ln_weights.iter().zip(expected) {
                assert!((ln_weight.exp() - expected).abs() < 1e-15);
            }
        }
    }
}
