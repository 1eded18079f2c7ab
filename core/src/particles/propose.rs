//! The informed proposal: poses drawn from the product of motion and scan likelihood.
//!
//! Between scans the pose of a particle is a Gaussian N(x̄, P). At the scan it is written x = x̄ ⊕ A ξ with A Aᵀ = P and ξ ~ N(0,
//! I), so that directions without variance need no inverse. The scan is used by iterated linearisation: every component in view
//! corrects the pose with each measurement, weighted with its share of η_z (association probability), computed with the pose
//! covariance of the previous iteration, which becomes smaller from iteration to iteration. The samples are drawn from the
//! resulting Gaussian, with importance weights prior over proposal, so that they represent the same density as samples of the blind
//! proposal.

use crate::detection::scan::Scan;
use crate::detection::seen::reset_eta;
use crate::detection::view::{ExpectationOf, View, Views};
use crate::map::workspace::{Entry, Origin, Workspace};
use crate::map::{MapTable, Pool, on_pages_within};
use crate::numerics::range::{is_within_range, is_within_square};
use crate::numerics::vector::{applied, product, transposed};
use crate::particles::candidate::Candidate;
use crate::particles::cursor::Cursor;
use crate::particles::predict::split;
use crate::{
    Bounds, Component, CovarianceOf, Dynamic, Factor, Feature, Informed, Linear, LnSum, MeasurementModel, MovingOf,
    Noise, Pose, PositionOf, Real, ScalarOf, Sensor, Static, Symmetric, TangentOf, Vector, Zero,
};

/// The Gaussian of one particle's ξ: N(ξ̂, Λ⁻¹).
#[derive(Debug, Clone, Copy)]
struct Posterior<K: Vector> {
    mean: K,
    /// The Cholesky factor of Λ.
    information: Factor<K>,
    /// Λ⁻¹.
    covariance: Symmetric<K>,
}

impl<T: Real, K: Vector<Scalar = T>> Posterior<K> {
    /// N(ξ̂, Λ⁻¹) with Λ ξ̂ = `pull`; `None` if it is not finite or not positive definite because of rounding or overflow.
    fn new(information: &Symmetric<K>, pull: &K) -> Option<Self> {
        let information = information.factor()?;
        let (mean, covariance) = (information.solve(pull), information.inverse());
        let finite = mean.as_slice().iter().all(|x| x.is_finite()) && covariance.is_finite();
        finite.then_some(Self { mean, information, covariance })
    }

    /// Before the scan: N(0, I).
    fn prior() -> Option<Self> {
        Self::new(&identity(), &K::ZERO)
    }
}

/// Iteration stops when ξ̂ has moved by at most this number of standard deviations of the posterior.
const SETTLED: f64 = 0.3;

fn identity<T: Real, K: Vector<Scalar = T>>() -> Symmetric<K> {
    Symmetric::from_fn(|row, column| if row == column { T::ONE } else { T::ZERO })
}

/// A particle with its candidates.
#[derive(Debug)]
pub struct Family<'f, P: Pose> {
    /// Its index.
    pub particle: usize,
    /// The candidates, which are copies of the particle before they are sampled.
    pub candidates: &'f mut [Candidate<P>],
    /// The terms of their ln L that correct for the proposal density.
    pub ln_corrections: &'f mut [ScalarOf<P>],
    /// The covariance of the particle's pose.
    pub pose_covariance: &'f mut CovarianceOf<P>,
}

/// Working memory for one particle: for its components near measurements, and for η.
pub(crate) type Scratch<'a, 'w, P> =
    (&'a mut Workspace<'w, PositionOf<P>>, &'a mut Workspace<'w, MovingOf<P>>, &'a mut [LnSum<ScalarOf<P>>]);

/// The maps of one kind of features.
type MapsOf<'a, 's, F> = (&'a MapTable<'s, <F as Feature>::Position>, &'a Pool<'s, F>);

/// The data that the proposal needs besides the particles.
pub(crate) struct Proposer<'a, 's, 'v, X: MeasurementModel> {
    pub(crate) informed: Informed<ScalarOf<X::Pose>>,
    /// ln of the pruning threshold of the update: lighter components are not used.
    pub(crate) ln_floor: ScalarOf<X::Pose>,
    /// Data for views from any pose.
    pub(crate) views: &'a Views<'v, X>,
    pub(crate) of_static: MapsOf<'a, 's, Static<PositionOf<X::Pose>>>,
    pub(crate) of_moving: MapsOf<'a, 's, Dynamic<PositionOf<X::Pose>>>,
    pub(crate) scan: &'a Scan<'a, X::Measurement>,
}

impl<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>> Proposer<'_, '_, '_, X> {
    /// Replaces every particle by `samples` candidates, [one](Self::one) after the other. Returns the number of particles for which
    /// the workspaces were too small.
    pub(crate) fn all(
        &self,
        (static_workspace, moving_workspace, eta): Scratch<'_, '_, P>,
        samples: usize,
        cursor: &mut Cursor<T>,
        (candidates, ln_corrections): (&mut [Candidate<P>], &mut [T]),
        pose_covariances: &mut [Symmetric<P::Tangent>],
        noise: &mut Noise,
    ) -> usize {
        split(candidates, cursor.particles, samples);
        cursor.children = samples;
        let mut crowded = 0;
        let families = candidates.chunks_mut(samples.max(1)).zip(ln_corrections.chunks_mut(samples.max(1)));
        for (particle, ((candidates, ln_corrections), pose_covariance)) in
            families.zip(pose_covariances).take(cursor.particles).enumerate()
        {
            let family = Family { particle, candidates, ln_corrections, pose_covariance };
            let scratch = (&mut *static_workspace, &mut *moving_workspace, &mut *eta);
            crowded += usize::from(self.one(family, scratch, noise));
        }
        crowded
    }

    /// Samples the candidates of a particle, and sets ln p(ξ) − ln q(ξ) for each, the term of its weight that corrects for the
    /// proposal density. The covariance keeps the part that is not sampled. Returns whether there are more components near
    /// measurements than the workspaces hold: then only the heaviest components are used, and of equal ones the first.
    pub(crate) fn one(&self, family: Family<'_, P>, mut scratch: Scratch<'_, '_, P>, noise: &mut Noise) -> bool {
        let Family { particle, candidates, ln_corrections, pose_covariance } = family;
        let Some(parent) = candidates.first().map(|candidate| candidate.pose) else { return false };
        let root = pose_covariance.root();
        let posterior = self.posterior(particle, &parent, &root, &mut scratch);
        let crowded = scratch.0.is_short() || scratch.1.is_short();
        let left = posterior.as_ref().map(|posterior| {
            posterior.covariance.congruence::<P::Tangent>(&root).scaled(T::ONE - self.informed.sampled_fraction)
        });
        // Rounding may have made the posterior covariance invalid. Then the particle keeps its prior, whose covariance the next
        // predictions increase. Each particle has its place in the random stream.
        let (Some(posterior), Some(left)) = (posterior, left.filter(is_within_square)) else {
            for _ in 0..candidates.len() * P::Tangent::DIMENSION {
                let _: T = noise.uniform();
            }
            return crowded;
        };
        let half = T::from_f64(0.5);
        let ln_scale = half * posterior.information.ln_determinant();
        let share = self.informed.sampled_fraction.sqrt();
        for (candidate, ln_correction) in candidates.iter_mut().zip(ln_corrections) {
            let drawn = P::Tangent::with(|_| share * noise.normal());
            let xi = posterior.mean + posterior.information.spread_inverse(&drawn);
            let pose = parent.displaced(&applied::<P::Tangent, P::Tangent>(&root, &xi));
            if is_within_range(&pose.coordinates()) {
                candidate.pose = pose;
                *ln_correction = half * (drawn.dot(&drawn) - xi.dot(&xi)) - ln_scale;
            }
        }
        *pose_covariance = left;
        crowded
    }

    /// The Gaussian of ξ given the scan and the particle's map.
    fn posterior(
        &self,
        particle: usize,
        parent: &P,
        root: &Linear<P::Tangent, P::Tangent>,
        (static_workspace, moving_workspace, eta): &mut Scratch<'_, '_, P>,
    ) -> Option<Posterior<P::Tangent>> {
        let Self { informed, ln_floor, views, of_static, of_moving, scan } = self;
        let views = Views { ln_negligible: informed.min_responsibility.ln(), ..**views };
        let mut posterior = Posterior::prior()?;
        let mut uncertain = UncertainView { view: views.from(parent), root, covariance: posterior.covariance, scan };
        let bounds = uncertain.view.bounds();
        // The first iteration selects the components: those without an association are not used in later iterations.
        reset_eta(eta, scan);
        static_workspace.clear(*ln_floor);
        moving_workspace.clear(*ln_floor);
        uncertain.gather(*of_static, static_workspace, particle, &bounds, eta);
        if static_workspace.in_view().is_empty() {
            return Some(posterior);
        }
        uncertain.gather(*of_moving, moving_workspace, particle, &bounds, eta);
        for round in 0..informed.rounds {
            if round > 0 {
                let xi = applied::<P::Tangent, P::Tangent>(root, &posterior.mean);
                uncertain = UncertainView {
                    view: views.from(&parent.displaced(&xi)),
                    covariance: posterior.covariance,
                    ..uncertain
                };
                reset_eta(eta, scan);
                uncertain.claim(static_workspace, eta);
                uncertain.claim(moving_workspace, eta);
            }
            let components = static_workspace.in_view().iter().map(|Entry { component, .. }| component);
            let steered = uncertain.steered(components, &posterior.mean, informed.min_responsibility, eta)?;
            let moved = steered.mean - posterior.mean;
            posterior = steered;
            // The iteration converges quadratically. The comparison is written so that NaN stops it.
            if !(posterior.information.quadratic(&moved) > T::from_f64(SETTLED * SETTLED)) {
                break;
            }
        }
        Some(posterior)
    }
}

/// A view of some components from a pose with a covariance, in coordinates ξ.
struct UncertainView<'l, 'v, X: MeasurementModel> {
    view: View<'v, X>,
    /// A.
    root: &'l Linear<TangentOf<X::Pose>, TangentOf<X::Pose>>,
    /// Λ⁻¹.
    covariance: CovarianceOf<X::Pose>,
    scan: &'l Scan<'l, X::Measurement>,
}

impl<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>> UncertainView<'_, '_, X> {
    /// The predicted measurement of a component from the uncertain pose.
    #[inline]
    fn predict<N: Vector<Scalar = T>>(&self, component: &Component<N>) -> Option<Prediction<X>> {
        let mut blurred = self.view.expect(component)?;
        let by_pose = self.view.sensor.by_pose(&self.view.frame, &component.position(), &blurred.expected());
        let slope = product::<X::Measurement, P::Tangent, P::Tangent>(&by_pose, self.root);
        let sharp = blurred.innovation_covariance;
        blurred.blur(&self.covariance.congruence::<X::Measurement>(&slope));
        Some(Prediction { sharp, blurred, slope })
    }

    /// Adds a component's terms to η_z. Returns whether it has any.
    #[inline(never)]
    fn claims<N: Vector<Scalar = T>>(&self, component: &Component<N>, eta: &mut [LnSum<T>]) -> bool {
        let mut any = false;
        if let Some(Prediction { blurred, .. }) = &self.predict(component) {
            self.view.matches(blurred, self.scan, |found| {
                any = true;
                if let Some(eta) = eta.get_mut(found.index) {
                    eta.add(found.ln_term);
                }
            });
        }
        any
    }

    /// Fills the workspace with the components of a map that may explain a measurement, and adds their terms to η_z.
    fn gather<F: Feature<Position = P::Position>>(
        &self,
        maps: MapsOf<'_, '_, F>,
        workspace: &mut Workspace<'_, F::State>,
        particle: usize,
        bounds: &Bounds<P::Position>,
        eta: &mut [LnSum<T>],
    ) {
        for component in on_pages_within(maps, particle, bounds) {
            if self.claims(component, eta) {
                workspace.push(component, Origin::Missed);
            }
        }
    }

    /// Adds the terms of the workspace's components to η_z.
    fn claim<N: Vector<Scalar = T>>(&self, workspace: &Workspace<'_, N>, eta: &mut [LnSum<T>]) {
        for Entry { component, .. } in workspace.in_view() {
            self.claims(component, eta);
        }
    }

    /// The posterior after correction with all associations of the components, weighted with their association probabilities by
    /// complete η_z. Associations with a probability below `least` are ignored.
    fn steered<'c>(
        &self,
        components: impl Iterator<Item = &'c Component<P::Position>>,
        mean: &P::Tangent,
        least: T,
        eta: &[LnSum<T>],
    ) -> Option<Posterior<P::Tangent>>
    where
        P::Position: 'c,
    {
        let (mut information, mut pull) = (identity(), P::Tangent::ZERO);
        for component in components {
            let Some(seen) = self.predict(component) else { continue };
            let (mut share_sum, mut innovation_sum) = (T::ZERO, X::Measurement::ZERO);
            self.view.matches(&seen.blurred, self.scan, |found| {
                let ln_eta = eta.get(found.index).map_or(T::INFINITY, LnSum::ln);
                let share = (found.ln_term - ln_eta).exp();
                if share >= least {
                    share_sum += share;
                    innovation_sum += found.innovation * share;
                }
            });
            if share_sum > T::ZERO
                && let Some(sharp) = seen.sharp.factor()
            {
                let slope = &seen.slope;
                let back = transposed::<X::Measurement, P::Tangent>(slope);
                let told = sharp.inverse().congruence::<P::Tangent>(&back);
                information = information.plus(&told.scaled(share_sum));
                let expected = applied::<X::Measurement, P::Tangent>(slope, mean);
                let residual = innovation_sum + expected * share_sum;
                pull += applied::<P::Tangent, X::Measurement>(&back, &sharp.solve(&residual));
            }
        }
        Posterior::new(&information, &pull)
    }
}

/// The predicted measurement of a component from an uncertain pose.
struct Prediction<X: MeasurementModel> {
    /// S without the uncertainty of the pose.
    sharp: Symmetric<X::Measurement>,
    /// The predicted measurement, with the uncertainty of the pose in S.
    blurred: ExpectationOf<X>,
    /// ∂h/∂ξ = ∂h/∂x A.
    slope: Linear<X::Measurement, TangentOf<X::Pose>>,
}
