//! Counts of operations by outcome: success, or the reason of the refusal.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Debug;

/// Number of occurrences of an operation with an outcome: `ok`, or the name of the error.
pub type Counts = BTreeMap<(&'static str, String), u64>;

thread_local! {
    static COUNTS: RefCell<Counts> = const { RefCell::new(Counts::new()) };
}

/// Counts an operation with its outcome, on this thread.
pub(super) fn count<R, E: Debug>(operation: &'static str, outcome: &Result<R, E>) {
    let came_to = match outcome {
        Ok(_) => "ok".into(),
        Err(error) => named(error),
    };
    COUNTS.with_borrow_mut(|counts| *counts.entry((operation, came_to)).or_default() += 1);
}

/// Returns and clears the counts of this thread.
pub fn take() -> Counts {
    COUNTS.take()
}

/// The variant of an error with nested variants, such as `Model(ModelError)`, without numbers and texts.
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
    fn outcomes_are_distinguished_by_their_names() {
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
