//! Search for pose hypotheses: two landmarks of the vehicle's own map are aligned with every two landmarks of the known map
//! that have the same distance.

use super::alignment::{Alignment, Landmark};
use super::config::LocatorConfig;
use super::state::{Hypothesis, Memory, Sweep};
use crate::{MeasurementModel, PlanarPose, Real};

/// Two landmarks determine a direction if their distance is above this number of standard deviations.
const FARTHER_THAN: f64 = 6.0;

impl<T: Real> Memory<'_, T> {
    /// Continues the search: makes at most `config.trials` trial alignments, and compares at most twice as many distances as the
    /// known map has ordered pairs. Returns the number of trial alignments.
    pub(super) fn search<X: MeasurementModel<Pose = PlanarPose<T>>>(
        &mut self,
        config: &LocatorConfig<T>,
        models: &X,
    ) -> usize {
        let (maps, mut trials) = (self.known.map, 0);
        if maps < 3 || self.known.seen < 3 {
            return 0;
        }
        let all = maps * maps;
        for _ in 0..2 * all {
            if trials == config.trials {
                break;
            }
            if !self.known.sweep.under_way && !self.next_pair(config.inflation) {
                break;
            }
            let Sweep { pair, next, .. } = self.known.sweep;
            let (first, second) = (self.map.get(next / maps).copied(), self.map.get(next % maps).copied());
            if let (Some(first), Some(second)) = (first, second)
                && next / maps != next % maps
                && is_as_long(config, &pair, &first, &second)
            {
                trials += 1;
                self.try_pair(config, models, &pair, &[first, second]);
            }
            let sweep = &mut self.known.sweep;
            sweep.next += 1;
            if sweep.next >= all {
                sweep.under_way = false;
                sweep.done = sweep.done.saturating_add(1);
            }
        }
        trials
    }

    /// Selects the next two landmarks of the vehicle's own map that are far enough apart; `false` if there are none. Cycles through
    /// all pairs, beginning with neighbours in the list.
    fn next_pair(&mut self, inflation: T) -> bool {
        let seen = self.known.seen;
        if seen < 2 {
            return false;
        }
        for _ in 0..seen * (seen - 1) {
            let turn = self.known.sweep.turn;
            self.known.sweep.turn = (turn + 1) % (seen * (seen - 1));
            let (one, apart) = (turn % seen, 1 + turn / seen % (seen - 1));
            let (Some(a), Some(b)) = (self.seen.get(one), self.seen.get((one + apart) % seen)) else { continue };
            let along = b.mean - a.mean;
            let traces = [a, b].map(|of| of.covariance.get(0, 0) + of.covariance.get(1, 1));
            let least = (traces[0] + traces[1]) * inflation * T::from_f64(FARTHER_THAN * FARTHER_THAN);
            if along.dot(&along) > least {
                self.known.sweep = Sweep { under_way: true, pair: [*a, *b], next: 0, ..self.known.sweep };
                return true;
            }
        }
        false
    }

    /// Aligns a pair with one of the known map, and keeps the hypothesis if three landmarks match.
    fn try_pair<X: MeasurementModel<Pose = PlanarPose<T>>>(
        &mut self,
        config: &LocatorConfig<T>,
        models: &X,
        [a, b]: &[Landmark<T>; 2],
        [first, second]: &[Landmark<T>; 2],
    ) {
        let alignment = Alignment::of_lines([&a.mean, &b.mean], [&first.mean, &second.mean]);
        let Some(alignment) = alignment.fitted(config.inflation, [(a, first), (b, second)].into_iter()) else { return };
        // A stored hypothesis is not evaluated again here.
        let same = |hypothesis: &Hypothesis<T>| hypothesis.alignment.is_same(&alignment, T::ONE);
        if self.hypotheses().iter().any(same) {
            return;
        }
        if let Some(hypothesis) = self.weigh(config, models, &alignment) {
            self.keep(config, &hypothesis);
        }
    }

    /// Stores a hypothesis. It replaces an equal one, or the least probable one if the memory is full, if these are less probable.
    pub(super) fn keep(&mut self, config: &LocatorConfig<T>, new: &Hypothesis<T>) {
        let len = self.known.hypotheses;
        let held = self.hypotheses.get_mut(..len).unwrap_or(&mut []);
        if let Some(same) = held.iter_mut().find(|held| held.alignment.is_same(&new.alignment, config.gate)) {
            if new.ln_weight > same.ln_weight {
                *same = *new;
            }
            return;
        }
        if let Some(slot) = self.hypotheses.get_mut(len) {
            *slot = *new;
            self.known.hypotheses += 1;
            return;
        }
        let least = self.hypotheses.iter_mut().reduce(|a, b| if b.ln_weight < a.ln_weight { b } else { a });
        if let Some(least) = least.filter(|least| least.ln_weight < new.ln_weight) {
            *least = *new;
        }
    }
}

/// Whether the distance of two landmarks of the known map equals that of the pair, within the covariances of all four.
fn is_as_long<T: Real>(
    config: &LocatorConfig<T>,
    pair: &[Landmark<T>; 2],
    first: &Landmark<T>,
    second: &Landmark<T>,
) -> bool {
    let [a, b] = pair;
    let [squared_seen, squared_map] = [b.mean - a.mean, second.mean - first.mean].map(|along| along.dot(&along));
    let traces = [a, b, first, second].map(|of| of.covariance.get(0, 0) + of.covariance.get(1, 1));
    let variance = traces.iter().fold(T::ZERO, |sum, &trace| sum + trace) * config.inflation;
    // (|a| − |b|)² = a² + b² − 2 |a| |b|.
    let two = T::ONE + T::ONE;
    let difference = squared_seen + squared_map - two * (squared_seen * squared_map).sqrt();
    difference <= variance * config.gate * T::from_f64(0.5)
}

#[cfg(test)]
mod tests {
    use crate::Symmetric;
    use crate::locate::state::LocatorState;
    use nalgebra::Vector2;

    /// With standard deviations of 0.1 m, two landmarks 0.1 m apart do not determine a direction, and two 3 m apart do.
    #[test]
    fn only_landmarks_that_are_apart_are_laid() {
        for (apart, tells) in [(0.1, false), (3.0, true)] {
            let mut state = LocatorState::<f64, 4, 2>::new();
            let mut memory = state.memory();
            memory.known.seen = 2;
            for (landmark, offset) in memory.seen.iter_mut().zip([0.0, apart]) {
                landmark.mean = Vector2::new(-40.0, 30.0 + offset);
                landmark.covariance = Symmetric::from_diagonal([0.01; 2]);
            }
            assert_eq!(memory.next_pair(1.0), tells, "{apart} m");
        }
    }
}
