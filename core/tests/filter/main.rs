//! The whole filter, by what a user of the library sees of it. What needs a look at its memory or at private steps stands in
//! `src/tests`.

#[path = "../../src/tests/alone.rs"]
mod alone;
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

// For `crate::*`, by which tests in the library say the same.
use scphd::diagnostics::*;
use scphd::errors::*;
use scphd::models::*;
use scphd::numerics::*;
use scphd::settings::*;
use scphd::snapshot::*;
use scphd::storage::*;
use scphd::*;
