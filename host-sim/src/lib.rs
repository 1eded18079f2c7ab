//! Simulator, replayer and full-precision reference for the `scphd` SLAM filter.
//!
//! What depends on what, each on those above it; but that runs write their summaries with [`output::json`], and that the settings of an
//! underwater vehicle have parts of [`settings`]:
//!
//! | modules | |
//! |---|---|
//! | [`angle`], [`dimensions`], [`noise`], [`threads`] | numbers |
//! | [`score`], [`record`], [`film`] | what a run leaves behind, and how good that is |
//! | [`log`], [`events`], [`vehicle`], [`underwater`], [`scenario`], [`log_folder`] | logs and scenarios |
//! | [`settings`], [`mod@reference`] | what a run is tuned with; the recursion in full precision |
//! | [`ekf`], [`slam`], [`kind`], [`truth`] | filters, and what a kind of vehicle supplies for a run |
//! | [`session`], [`tally`], [`compare`], [`tune`], [`monte_carlo`], [`stream`] | runs, once for every kind |
//! | [`output`], [`plot`], [`figure`], [`point_process`] | tables and pictures |
//! | [`mod@check`], [`mod@report`], [`exchange`] | whether a log says what its author means; a run as a page, and as files of others |
//! | [`difference`] | two runs beside each other |
//!
//! The program itself is in `cli`: a command is dispatched on the kind of vehicle in one place.

pub mod angle;
pub mod calendar;
pub mod check;
pub mod compare;
pub mod difference;
pub mod dimensions;
pub mod ekf;
pub mod events;
pub mod exchange;
pub mod figure;
pub mod film;
pub mod hil;
pub mod kind;
mod lines;
pub mod log;
pub mod log_folder;
mod meaning;
pub mod monte_carlo;
pub mod noise;
pub mod output;
pub mod plot;
pub mod point_process;
pub mod record;
pub mod reference;
pub mod report;
pub mod scenario;
pub mod score;
pub mod session;
pub mod settings;
pub mod slam;
pub mod stream;
pub mod tally;
pub mod threads;
pub mod truth;
pub mod tune;
pub mod underwater;
pub mod vehicle;

#[cfg(test)]
mod shared_data;
