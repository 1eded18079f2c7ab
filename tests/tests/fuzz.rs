//! Two million operations with plausible and with hostile numbers. Twenty million: `cargo run --release -p scphd-tests --bin fuzz --
//! 20000000 1`.

use scphd_tests::fuzz;

/// Operations, those of the sessions from the first seed on.
const OPERATIONS: u64 = 2_000_000;

#[test]
fn whatever_is_asked_of_a_filter_it_stays_sound() {
    if let Err(failed) = fuzz::run(OPERATIONS, 1, &mut |_| ()) {
        panic!("{failed}");
    }
}
