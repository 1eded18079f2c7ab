//! Fault injection into the divergence monitor.

use super::watch::Watch;
use crate::numerics::flip::{Each, Word};

impl Watch<f32> {
    pub(crate) fn words(&mut self, each: &mut Each<'_>) {
        let Self {
            cusum,
            lost,
            existence_loss,
            usually_missed,
            usually_new,
            usually_stated,
            usually_waited_s,
            scans,
            known_below,
            next_known_below,
        } = self;
        for number in [cusum, existence_loss, usually_missed, usually_new, usually_stated, usually_waited_s] {
            each("watch", Word::Real(number));
        }
        each("watch", Word::Truth(lost));
        [scans, known_below, next_known_below].into_iter().for_each(|word| each("watch", Word::Long(word)));
    }
}
