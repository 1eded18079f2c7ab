//! The map as one candidate pose sees it: what to expect of every component, and which measurements it meets.

use crate::online::scaled;
use crate::scan::Scan;
use crate::work;
use crate::{
    Bounds, Component, Correction, Dim, Expected, Factor, FieldOfView, LnSum, Locating, Packed, Real, Sensor, Symmetric,
};
use core::cell::Cell;
use nalgebra::{SMatrix, SVector};

/// A sensor at one pose.
#[derive(Debug)]
pub(crate) struct View<'a, T: Real, S, V, F> {
    pub(crate) sensor: &'a S,
    pub(crate) field_of_view: &'a V,
    pub(crate) frame: F,
    /// What p_D is multiplied by.
    pub(crate) detection_scale: T,
    /// ln of [`Config::negligible`](crate::Config::negligible).
    pub(crate) ln_negligible: T,
    /// ln N(0; 0, R), which bounds ln N(ẑ; ẑ, S) from above: S is R and something more.
    pub(crate) ln_sharpest: T,
    /// The most components that the birth intensity can have.
    pub(crate) most_births: usize,
    /// The last probability of detection with its logarithms. Most features have the same, away from the rim.
    pub(crate) last_detection: Cell<Detection<T>>,
}

/// A probability of detection and its logarithms.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Detection<T> {
    /// p_D.
    pub(crate) probability: T,
    /// p_D as the model has it.
    pub(crate) modelled: T,
    /// ln p_D.
    pub(crate) ln_detected: T,
    /// ln(1 − p_D).
    pub(crate) ln_missed: T,
}

impl<T: Real> Detection<T> {
    /// The model's probability, times what was learnt, and its logarithms.
    pub(crate) fn of(modelled: T, scale: T) -> Self {
        let probability = scaled(modelled, scale);
        Self { probability, modelled, ln_detected: probability.ln(), ln_missed: (T::ONE - probability).ln() }
    }
}

/// What a component in view leads one to expect: ẑ, H, S and p_D w.
#[derive(Debug)]
pub(crate) struct Expectation<T: Real, const D: usize, const Z: usize>
where
    Dim<Z>: Packed,
{
    /// ẑ.
    measurement: SVector<T, Z>,
    /// H.
    jacobian: SMatrix<T, Z, D>,
    /// S = H P Hᵀ + R.
    innovation_covariance: Symmetric<T, Z>,
    /// p_D and its logarithms.
    pub(crate) detection: Detection<T>,
    /// ln(p_D w).
    ln_detected_weight: T,
}

/// A measurement that a component may have caused.
#[derive(Debug)]
pub(crate) struct Match<'f, T: Real, const Z: usize>
where
    Dim<Z>: Packed,
{
    /// Its place in the scan.
    pub(crate) index: usize,
    /// z ⊖ ẑ.
    pub(crate) innovation: SVector<T, Z>,
    /// The factor of the component's S.
    pub(crate) factor: &'f Factor<T, Z>,
    /// The squared Mahalanobis length vᵀ S⁻¹ v.
    pub(crate) distance: T,
    /// ln( p_D w N(z; ẑ, S) ), the component's term in η_z (4.51).
    pub(crate) ln_term: T,
    /// What to take its weight relative to while η_z is not complete.
    pub(crate) ln_reference: T,
}

impl<T: Real, const D: usize, const Z: usize> Expectation<T, D, Z>
where
    Dim<Z>: Packed,
{
    /// ẑ and H.
    pub(crate) fn expected(&self) -> Expected<T, D, Z> {
        Expected { measurement: self.measurement, jacobian: self.jacobian }
    }

    /// The factor of S; `None` where rounding has left it without one.
    pub(crate) fn innovation_factor(&self) -> Option<Factor<T, Z>> {
        self.innovation_covariance.factor()
    }

    /// The same with a further uncertainty of ẑ, independent of the feature's, added to S.
    pub(crate) fn blurred(&self, by: &Symmetric<T, Z>) -> Self {
        Self { innovation_covariance: self.innovation_covariance.plus(by), ..*self }
    }

    /// The Kalman correction that any measurement of this component brings.
    pub(crate) fn correction<const N: usize>(
        &self,
        component: &Component<T, N>,
        noise: &Symmetric<T, Z>,
        factor: &Factor<T, Z>,
    ) -> Correction<T, N, Z>
    where
        Dim<N>: Packed,
    {
        Correction::new(&component.covariance, &self.jacobian, noise, factor)
    }
}

impl<T: Real, S, V, F> View<'_, T, S, V, F> {
    /// The box outside which nothing is in view.
    pub(crate) fn bounds<const D: usize, const Z: usize>(&self) -> Bounds<T, D>
    where
        V: FieldOfView<T, F, D, Z>,
    {
        self.field_of_view.bounds(&self.frame)
    }

    /// The birth intensity that does not wait for measurements, if the sensor has one: its components with their places. One that
    /// is not finite or not positive definite is none.
    pub(crate) fn expected_births<const D: usize, const Z: usize>(
        &self,
    ) -> impl Iterator<Item = (usize, Component<T, D>)>
    where
        S: Sensor<T, D, Z, Frame = F>,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        let all = (0..self.most_births).map_while(|index| {
            work::round();
            self.sensor.expected_birth(&self.frame, index).map(|birth| (index, birth))
        });
        all.filter(|(_, birth)| birth.is_usable())
    }

    /// How many components the birth intensity has, usable or not, and whether it has more than there can be.
    pub(crate) fn count_births<const D: usize, const Z: usize>(&self) -> (usize, bool)
    where
        S: Sensor<T, D, Z, Frame = F>,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        let is_there = |&index: &usize| {
            work::round();
            self.sensor.expected_birth(&self.frame, index).is_some()
        };
        let count = (0..self.most_births).take_while(is_there).count();
        (count, count == self.most_births && is_there(&count))
    }

    /// Whether the feature at this position, which this measurement gives, is in view (p_D > 0).
    pub(crate) fn sees<const D: usize, const Z: usize>(
        &self,
        feature: &SVector<T, D>,
        measurement: &SVector<T, Z>,
    ) -> bool
    where
        S: Sensor<T, D, Z, Frame = F>,
        V: FieldOfView<T, F, D, Z>,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        self.field_of_view.detection_probability(&self.frame, feature, measurement) > T::ZERO
    }

    /// Covariance that an uncertain pose lends to what is expected of a feature.
    pub(crate) fn blur<const K: usize, const D: usize, const Z: usize>(
        &self,
        spread: &Symmetric<T, K>,
        feature: &SVector<T, D>,
        expected: &Expected<T, D, Z>,
    ) -> Symmetric<T, Z>
    where
        S: Locating<T, K, D, Z> + Sensor<T, D, Z, Frame = F>,
        Dim<K>: Packed,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        spread.congruence(&self.sensor.by_pose(&self.frame, feature, expected))
    }

    /// What to expect of a component; `None` where it is out of view (p_D = 0).
    #[inline(always)]
    pub(crate) fn expect<const N: usize, const D: usize, const Z: usize>(
        &self,
        component: &Component<T, N>,
    ) -> Option<Expectation<T, D, Z>>
    where
        S: Sensor<T, D, Z, Frame = F>,
        V: FieldOfView<T, F, D, Z>,
        Dim<N>: Packed,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        let position = component.position::<D>();
        if !self.field_of_view.may_see(&self.frame, &position) {
            return None;
        }
        let expected = self.sensor.expect(&self.frame, &position)?;
        let p_d = self.field_of_view.detection_probability(&self.frame, &position, &expected.measurement);
        // Written so that NaN is out of view too.
        if !(p_d > T::ZERO) {
            return None;
        }
        if self.last_detection.get().modelled != p_d {
            self.last_detection.set(Detection::of(p_d, self.detection_scale));
        }
        let detection = self.last_detection.get();
        let position_covariance = component.covariance.leading::<D>();
        Some(Expectation {
            measurement: expected.measurement,
            jacobian: expected.jacobian,
            detection,
            ln_detected_weight: component.ln_weight + detection.ln_detected,
            innovation_covariance: position_covariance.congruence(&expected.jacobian).plus(self.sensor.noise()),
        })
    }

    /// Adds a component's terms to η_z. Not where every component of every candidate comes by, so that it may be small.
    #[inline(never)]
    pub(crate) fn add_terms<const D: usize, const Z: usize>(
        &self,
        expectation: &Expectation<T, D, Z>,
        scan: &Scan<'_, T, Z>,
        eta: &mut [LnSum<T>],
    ) where
        S: Sensor<T, D, Z, Frame = F>,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        self.matches(expectation, scan, |found| {
            if let Some(eta) = eta.get_mut(found.index) {
                eta.add(found.ln_term);
            }
        });
    }

    /// Calls `found` for every measurement whose term in η_z is not negligible, in the order of the scan; around a circle, in that
    /// order on from the first.
    ///
    /// A term counts while it is above `negligible` times what explains its measurement without any feature; that
    /// bounds the distance vᵀ S⁻¹ v, which in turn bounds the sorting coordinate's part of v.
    #[inline(always)]
    pub(crate) fn matches<const D: usize, const Z: usize>(
        &self,
        expectation: &Expectation<T, D, Z>,
        scan: &Scan<'_, T, Z>,
        mut found: impl FnMut(Match<'_, T, Z>),
    ) where
        S: Sensor<T, D, Z, Frame = F>,
        Dim<D>: Packed,
        Dim<Z>: Packed,
    {
        let ln_least = scan.ln_least_unexplained() + self.ln_negligible;
        // The peak itself takes a factorisation and a logarithm, which components that meet nothing do without. The last
        // term outweighs rounding.
        let headroom = expectation.ln_detected_weight + self.ln_sharpest - ln_least + T::from_f64(0.001);
        // Also where the headroom is NaN.
        if !(headroom > T::ZERO) {
            return;
        }
        let farthest = headroom + headroom;
        let covariance = &expectation.innovation_covariance;
        // vᵀ S⁻¹ v is at least v_k²/S_kk for every coordinate k.
        let farthest_along = SVector::<T, Z>::from_fn(|k, _| farthest * covariance.get(k, k));
        let reach = farthest_along.get(S::SORTED_BY).map_or(T::ZERO, |&squared| squared.sqrt_above());
        let mut sharpness = None;
        const {
            assert!(S::SORTED_BY < Z, "SORTED_BY must be a coordinate of the measurement");
            assert!(
                match S::SIFTED_BY {
                    Some(k) => k < Z && k != S::SORTED_BY,
                    None => true,
                },
                "SIFTED_BY must be a coordinate of the measurement, and another one than SORTED_BY"
            );
        }
        let along = |z: &SVector<T, Z>, k: usize| z.get(k).copied().unwrap_or(T::ZERO);
        let sifted_by = S::SIFTED_BY.map(|k| (k, along(&expectation.measurement, k), along(&farthest_along, k)));
        scan.near::<S, D>(&expectation.measurement, reach, |(index, measured)| {
            if let Some((k, expected, farthest)) = sifted_by {
                let apart = along(&measured.z, k) - expected;
                if apart * apart > farthest {
                    return;
                }
            }
            let innovation = self.sensor.innovation(&measured.z, &expectation.measurement);
            let too_far = |(_, (&along, &farthest)): (usize, (&T, &T))| along * along > farthest;
            let mut coordinates = innovation.iter().zip(farthest_along.iter()).enumerate();
            // The sorting coordinate last: the places near have settled it for nearly all.
            if coordinates.clone().filter(|&(k, _)| k != S::SORTED_BY && Some(k) != S::SIFTED_BY).any(too_far)
                || coordinates.nth(S::SORTED_BY).is_some_and(too_far)
            {
                return;
            }
            let ln_detected_weight = expectation.ln_detected_weight;
            let ln_reference = measured.ln_reference();
            if let Some(met) =
                Match::of(index, innovation, *covariance, ln_detected_weight, ln_reference, &mut sharpness)
                && met.ln_term >= ln_least
            {
                found(met);
            }
        });
    }
}

impl<'f, T: Real, const Z: usize> Match<'f, T, Z>
where
    Dim<Z>: Packed,
{
    /// A measurement near what is expected; `None` where rounding has left S without a factor. Apart from the loop over the
    /// measurements, most of which do not come this far, so that the loop stays in the processor's registers.
    #[inline(never)]
    fn of(
        index: usize,
        innovation: SVector<T, Z>,
        covariance: Symmetric<T, Z>,
        ln_detected_weight: T,
        ln_reference: T,
        sharpness: &'f mut Option<(T, Factor<T, Z>)>,
    ) -> Option<Self> {
        // What does not hang on the measurement is kept for the component's next one.
        if sharpness.is_none() {
            *sharpness = covariance.factor().map(|factor| (ln_detected_weight + factor.ln_peak(), factor));
        }
        let (ln_peak, factor) = sharpness.as_ref()?;
        let distance = factor.mahalanobis(&innovation);
        let ln_term = *ln_peak - T::from_f64(0.5) * distance;
        Some(Self { index, innovation, factor, distance, ln_term, ln_reference })
    }
}
