//! The static memory of a filter, with its capacities by name.

use crate::{Description, Slam, StartError};
use nalgebra::{Vector1, Vector2};
use scphd::{DetectorMemory, Real};

/// The memory of a filter: all zero when it is new.
pub trait Backing<T: Real> {
    /// The filter over it.
    type Slam<'m>: Slam<T>
    where
        Self: 'm;

    /// Assembles the filter that is described. The memory keeps what it holds: reset a fresh one first.
    ///
    /// # Errors
    /// The description is out of range, or of a filter that this is no memory of.
    fn start(&mut self, description: &Description<T>) -> Result<Self::Slam<'_>, StartError>;
}

/// The scratch of a mixture's scans, which all of its sensors share.
#[derive(Debug)]
pub struct Rooms<T: Real, const MEASUREMENTS: usize> {
    pub(crate) polar: DetectorMemory<Vector2<T>, MEASUREMENTS>,
    pub(crate) direction: DetectorMemory<Vector1<T>, MEASUREMENTS>,
}

impl<T: Real, const MEASUREMENTS: usize> Rooms<T, MEASUREMENTS> {
    /// Empty ones.
    #[must_use]
    pub const fn new() -> Self {
        Self { polar: DetectorMemory::new(), direction: DetectorMemory::new() }
    }
}

impl<T: Real, const MEASUREMENTS: usize> Default for Rooms<T, MEASUREMENTS> {
    fn default() -> Self {
        Self::new()
    }
}

/// Names the memory of a joint map. The pose is `PlanarPose`, or `CalibratedPose` where the odometry is learnt; movers and an archive have
/// room where their numbers are not 0.
///
/// ```
/// use scphd_vehicle::{Backing, Description, joint_backing};
///
/// joint_backing! {
///     /// Of a robot among people.
///     pub struct Robot: PlanarPose<f32> { features: 50, measurements: 16, movers: 8, archived: 0 }
/// }
/// let mut memory = Box::new(Robot::new());
/// assert!(memory.start(&Description::robot()).is_ok());
/// ```
#[macro_export]
macro_rules! joint_backing {
    ($(#[$about:meta])* $public:vis struct $name:ident: $pose:ident<$scalar:ty> {
        features: $features:expr, measurements: $measurements:expr, movers: $movers:expr, archived: $archived:expr $(,)?
    }) => {
        $(#[$about])*
        #[derive(Debug)]
        $public struct $name {
            state: $crate::scphd::JointState<
                $crate::scphd::models::$pose<$scalar>,
                $crate::scphd::numerics::nalgebra::Vector2<$scalar>,
                { $features },
                {
                    $crate::scphd::storage::joint_numbers(
                        <$crate::scphd::models::TangentOf<$crate::scphd::models::$pose<$scalar>> as
                            $crate::scphd::numerics::Vector>::DIMENSION,
                        2,
                        $features,
                    )
                },
                { $measurements },
            >,
            movers: $crate::scphd::storage::JointMovers<$crate::scphd::models::$pose<$scalar>, { $movers }>,
            archive: $crate::scphd::storage::JointArchive<$crate::scphd::models::$pose<$scalar>, { $archived }>,
        }

        impl $name {
            /// Memory that holds nothing: all zero.
            #[must_use]
            $public const fn new() -> Self {
                Self {
                    state: $crate::scphd::JointState::new(),
                    movers: $crate::scphd::storage::JointMovers::new(),
                    archive: $crate::scphd::storage::JointArchive::new(),
                }
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::new()
            }
        }

        impl $crate::Backing<$scalar> for $name {
            type Slam<'m> = $crate::Joint<'m, $crate::scphd::models::$pose<$scalar>>;

            fn start(
                &mut self,
                description: &$crate::Description<$scalar>,
            ) -> Result<Self::Slam<'_>, $crate::StartError> {
                $crate::Joint::start(description, &mut self.state, &mut self.movers, &mut self.archive)
            }
        }
    };
}

/// Names the memory of a mixture: as [`memory!`](scphd::memory) does, and how many measurements a scan may have.
///
/// ```
/// use scphd_vehicle::{Backing, Description, Filter, mixture_backing};
///
/// mixture_backing! {
///     /// Of a car.
///     pub struct Car: f32, measurements: 32 {
///         particles: 4, samples: 1, features { pages: 64, pages_per_map: 16, in_view: 128 }
///     }
/// }
/// let mut memory = Box::new(Car::new());
/// let car = Description { filter: Filter::Mixture(scphd::Config::informed(4)), ..Description::robot() };
/// assert!(memory.start(&car).is_ok());
/// ```
#[macro_export]
macro_rules! mixture_backing {
    ($(#[$about:meta])* $public:vis struct $name:ident: $scalar:ty, measurements: $measurements:literal {
        $($capacities:tt)*
    }) => {
        $(#[$about])*
        #[derive(Debug)]
        $public struct $name {
            state: <$name as $crate::MixtureState>::State,
            rooms: $crate::Rooms<$scalar, $measurements>,
        }

        const _: () = {
            $crate::scphd::memory! { pub type State: $crate::scphd::models::PlanarMotion<$scalar> { $($capacities)* } }

            impl $crate::MixtureState for $name {
                type State = State;
            }

            impl $name {
                /// Memory that holds nothing: all zero.
                #[must_use]
                $public const fn new() -> Self {
                    Self { state: State::new(), rooms: $crate::Rooms::new() }
                }
            }
        };

        impl Default for $name {
            fn default() -> Self {
                Self::new()
            }
        }

        impl $crate::Backing<$scalar> for $name {
            type Slam<'m> = $crate::Mixture<'m, $scalar, $measurements>;

            fn start(
                &mut self,
                description: &$crate::Description<$scalar>,
            ) -> Result<Self::Slam<'_>, $crate::StartError> {
                let Self { state, rooms } = self;
                $crate::Mixture::start(description, rooms, |drive, config| {
                    $crate::scphd::ScPhd::new(drive, config, state)
                })
            }
        }
    };
}

/// What a named memory of a mixture holds: a name for the type that [`mixture_backing!`] makes.
#[doc(hidden)]
pub trait MixtureState {
    /// The state.
    type State;
}
