//! The example comes to its end.

#[allow(dead_code, reason = "what is printed is not looked at")]
#[path = "../examples/black_box.rs"]
mod black_box;

#[test]
fn what_is_left_of_a_black_box_ends_in_the_robots_states() {
    black_box::run().unwrap();
}
