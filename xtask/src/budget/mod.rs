//! t
use crate::steps::Outcome;
pub fn step() -> Outcome {
    Outcome::Passed(String::new())
}
