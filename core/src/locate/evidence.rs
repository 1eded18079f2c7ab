//! The likelihood of a pose in the map, relative to the hypothesis that the vehicle is elsewhere.

use super::alignment::Alignment;
use super::config::LocatorConfig;
use super::state::{Hypothesis, Memory, NONE};
use crate::{Bounds, FieldOfView, MeasurementModel, PlanarPose, Real, Sensor};
use nalgebra::Vector2;

/// Iterations of least squares for a hypothesis; landmarks are associated anew before each.
const STEPS: usize = 2;
/// Least probability that a landmark of the vehicle would be found, because the model of the view is not exact.
const LEAST_FOUND: f64 = 0.1;
/// Cells of the grid over the observed area, along each side.
const SQUARES: usize = 16;
/// Side of the area of poses divided by that of the landmarks: a quarter more on each side.
const POSES: f64 = 2.25;

impl<T: Real> Memory<'_, T> {
    /// The alignment with the best fit and its log evidence; `None` with fewer than three associated landmarks.
    pub(super) fn weigh<X: MeasurementModel<Pose = PlanarPose<T>>>(
        &mut self,
        config: &LocatorConfig<T>,
        models: &X,
        alignment: &Alignment<T>,
    ) -> Option<Hypothesis<T>> {
        let mut alignment = *alignment;
        for _ in 0..STEPS {
            if self.pair_up(&alignment, config.inflation, config.gate) < 3 {
                return None;
            }
            alignment = alignment.fitted(config.inflation, self.paired())?;
        }
        let matched = self.pair_up(&alignment, config.inflation, config.gate);
        if matched < 3 {
            return None;
        }
        let ln_weight = self.ln_prior(config, &alignment)? + self.ln_likelihood(config, models, &alignment)?;
        ln_weight.is_finite().then_some(Hypothesis { alignment, ln_weight, matched })
    }

    /// Logarithm of the prior density times the volume of the alignment's covariance, p(x) (2π)^{3/2} |Σ|^{1/2}.
    fn ln_prior(&self, config: &LocatorConfig<T>, alignment: &Alignment<T>) -> Option<T> {
        let real = T::from_f64;
        let ln_volume = -alignment.covariance.factor()?.ln_peak();
        let poses = self.known.area * real(POSES) * (T::PI + T::PI);
        Some((T::ONE - config.elsewhere).ln() - poses.ln() + ln_volume)
    }

    /// Log likelihood ratio against the hypothesis "elsewhere": of all landmarks of the vehicle, and of the map's that it did not find.
    fn ln_likelihood<X: MeasurementModel<Pose = PlanarPose<T>>>(
        &mut self,
        config: &LocatorConfig<T>,
        models: &X,
        alignment: &Alignment<T>,
    ) -> Option<T> {
        let turned = alignment.turned();
        let density = self.density();
        let ln_density = density.ln();
        let ln_new = config.new_share.ln();
        let mut sum = T::ZERO;
        for place in 0..self.known.map {
            let Some(of_map) = self.map.get(place).copied() else { break };
            let remains = (config.remains * of_map.ln_weight.exp()).at_most(config.remains);
            let found = self.found(models, &turned.of(&of_map.mean));
            let ln_missed = (T::ONE - remains * found).ln();
            let landmark = self.pairs.iter().take(self.known.seen).position(|&pair| usize::from(pair) == place + 1);
            let Some(landmark) = landmark.and_then(|landmark| self.seen.get(landmark)) else {
                sum += ln_missed;
                continue;
            };
            let factor = turned.relative_covariance(landmark, &of_map).scaled(config.inflation).factor()?;
            let off = landmark.mean - turned.of(&of_map.mean);
            let ln_there = factor.ln_peak() - factor.mahalanobis(&off) * T::from_f64(0.5);
            let found = found.at_least(T::from_f64(LEAST_FOUND));
            let ln_same = (remains * found).ln() + ln_there - ln_density;
            // Landmarks near each other are not always the same one.
            sum += ln_same.at_least(ln_missed + ln_new);
        }
        let new = self.pairs.iter().take(self.known.seen).filter(|&&pair| pair == NONE).count();
        // Under "elsewhere" all landmarks are new.
        let fewer_new = density * (T::ONE - config.new_share) * self.known.observed_area;
        Some(sum + T::from_usize(new) * ln_new + fewer_new)
    }

    /// Density of landmarks, 1/m²: that of the map or of the observed area, whichever is greater, because other places may be as dense.
    pub(super) fn density(&self) -> T {
        let of_map = T::from_usize(self.known.map) / self.known.area;
        of_map.at_least(T::from_usize(self.known.seen) / self.known.observed_area)
    }

    /// The area in which the vehicle would have found landmarks, m², summed over the cells of a grid.
    pub(super) fn observed_area<X: MeasurementModel<Pose = PlanarPose<T>>>(&self, models: &X) -> T {
        let sensor = models.sensor();
        let mut bounds = Bounds::<Vector2<T>>::EMPTY;
        for view in self.known.views.all() {
            let box_of_view = models.field_of_view().bounds(&sensor.frame(&view.pose));
            bounds.include(&box_of_view.low);
            bounds.include(&box_of_view.high);
        }
        let step = (bounds.high - bounds.low) * (T::ONE / T::from_usize(SQUARES));
        let half = T::from_f64(0.5);
        let mut found = T::ZERO;
        for row in 0..SQUARES {
            for column in 0..SQUARES {
                let (x, y) = (T::from_usize(column) + half, T::from_usize(row) + half);
                found += self.found(models, &(bounds.low + Vector2::new(x * step.x, y * step.y)));
            }
        }
        let area = found * step.x * step.y;
        // An unbounded view, or no scan yet.
        if area.is_finite() { area } else { T::ZERO }
    }

    /// The probability that a landmark at this place was found, which takes two detections.
    fn found<X: MeasurementModel<Pose = PlanarPose<T>>>(&self, models: &X, place: &Vector2<T>) -> T {
        let (mut ln_never, mut odds) = (T::ZERO, T::ZERO);
        let sensor = models.sensor();
        for view in self.known.views.all() {
            let frame = sensor.frame(&view.pose);
            if !models.field_of_view().bounds(&frame).holds(place) {
                continue;
            }
            let Some(expected) = sensor.expect(&frame, place) else { continue };
            let detection = models.field_of_view().detection_probability(&frame, place, &expected.measurement);
            // Written so that NaN is out of view.
            if detection > T::ZERO {
                let detection = detection.at_most(T::ONE - T::EPSILON);
                ln_never += view.scans * (T::ONE - detection).ln();
                odds += view.scans * detection / (T::ONE - detection);
            }
        }
        (T::ONE - ln_never.exp() * (T::ONE + odds)).at_least(T::ZERO)
    }
}

/// The area of a box. If it is degenerate, its width is taken as a tenth of its length.
pub(super) fn area<T: Real>(of: &Bounds<Vector2<T>>) -> T {
    let sides = of.high - of.low;
    let least = sides.x.at_least(sides.y) * T::from_f64(0.1);
    sides.x.at_least(least) * sides.y.at_least(least)
}

#[cfg(test)]
mod tests {
    use super::{Alignment, LocatorConfig, POSES};
    use crate::locate::state::LocatorState;
    use crate::{PlanarPose, Pose, Symmetric};
    use core::f64::consts::TAU;

    /// The prior is uniform over the area and over a turn; the volume of a Gaussian is (2π)^{3/2} |Σ|^{1/2}.
    #[test]
    fn prior_is_the_share_of_the_poses_that_a_laying_stands_for() {
        let mut state = LocatorState::<f64, 4, 2>::new();
        let memory = state.memory();
        memory.known.area = 400.0;
        let (config, sigmas) = (LocatorConfig::default(), [0.2, 0.3, 0.05]);
        let covariance = Symmetric::from_diagonal(sigmas.map(|sigma| sigma * sigma));
        let prior = memory.ln_prior(&config, &Alignment { at: PlanarPose::ZERO, covariance }).unwrap().exp();
        let volume = TAU.powf(1.5) * sigmas.iter().product::<f64>();
        let expected = (1.0 - config.elsewhere) * volume / (400.0 * POSES * TAU);
        assert!((prior / expected - 1.0).abs() < 1e-12, "{prior} {expected}");
    }
}
