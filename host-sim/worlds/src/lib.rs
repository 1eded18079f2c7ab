//! Simulated scenarios and random worlds, in the plane and under water.

/// The struct of the errors in a world.
macro_rules! switches {
    ($($(#[$about:meta])* $name:ident,)+) => {
        /// The errors in a world, each with its own switch.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub struct Misbehaviour { $($(#[$about])* pub $name: bool,)+ }

        impl Misbehaviour {
            pub const ALL: Self = Self { $($name: true,)+ };
            pub const NONE: Self = Self { $($name: false,)+ };
        }
    };
}
pub(crate) use switches;

pub mod scenario;
pub mod underwater;
