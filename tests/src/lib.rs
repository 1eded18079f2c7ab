//! Checks that cross crate borders; the tests themselves are in `tests/`.
