//! Output of a run on disk and on the terminal: CSV rows and tables.

pub mod comparison;
pub mod csv;
pub mod difference;
pub mod overview;
pub mod repeats;
pub mod studies;
pub mod table;
pub mod tuning;
