//! Finding places: closed forms, maps that look alike, and many drives.

mod alike;
mod closed;
mod trials;
mod world;
