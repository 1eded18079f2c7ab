//! The informed proposal: poses drawn from where the vehicle's motion and the scan agree.
//!
//! Between scans a particle's pose is a Gaussian N(x̄, P). At the scan it is written x = x̄ ⊕ A ξ with A Aᵀ = P and
//! ξ ~ N(0, I), so that a direction in which the pose is certain costs nothing and needs no inverse. The scan is taken in
//! by iterated linearisation: every component in view speaks for a measurement with the share of η_z that is its own, as
//! computed with the pose's uncertainty of the round before, which narrows from round to round. The samples come from the Gaussian found,
//! and are weighed by prior over proposal, so that what they stand for is what blind samples would stand for.

use crate::detection::maps::{DynamicMaps, StaticMaps};
use crate::detection::scan::Scan;
use crate::detection::seen::reset_eta;
use crate::detection::view::{ExpectationOf, View, Views};
use crate::map::workspace::{Entry, Origin};
use crate::map::{Maps, within};
use crate::numerics::range::{is_within_range, is_within_square};
use crate::numerics::vector::{applied, product, transposed};
use crate::particles::candidate::Candidate;
use crate::particles::cursor::Cursor;
use crate::particles::predict::split;
use crate::{
    Component, Factor, Informed, Linear, LnSum, MeasurementModel, Noise, Pose, Real, ScalarOf, Sensor, Symmetric,
    TangentOf, Vector, Zero,
};

/// The Gaussian of one particle's ξ: N(ξ̂, Λ⁻¹).
#[derive(Debug, Clone, Copy)]
struct Posterior<K: Vector> {
    mean: K,
    /// The factor of Λ.
    information: Factor<K>,
    /// Λ⁻¹.
    covariance: Symmetric<K>,
}

impl<T: Real, K: Vector<Scalar = T>> Posterior<K> {
    /// N(ξ̂, Λ⁻¹) with Λ ξ̂ = `pull`; `None` where rounding or overflow has left nothing of it.
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

fn identity<T: Real, K: Vector<Scalar = T>>() -> Symmetric<K> {
    Symmetric::from_fn(|row, column| if row == column { T::ONE } else { T::ZERO })
}

/// What the proposal works with, beside the particles.
pub(crate) struct Proposer<'a, 's, 'v, X: MeasurementModel> {
    pub(crate) informed: Informed<ScalarOf<X::Pose>>,
    /// ln of the weight below which the update drops components: those do not steer.
    pub(crate) ln_floor: ScalarOf<X::Pose>,
    /// What is seen from a pose.
    pub(crate) views: &'a Views<'v, X>,
    pub(crate) static_maps: &'a mut StaticMaps<'s, X::Pose>,
    pub(crate) moving_maps: &'a DynamicMaps<'s, X::Pose>,
    pub(crate) scan: &'a Scan<'a, X::Measurement>,
    pub(crate) eta: &'a mut [LnSum<ScalarOf<X::Pose>>],
}

impl<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>> Proposer<'_, '_, '_, X> {
    /// Replaces every particle by `samples` candidates, and sets for each ln p(ξ) − ln q(ξ), the part of its weight that
    /// corrects for where it was drawn. Of the covariances, what has not been drawn stays. Returns for how many particles more
    /// components lie near measurements than the workspace holds: there the heavier ones steer, and of equal ones the first.
    pub(crate) fn all(
        mut self,
        samples: usize,
        cursor: &mut Cursor<T>,
        candidates: &mut [Candidate<P>],
        pose_covariances: &mut [Symmetric<P::Tangent>],
        ln_corrections: &mut [T],
        noise: &mut Noise,
    ) -> usize {
        split(candidates, cursor.particles, samples);
        cursor.children = samples;
        let mut crowded = 0;
        let families = candidates.chunks_mut(samples.max(1)).zip(ln_corrections.chunks_mut(samples.max(1)));
        for (particle, ((family, ln_corrections), pose_covariance)) in
            families.zip(pose_covariances).take(cursor.particles).enumerate()
        {
            let Some(parent) = family.first().map(|candidate| candidate.pose) else { continue };
            let root = pose_covariance.root();
            let posterior = self.posterior(particle, &parent, &root);
            crowded += usize::from(self.static_maps.workspace.tightened() || self.static_maps.workspace.lost() > 0);
            let Some(posterior) = posterior else { continue };
            let left =
                posterior.covariance.congruence::<P::Tangent>(&root).scaled(T::ONE - self.informed.sampled_fraction);
            // Rounding may have left a prior that no Gaussian has. Then it stays, and the next predictions blur it.
            if !is_within_square(&left) {
                continue;
            }
            let half = T::from_f64(0.5);
            let ln_scale = half * posterior.information.ln_determinant();
            let share = self.informed.sampled_fraction.sqrt();
            for (candidate, ln_correction) in family.iter_mut().zip(ln_corrections) {
                let drawn = P::Tangent::with(|_| share * noise.normal());
                let xi = posterior.mean + posterior.information.spread_inverse(&drawn);
                let pose = parent.displaced(&applied::<P::Tangent, P::Tangent>(&root, &xi));
                if is_within_range(&pose.coordinates()) {
                    candidate.pose = pose;
                    *ln_correction = half * (drawn.dot(&drawn) - xi.dot(&xi)) - ln_scale;
                }
            }
            *pose_covariance = left;
        }
        crowded
    }

    /// The Gaussian of ξ given the scan and the particle's map.
    fn posterior(
        &mut self,
        particle: usize,
        parent: &P,
        root: &Linear<P::Tangent, P::Tangent>,
    ) -> Option<Posterior<P::Tangent>> {
        let ln_negligible = self.informed.min_responsibility.ln();
        let views = Views { ln_negligible, ..*self.views };
        let mut posterior = Posterior::prior()?;
        let view = views.from(parent);
        let bounds = view.bounds();
        let Maps { table, pool, workspace } = &mut *self.static_maps;
        workspace.clear(self.ln_floor);
        let pages = table.pages_near(particle, &bounds).iter().filter_map(|&id| pool.get(id));
        for component in pages.filter(|page| page.bounds().meets(&bounds)).flat_map(|page| page.components()) {
            let Some(sighted) = Sighted::new(&view, component, root, &posterior.covariance) else { continue };
            let mut near = false;
            view.matches(&sighted.blurred, self.scan, |_| near = true);
            if near {
                workspace.push(*component, Origin::Missed);
            }
        }
        if workspace.in_view().is_empty() {
            return Some(posterior);
        }
        for _ in 0..self.informed.rounds {
            let view = views.from(&parent.displaced(&applied::<P::Tangent, P::Tangent>(root, &posterior.mean)));
            reset_eta(self.eta, self.scan);
            let components = || workspace.in_view().iter().map(|Entry { component, .. }| component);
            for component in components() {
                let Some(sighted) = Sighted::new(&view, component, root, &posterior.covariance) else { continue };
                view.add_terms(&sighted.blurred, self.scan, self.eta);
            }
            // What moves claims its measurements, but does not steer.
            for component in within(self.moving_maps, particle, &view.bounds()) {
                let Some(sighted) = Sighted::new(&view, component, root, &posterior.covariance) else { continue };
                view.add_terms(&sighted.blurred, self.scan, self.eta);
            }
            let (mut information, mut pull) = (identity(), P::Tangent::ZERO);
            for component in components() {
                let Some(sighted) = Sighted::new(&view, component, root, &posterior.covariance) else { continue };
                let (mut share_sum, mut innovation_sum) = (T::ZERO, X::Measurement::ZERO);
                view.matches(&sighted.blurred, self.scan, |found| {
                    let ln_eta = self.eta.get(found.index).map_or(T::INFINITY, LnSum::ln);
                    let share = (found.ln_term - ln_eta).exp();
                    if share >= self.informed.min_responsibility {
                        share_sum += share;
                        innovation_sum += found.innovation * share;
                    }
                });
                if share_sum > T::ZERO
                    && let Some(sharp) = sighted.sharp.innovation_factor()
                {
                    let slope = &sighted.slope;
                    let back = transposed::<X::Measurement, P::Tangent>(slope);
                    let told = sharp.inverse().congruence::<P::Tangent>(&back);
                    information = information.plus(&told.scaled(share_sum));
                    let expected = applied::<X::Measurement, P::Tangent>(slope, &posterior.mean);
                    let residual = innovation_sum + expected * share_sum;
                    pull += applied::<P::Tangent, X::Measurement>(&back, &sharp.solve(&residual));
                }
            }
            posterior = Posterior::new(&information, &pull)?;
        }
        Some(posterior)
    }
}

/// What is expected of a component from an uncertain pose.
struct Sighted<X: MeasurementModel> {
    /// From the pose itself.
    sharp: ExpectationOf<X>,
    /// With the uncertainty of the pose in S.
    blurred: ExpectationOf<X>,
    /// ∂h/∂ξ = ∂h/∂x A.
    slope: Linear<X::Measurement, TangentOf<X::Pose>>,
}

impl<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>> Sighted<X> {
    fn new<N: Vector<Scalar = T>>(
        view: &View<'_, X>,
        component: &Component<N>,
        root: &Linear<P::Tangent, P::Tangent>,
        covariance: &Symmetric<P::Tangent>,
    ) -> Option<Self> {
        let sharp = view.expect(component)?;
        let by_pose = view.sensor.by_pose(&view.frame, &component.position(), &sharp.expected());
        let slope = product::<X::Measurement, P::Tangent, P::Tangent>(&by_pose, root);
        let blurred = sharp.blurred(&covariance.congruence::<X::Measurement>(&slope));
        Some(Self { sharp, blurred, slope })
    }
}
