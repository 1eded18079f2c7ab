//! Probes, which observe the stages of a step from outside.

/// The stages of the recursion, in the order of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Stage {
    /// Prediction of the vehicle and of the moving features (5.12–5.14).
    Predict,
    /// Weighting of every candidate (4.52); if there is only one, the update computes its weight.
    Weigh,
    /// Resampling to one candidate per particle (5.2.2).
    Resample,
    /// Update of the survivors' maps (5.17–5.22).
    Update,
    /// Pruning and merging of components (5.2.6), on the calling core.
    Reduce,
}

impl Stage {
    /// All stages.
    pub const ALL: [Self; 5] = [Self::Predict, Self::Weigh, Self::Resample, Self::Update, Self::Reduce];
}

/// Is called when a stage begins and when it ends. A stage within another one (reduction, within the update) ends before it.
///
/// A probe has no effect on the state of the filter. `()` does nothing.
pub trait Probe {
    /// Called at the begin of a stage.
    fn enter(&mut self, stage: Stage);
    /// Called at the end of a stage.
    fn leave(&mut self, stage: Stage);
}

impl Probe for () {
    #[inline]
    fn enter(&mut self, _stage: Stage) {}
    #[inline]
    fn leave(&mut self, _stage: Stage) {}
}

impl<Q: Probe + ?Sized> Probe for &mut Q {
    #[inline]
    fn enter(&mut self, stage: Stage) {
        (**self).enter(stage);
    }
    #[inline]
    fn leave(&mut self, stage: Stage) {
        (**self).leave(stage);
    }
}

/// Two probes, called one after the other.
impl<A: Probe, B: Probe> Probe for (A, B) {
    #[inline]
    fn enter(&mut self, stage: Stage) {
        self.0.enter(stage);
        self.1.enter(stage);
    }
    #[inline]
    fn leave(&mut self, stage: Stage) {
        self.0.leave(stage);
        self.1.leave(stage);
    }
}

/// Shows the stages on output pins, for a logic analyser: the pin of a stage is high during the stage.
///
/// Errors of the pins are counted and otherwise ignored, because they must not stop the filter.
#[cfg(feature = "embedded-hal")]
#[derive(Debug)]
pub struct StagePins<P> {
    pins: [P; 5],
    refused: u32,
}

#[cfg(feature = "embedded-hal")]
impl<P: embedded_hal::digital::OutputPin> StagePins<P> {
    /// A probe with the pins of predict, weight, resample, update and reduce, in this order; all are set low.
    pub fn new(pins: [P; 5]) -> Self {
        let mut probe = Self { pins, refused: 0 };
        Stage::ALL.into_iter().for_each(|stage| probe.leave(stage));
        probe
    }

    /// Number of pin errors.
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// Returns the pins.
    pub fn release(self) -> [P; 5] {
        self.pins
    }

    fn set(&mut self, stage: Stage, high: bool) {
        let [predict, weigh, resample, update, reduce] = &mut self.pins;
        let pin = match stage {
            Stage::Predict => predict,
            Stage::Weigh => weigh,
            Stage::Resample => resample,
            Stage::Update => update,
            Stage::Reduce => reduce,
        };
        if pin.set_state(high.into()).is_err() {
            self.refused = self.refused.saturating_add(1);
        }
    }
}

#[cfg(feature = "embedded-hal")]
impl<P: embedded_hal::digital::OutputPin> Probe for StagePins<P> {
    fn enter(&mut self, stage: Stage) {
        self.set(stage, true);
    }

    fn leave(&mut self, stage: Stage) {
        self.set(stage, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[derive(Default)]
    struct Listener(Vec<(Stage, bool)>);

    impl Probe for Listener {
        fn enter(&mut self, stage: Stage) {
            self.0.push((stage, true));
        }

        fn leave(&mut self, stage: Stage) {
            self.0.push((stage, false));
        }
    }

    #[test]
    fn both_probes_of_a_pair_are_called() {
        let (mut first, mut second) = (Listener::default(), Listener::default());
        let mut pair = (&mut first, &mut second);
        pair.enter(Stage::Weigh);
        pair.leave(Stage::Weigh);
        assert_eq!(first.0, [(Stage::Weigh, true), (Stage::Weigh, false)]);
        assert_eq!(first.0, second.0);
    }

    #[cfg(feature = "embedded-hal")]
    #[test]
    fn a_stage_sets_its_own_pin() {
        use embedded_hal_mock::eh1::MockError;
        use embedded_hal_mock::eh1::digital::{Mock, State, Transaction};
        use std::io::ErrorKind;

        let low = || Transaction::set(State::Low);
        let high = || Transaction::set(State::High);
        let refused = high().with_error(MockError::Io(ErrorKind::NotConnected));
        let mut probe = StagePins::new([
            Mock::new(&[low()]),
            Mock::new(&[low(), high(), low()]),
            Mock::new(&[low(), refused, low()]),
            Mock::new(&[low(), high(), low()]),
            Mock::new(&[low(), high(), low(), high(), low()]),
        ]);
        for stage in [Stage::Weigh, Stage::Resample] {
            probe.enter(stage);
            probe.leave(stage);
        }
        probe.enter(Stage::Update);
        for _ in 0..2 {
            probe.enter(Stage::Reduce);
            probe.leave(Stage::Reduce);
        }
        probe.leave(Stage::Update);
        assert_eq!(probe.refused(), 1);
        probe.release().iter_mut().for_each(Mock::done);
    }
}
