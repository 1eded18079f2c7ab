//! The static memory of a filter, with named capacities.

use crate::{Description, PlanarState, Services, StartError};
use scphd::Real;
use scphd::models::TangentOf;
use scphd::numerics::Vector;
use scphd::storage::joint_numbers;

/// The memory of a filter, all zero when new.
pub trait Backing<T: Real> {
    /// The filter in this memory.
    type Slam<'m>: Services<T>
    where
        Self: 'm;

    /// Builds the filter of the description. The content of the memory is kept: reset a new one first.
    ///
    /// # Errors
    /// The description is out of range, or is of another filter than the memory.
    fn start(&mut self, description: &Description<T>) -> Result<Self::Slam<'_>, StartError>;
}

/// Declares the type of a joint map's memory. The pose is `PlanarPose`, or `CalibratedPose` to calibrate the odometry. Capacities
/// for movers, for features in an archive, and for hypotheses of data association are optional: `movers: 16, archived: 1000`, or
/// `movers: 16, hypotheses: 8`. The description must have the same optional parts as the memory.
///
/// ```
/// use scphd::settings::MovingConfig;
/// use scphd_vehicle::{Backing, Description, Filter, JointSettings, joint_backing};
///
/// joint_backing! {
///     /// Of a robot among people.
///     pub struct Robot: PlanarPose<f32> { features: 50, measurements: 16, movers: 8 }
/// }
/// let mut memory = Box::new(Robot::new());
/// let joint = JointSettings { movers: Some(MovingConfig::walkers()), ..JointSettings::default() };
/// assert!(memory.start(&Description { filter: Filter::Joint(joint), ..Description::robot() }).is_ok());
/// ```
#[macro_export]
macro_rules! joint_backing {
    ($(#[$about:meta])* $public:vis struct $name:ident: $pose:ident<$scalar:ty> {
        features: $features:expr, measurements: $measurements:expr
        $(, movers: $movers:expr)? $(, archived: $archived:expr)? $(, hypotheses: $hypotheses:expr)? $(,)?
    }) => {
        $(#[$about])*
        #[derive(Debug)]
        $public struct $name {
            state: $crate::scphd::JointState<
                $crate::scphd::models::$pose<$scalar>,
                $crate::scphd::numerics::nalgebra::Vector2<$scalar>,
                { $features },
                { $crate::numbers::<$crate::scphd::models::$pose<$scalar>>($features) },
                { $measurements },
            >,
            movers: $crate::joint_beside!(JointMovers, $pose<$scalar> $(, $movers)?),
            archive: $crate::joint_beside!(JointArchive, $pose<$scalar> $(, $archived)?),
            hypotheses: $crate::joint_hypotheses!(
                $pose<$scalar>, $features, $measurements, (0 $(+ $movers)?) $(, $hypotheses)?
            ),
        }

        impl $name {
            /// An empty memory, all zero.
            #[must_use]
            $public const fn new() -> Self {
                Self {
                    state: $crate::scphd::JointState::new(),
                    movers: $crate::Empty::EMPTY,
                    archive: $crate::Empty::EMPTY,
                    hypotheses: $crate::Empty::EMPTY,
                }
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::new()
            }
        }

        impl $crate::Backing<$scalar> for $name {
            type Slam<'m> = $crate::Joint<
                <$crate::joint_hypotheses!(
                    $pose<$scalar>, $features, $measurements, (0 $(+ $movers)?) $(, $hypotheses)?
                ) as $crate::HypothesesMemory<
                    'm,
                    $crate::scphd::models::$pose<$scalar>,
                    <$crate::joint_beside!(JointArchive, $pose<$scalar> $(, $archived)?) as
                        $crate::ArchiveMemory<$crate::scphd::models::$pose<$scalar>>>::Archive<'m>,
                    <$crate::joint_beside!(JointMovers, $pose<$scalar> $(, $movers)?) as
                        $crate::MoversMemory<$crate::scphd::models::$pose<$scalar>>>::Movers<'m>,
                >>::Filter,
                $crate::scphd::models::$pose<$scalar>,
            >;

            // Inlined, so that an image contains the generic code only once.
            #[inline]
            fn start(
                &mut self,
                description: &$crate::Description<$scalar>,
            ) -> Result<Self::Slam<'_>, $crate::StartError> {
                let Self { state, movers, archive, hypotheses } = self;
                $crate::Joint::start(description, state, movers, archive, hypotheses)
            }
        }
    };
}

/// Optional memory of a joint map, or none.
#[doc(hidden)]
#[macro_export]
macro_rules! joint_beside {
    ($memory:ident, $pose:ident<$scalar:ty>) => { () };
    ($memory:ident, $pose:ident<$scalar:ty>, $capacity:expr) => {
        $crate::scphd::storage::$memory<$crate::scphd::models::$pose<$scalar>, { $capacity }>
    };
}

/// Memory of the hypotheses beside the likeliest, or none.
#[doc(hidden)]
#[macro_export]
macro_rules! joint_hypotheses {
    ($pose:ident<$scalar:ty>, $features:expr, $measurements:expr, $movers:expr) => { () };
    ($pose:ident<$scalar:ty>, $features:expr, $measurements:expr, $movers:expr, $hypotheses:expr) => {
        $crate::scphd::storage::JointHypotheses<
            $crate::scphd::models::$pose<$scalar>,
            { $hypotheses - 1 },
            { $features },
            { $crate::numbers::<$crate::scphd::models::$pose<$scalar>>($features) },
            { $measurements },
            { $movers },
        >
    };
}

/// Capacity for numbers of a joint state with this pose and capacity for features.
#[doc(hidden)]
#[must_use]
pub const fn numbers<P: PlanarState>(features: usize) -> usize {
    joint_numbers(<TangentOf<P> as Vector>::DIMENSION, 2, features)
}

/// Declares the type of a mixture's memory: capacities as in [`memory!`](scphd::memory), and the maximum number of measurements
/// in a scan. For sensors of range and bearing; with `measurements: 32 with bearings` also for bearing-only sensors.
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
    ($(#[$about:meta])* $public:vis struct $name:ident: $scalar:ty, measurements: $measurements:literal with bearings {
        $($capacities:tt)*
    }) => {
        $crate::mixture_backing! { @ BearingRooms $(#[$about])* $public $name $scalar, $measurements { $($capacities)* } }
    };
    ($(#[$about:meta])* $public:vis struct $name:ident: $scalar:ty, measurements: $measurements:literal {
        $($capacities:tt)*
    }) => {
        $crate::mixture_backing! { @ PolarRooms $(#[$about])* $public $name $scalar, $measurements { $($capacities)* } }
    };
    (@ $rooms:ident $(#[$about:meta])* $public:vis $name:ident $scalar:ty, $measurements:literal { $($capacities:tt)* }) => {
        $(#[$about])*
        #[derive(Debug)]
        $public struct $name {
            state: <$name as $crate::MixtureState>::State,
            rooms: $crate::$rooms<$scalar, $measurements>,
        }

        const _: () = {
            $crate::scphd::memory! { pub type State: $crate::scphd::models::PlanarMotion<$scalar> { $($capacities)* } }

            impl $crate::MixtureState for $name {
                type State = State;
            }

            impl $name {
                /// An empty memory, all zero.
                #[must_use]
                $public const fn new() -> Self {
                    Self { state: State::new(), rooms: $crate::$rooms::new() }
                }
            }
        };

        impl Default for $name {
            fn default() -> Self {
                Self::new()
            }
        }

        impl $crate::Backing<$scalar> for $name {
            type Slam<'m> = $crate::Mixture<'m, $scalar, $crate::$rooms<$scalar, $measurements>>;

            // Inlined, so that an image contains the generic code only once.
            #[inline]
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

/// The content of a mixture's memory: a name for the type that [`mixture_backing!`] declares.
#[doc(hidden)]
pub trait MixtureState {
    /// The state.
    type State;
}
