//! Tables, plots and pages of runs.

pub mod difference;
pub mod figure;
mod meaning;
pub mod output;
pub mod plot;
pub mod report;
