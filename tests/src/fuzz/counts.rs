//! What the operations came to: how often each was done, and how often it was refused for what reason.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Debug;

/// How often an operation came to this, by its name and the outcome: `ok`, or the name of the refusal.
pub type Counts = BTreeMap<(&'static str, String), u64>;

thread_local! {
    static COUNTS: RefCell<Counts> = const { RefCell::new(Counts::new()) };
}

/// Counts an operation and what came of it, on this thread.
pub(super) fn count<R, E: Debug>(operation: &'static str, outcome: &Result<R, E>) {
    let came_to = match outcome {
        Ok(_) => "ok".into(),
        Err(error) => named(error),
    };
    COUNTS.with_borrow_mut(|counts| *counts.entry((operation, came_to)).or_default() += 1);
}

/// What has been counted on this thread since the last time.
pub fn take() -> Counts {
    COUNTS.take()
}

/// The variant of an error, with those in it: `Model(ModelError)`. Numbers and texts are left out.
fn named(error: &impl Debug) -> String {
    let text = format!("{error:?}");
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '(')).unwrap_or(text.len());
    text[..end].trim_end_matches('(').replace('(', " ").trim_end_matches(|c: char| c.is_ascii_digit()).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::{count, take};
    use scphd::errors::{Implausible, PredictError, ScanError};

    #[test]
    fn outcomes_are_told_apart_by_their_names() {
        take();
        count::<(), _>("predict", &Err(PredictError::Implausible(Implausible::Step)));
        count::<(), _>("scan", &Err(ScanError::TooManyMeasurements { measurements: 9, capacity: 8 }));
        for _ in 0..3 {
            count::<(), PredictError>("predict", &Ok(()));
        }
        let counted: Vec<_> = take().into_iter().map(|((what, to), times)| format!("{what} {to} {times}")).collect();
        assert_eq!(counted, ["predict Implausible Step 1", "predict ok 3", "scan TooManyMeasurements 1"]);
        assert!(take().is_empty());
    }
}
