//! The divergence monitor in a snapshot. It is not part of the digest, because it is not part of the estimate.

use crate::Real;
use crate::report::watch::Watch;
use crate::snapshot::read::Reader;
use crate::snapshot::visit::Visit;

impl<T: Real> Watch<T> {
    /// Visits its state.
    pub(crate) fn walk(&self, visit: &mut impl Visit) {
        let Self { cusum, lost, existence_loss, usually_missed, usually_new, usually_stated, usually_waited_s, .. } =
            *self;
        for word in [u32::from(lost), self.scans, self.known_below, self.next_known_below] {
            visit.snapshot_word(word);
        }
        for number in [cusum, existence_loss, usually_missed, usually_new, usually_stated, usually_waited_s] {
            visit.snapshot_scalar(number);
        }
    }

    /// Restores its state. The next scan removes invalid values.
    pub(crate) fn next<S: FnMut(usize, &mut [u8]) -> Result<(), E>, E>(from: &mut Reader<'_, S, E>) -> Self {
        let [lost, scans, known_below, next_known_below] = core::array::from_fn(|_| from.word());
        let [cusum, existence_loss, usually_missed, usually_new, usually_stated, usually_waited_s] =
            core::array::from_fn(|_| from.scalar());
        let lost = lost != 0;
        Self {
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
        }
    }
}
