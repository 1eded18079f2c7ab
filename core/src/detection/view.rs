//! The map as seen from one candidate pose: predicted measurements of components, and the measurements within their gates.

use crate::detection::scan::Scan;
use crate::models::{OwnNoise, noise_at};
use crate::numerics::work;
use crate::{
    Bounds, Component, Correction, Expected, ExpectedOf, Factor, FieldOfView, Linear, MeasurementModel, Pose,
    PositionOf, Real, ScalarOf, Sensor, Symmetric, Vector, Zero,
};
use core::cell::Cell;

/// A sensor at one pose.
#[derive(Debug)]
pub(crate) struct View<'a, X: MeasurementModel> {
    pub(crate) sensor: &'a X::Sensor,
    pub(crate) field_of_view: &'a X::FieldOfView,
    pub(crate) frame: X::Frame,
    /// ln of [`Config::negligible`](crate::Config::negligible).
    pub(crate) ln_negligible: ScalarOf<X::Pose>,
    /// ln N(0; 0, R), an upper bound of ln N(ẑ; ẑ, S) if R is the same for all measurements, because S − R is positive
    /// semidefinite.
    pub(crate) ln_sharpest: ScalarOf<X::Pose>,
    /// Maximum number of components of the birth intensity.
    pub(crate) most_births: usize,
    /// Σ p_D w of the delayed births that this scan [has missed](crate::filter::waiting): they are in no map.
    pub(crate) missed: ScalarOf<X::Pose>,
    /// The last probability of detection with its logarithms. Most features have the same one, except near the edge of the view.
    pub(crate) last_detection: Cell<Detection<ScalarOf<X::Pose>>>,
}

/// Common data of all views of a scan, for any pose.
pub(crate) struct Views<'a, X: MeasurementModel> {
    pub(crate) sensor: &'a X::Sensor,
    pub(crate) field_of_view: &'a X::FieldOfView,
    pub(crate) ln_negligible: ScalarOf<X::Pose>,
    pub(crate) ln_sharpest: ScalarOf<X::Pose>,
    pub(crate) most_births: usize,
}

impl<'a, X: MeasurementModel> Views<'a, X> {
    /// The view from a pose.
    #[inline]
    pub(crate) fn from(&self, pose: &X::Pose) -> View<'a, X> {
        let &Self { sensor, field_of_view, ln_negligible, ln_sharpest, most_births } = self;
        View {
            sensor,
            field_of_view,
            frame: sensor.frame(pose),
            ln_negligible,
            ln_sharpest,
            most_births,
            missed: <ScalarOf<X::Pose> as Zero>::ZERO,
            last_detection: Cell::new(Detection::NONE),
        }
    }
}

/// p_D, but less than 1: with p_D = 1 a missed component would have weight zero, whose logarithm is −∞.
#[inline]
pub(crate) fn below_one<T: Real>(detection: T) -> T {
    detection.at_most(T::ONE - T::EPSILON)
}

/// A probability of detection and its logarithms.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Detection<T> {
    /// p_D.
    pub(crate) probability: T,
    /// p_D of the model, which may be 1.
    pub(crate) modelled: T,
    /// ln p_D.
    pub(crate) ln_detected: T,
    /// ln(1 − p_D).
    pub(crate) ln_missed: T,
}

impl<T: Real> Detection<T> {
    /// Before the first one.
    const NONE: Self = Self { probability: T::ZERO, modelled: T::ZERO, ln_detected: T::ZERO, ln_missed: T::ZERO };

    /// The model's probability and its logarithms.
    pub(crate) fn of(modelled: T) -> Self {
        let probability = below_one(modelled);
        Self { probability, modelled, ln_detected: probability.ln(), ln_missed: (T::ONE - probability).ln() }
    }
}

/// The predicted measurement of a component in view: ẑ, H, S and p_D w.
#[derive(Debug)]
pub(crate) struct Expectation<D: Vector, Z: Vector> {
    /// ẑ.
    measurement: Z,
    /// H.
    jacobian: Linear<Z, D>,
    /// S = H P Hᵀ + R.
    pub(crate) innovation_covariance: Symmetric<Z>,
    /// p_D and its logarithms.
    pub(crate) detection: Detection<Z::Scalar>,
    /// ln(p_D w).
    pub(crate) ln_detected_weight: Z::Scalar,
}

/// The predicted measurement for the models `X`.
pub(crate) type ExpectationOf<X> =
    Expectation<PositionOf<<X as MeasurementModel>::Pose>, <X as MeasurementModel>::Measurement>;

/// A measurement within the gate of a component.
#[derive(Debug)]
pub(crate) struct Match<'f, Z: Vector> {
    /// Its index in the scan.
    pub(crate) index: usize,
    /// z ⊖ ẑ.
    pub(crate) innovation: Z,
    /// The Cholesky factor of the component's S.
    pub(crate) factor: &'f Factor<Z>,
    /// The squared Mahalanobis length vᵀ S⁻¹ v.
    pub(crate) distance: Z::Scalar,
    /// ln( p_D w N(z; ẑ, S) ), the component's term in η_z (4.51).
    pub(crate) ln_term: Z::Scalar,
    /// Reference for its weight while η_z is not complete.
    pub(crate) ln_reference: Z::Scalar,
}

impl<T: Real, D: Vector<Scalar = T>, Z: Vector<Scalar = T>> Expectation<D, Z> {
    /// ẑ and H.
    pub(crate) fn expected(&self) -> Expected<D, Z> {
        Expected { measurement: self.measurement, jacobian: self.jacobian }
    }

    /// The Cholesky factor of S; `None` if S is not positive definite because of rounding.
    pub(crate) fn innovation_factor(&self) -> Option<Factor<Z>> {
        self.innovation_covariance.factor()
    }

    /// Adds an independent covariance of ẑ to S.
    pub(crate) fn blur(&mut self, by: &Symmetric<Z>) {
        self.innovation_covariance = self.innovation_covariance.plus(by);
    }

    /// The Kalman correction of the component, the same for every measurement.
    pub(crate) fn correction<N: Vector<Scalar = T>>(
        &self,
        component: &Component<N>,
        noise: &Symmetric<Z>,
        factor: &Factor<Z>,
    ) -> Correction<N, Z> {
        Correction::new::<D>(&component.covariance, &self.jacobian, noise, factor)
    }
}

impl<T: Real, P: Pose<Scalar = T>, X: MeasurementModel<Pose = P>> View<'_, X> {
    /// The bounding box of the field of view.
    pub(crate) fn bounds(&self) -> Bounds<P::Position> {
        self.field_of_view.bounds(&self.frame)
    }

    /// The components of the sensor's birth intensity that is independent of measurements, with their indices. Components that
    /// are not finite or not positive definite are left out.
    pub(crate) fn expected_births(&self) -> impl Iterator<Item = (usize, Component<P::Position>)> {
        let all = (0..self.most_births).map_while(|index| {
            work::round();
            self.sensor.expected_birth(&self.frame, index).map(|birth| (index, birth))
        });
        all.filter(|(_, birth)| birth.is_usable())
    }

    /// Number of components of that birth intensity, valid or not, and whether it has more than the maximum.
    pub(crate) fn count_births(&self) -> (usize, bool) {
        let is_there = |&index: &usize| {
            work::round();
            self.sensor.expected_birth(&self.frame, index).is_some()
        };
        let count = (0..self.most_births).take_while(is_there).count();
        (count, count == self.most_births && is_there(&count))
    }

    /// Whether the feature at this position, with this measurement, is in view (p_D > 0).
    pub(crate) fn sees(&self, feature: &P::Position, measurement: &X::Measurement) -> bool {
        self.field_of_view.detection_probability(&self.frame, feature, measurement) > T::ZERO
    }

    /// The covariance of a predicted measurement that results from the covariance of the pose.
    pub(crate) fn blur(
        &self,
        pose_covariance: &Symmetric<P::Tangent>,
        feature: &P::Position,
        expected: &ExpectedOf<X::Sensor>,
    ) -> Symmetric<X::Measurement> {
        pose_covariance.congruence::<X::Measurement>(&self.sensor.by_pose(&self.frame, feature, expected))
    }

    /// The predicted measurement of a component; `None` if it is out of view (p_D = 0).
    #[inline(always)]
    pub(crate) fn expect<N: Vector<Scalar = T>>(&self, component: &Component<N>) -> Option<ExpectationOf<X>> {
        let position = component.position::<P::Position>();
        if !self.field_of_view.may_see(&self.frame, &position) {
            return None;
        }
        let expected = self.sensor.expect(&self.frame, &position)?;
        let p_d = self.field_of_view.detection_probability(&self.frame, &position, &expected.measurement);
        // The comparison is written so that NaN counts as out of view.
        if !(p_d > T::ZERO) {
            return None;
        }
        if self.last_detection.get().modelled != p_d {
            self.last_detection.set(Detection::of(p_d));
        }
        let detection = self.last_detection.get();
        let position_covariance = component.covariance.leading::<P::Position>();
        Some(Expectation {
            measurement: expected.measurement,
            jacobian: expected.jacobian,
            detection,
            ln_detected_weight: component.ln_weight + detection.ln_detected,
            innovation_covariance: position_covariance
                .congruence::<X::Measurement>(&expected.jacobian)
                .plus(&noise_at(self.sensor, &expected.measurement)),
        })
    }

    /// The predicted measurement with the covariance of the pose. Not inlined, because it is not called in the loop over all
    /// candidates' components.
    #[inline(never)]
    pub(crate) fn expect_blurred<N: Vector<Scalar = T>>(
        &self,
        pose_covariance: Option<&Symmetric<P::Tangent>>,
        component: &Component<N>,
    ) -> Option<ExpectationOf<X>> {
        let mut expectation = self.expect(component)?;
        if let Some(pose_covariance) = pose_covariance {
            expectation.blur(&self.blur(pose_covariance, &component.position(), &expectation.expected()));
        }
        Some(expectation)
    }

    /// Calls `found` for every measurement whose term in η_z is not negligible, in the order of the scan; across ±π, the
    /// measurements before the cut come first.
    ///
    /// A term counts if it is above `negligible` times the measurement's intensity without features. This bounds the squared
    /// distance vᵀ S⁻¹ v, which bounds the difference of the sorting coordinates.
    #[inline(always)]
    pub(crate) fn matches(
        &self,
        expectation: &ExpectationOf<X>,
        scan: &Scan<'_, X::Measurement>,
        mut found: impl FnMut(Match<'_, X::Measurement>),
    ) {
        let ln_least = scan.ln_least_unexplained() + self.ln_negligible;
        // The exact peak needs a factorisation and a logarithm, which components without a measurement nearby do not need. The
        // constant in the last term exceeds rounding errors.
        let own = OwnNoise::of(self.sensor, &expectation.measurement, &expectation.measurement);
        let ln_sharpest = own.map_or(self.ln_sharpest, |own| own.factor.ln_peak());
        let headroom = expectation.ln_detected_weight + ln_sharpest - ln_least + T::from_f64(0.001);
        // The comparison is written so that NaN returns too.
        if !(headroom > T::ZERO) {
            return;
        }
        let farthest = headroom + headroom;
        let covariance = &expectation.innovation_covariance;
        // vᵀ S⁻¹ v is at least v_k²/S_kk for every coordinate k.
        let farthest_along = X::Measurement::with(|k| farthest * covariance.get(k, k));
        let reach = farthest_along.at(X::Sensor::SORTED_BY).sqrt_above();
        let mut sharpness = None;
        const {
            assert!(
                X::Sensor::SORTED_BY < X::Measurement::DIMENSION,
                "SORTED_BY must be a coordinate of the measurement"
            );
            assert!(
                match X::Sensor::SIFTED_BY {
                    Some(k) => k < X::Measurement::DIMENSION && k != X::Sensor::SORTED_BY,
                    None => true,
                },
                "SIFTED_BY must be a coordinate of the measurement, and another one than SORTED_BY"
            );
        }
        let sifted_by = X::Sensor::SIFTED_BY.map(|k| (k, expectation.measurement.at(k), farthest_along.at(k)));
        scan.near::<X::Sensor>(&expectation.measurement, reach, |(index, measured)| {
            if let Some((k, expected, farthest)) = sifted_by {
                let apart = measured.z.at(k) - expected;
                if apart * apart > farthest {
                    return;
                }
            }
            let innovation = self.sensor.innovation(&measured.z, &expectation.measurement);
            let too_far = |(_, (&along, &farthest)): (usize, (&T, &T))| along * along > farthest;
            let mut coordinates = innovation.as_slice().iter().zip(farthest_along.as_slice()).enumerate();
            // The sorting coordinate comes last: most measurements that the index returns satisfy its bound.
            if coordinates
                .clone()
                .filter(|&(k, _)| k != X::Sensor::SORTED_BY && Some(k) != X::Sensor::SIFTED_BY)
                .any(too_far)
                || coordinates.nth(X::Sensor::SORTED_BY).is_some_and(too_far)
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

impl<'f, T: Real, Z: Vector<Scalar = T>> Match<'f, Z> {
    /// A measurement near the predicted one; `None` if S is not positive definite because of rounding. Inlined into the loop over
    /// the measurements: four of five get here, and a call would pass all values through memory.
    #[inline(always)]
    fn of(
        index: usize,
        innovation: Z,
        covariance: Symmetric<Z>,
        ln_detected_weight: T,
        ln_reference: T,
        sharpness: &'f mut Option<(T, Factor<Z>)>,
    ) -> Option<Self> {
        // Values that do not depend on the measurement are stored for the component's next measurement.
        if sharpness.is_none() {
            *sharpness = covariance.factor().map(|factor| (ln_detected_weight + factor.ln_peak(), factor));
        }
        let (ln_peak, factor) = sharpness.as_ref()?;
        let distance = factor.mahalanobis(&innovation);
        let ln_term = *ln_peak - T::from_f64(0.5) * distance;
        Some(Self { index, innovation, factor, distance, ln_term, ln_reference })
    }
}
