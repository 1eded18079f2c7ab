//! The whole filter, by what a user of the library sees of it. What needs a look at its memory or at private steps stands in
//! `src/tests`. All in one program: filters are compiled anew for each.

#[path = "../../src/tests/alone.rs"]
mod alone;
#[path = "../calibrating.rs"]
mod calibrating;
#[path = "../choosing.rs"]
mod choosing;
#[path = "../config_names.rs"]
mod config_names;
#[path = "../hostile.rs"]
mod hostile;
mod in_space;
mod informed;
#[path = "../../src/tests/linear.rs"]
mod linear;
mod movers;
mod observing;
mod oracles;
mod peaks;
mod short_steps;
mod standing;
mod unconfirmed;
#[path = "../varying_noise.rs"]
mod varying_noise;

// For `crate::*`, by which tests in the library say the same.
use scphd::diagnostics::*;
use scphd::errors::*;
use scphd::models::*;
use scphd::numerics::*;
use scphd::settings::*;
use scphd::snapshot::*;
use scphd::storage::*;
use scphd::*;
