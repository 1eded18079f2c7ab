//! The example runs to its end.

#[allow(dead_code, reason = "what is printed is not looked at")]
#[path = "../examples/black_box.rs"]
mod black_box;

#[test]
fn an_incomplete_black_box_ends_in_the_states_of_the_robot() {
    black_box::run().unwrap();
}
