//! Memory types for filters, with named capacities.

use crate::{
    ArchiveMemory, Description, Empty, Fixes, HypothesesMemory, Joint, MoversMemory, PlanarState, Ranging, Recordable,
    StartError,
};
use core::marker::PhantomData;
use nalgebra::Vector2;
use scphd::models::{RangeNoise, ScalarOf, TangentOf};
use scphd::numerics::Vector;
use scphd::storage::joint_numbers;
use scphd::{JointState, Real};

/// The memory of a filter, all zero when new.
pub trait Backing<T: Real> {
    /// The filter in this memory.
    type Slam<'m>: Recordable<T>
    where
        Self: 'm;

    /// Builds the filter of the description. The content of the memory is kept: reset a new one first.
    ///
    /// # Errors
    /// The description is out of range, or is of another filter than the memory.
    fn start(&mut self, description: &Description<T>) -> Result<Self::Slam<'_>, StartError> {
        description.check_ranges()?;
        let mut slam = self.without_sensors(description, Fixes::of(description)?)?;
        slam.add_sensors(description)?;
        Ok(slam)
    }

    /// The filter without sensors, and with these fixes instead of the description's. Does not check the ranges of the description.
    ///
    /// # Errors
    /// The description is of another filter than the memory, or a model or setting is refused.
    fn without_sensors(&mut self, description: &Description<T>, fixes: Fixes<T>) -> Result<Self::Slam<'_>, StartError>;
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
        $public type $name = $crate::JointBacking<
            $crate::scphd::models::$pose<$scalar>,
            $crate::joint_beside!(JointMovers, $pose<$scalar> $(, $movers)?),
            $crate::joint_beside!(JointArchive, $pose<$scalar> $(, $archived)?),
            $crate::joint_hypotheses!($pose<$scalar>, $features, (0 $(+ $movers)?) $(, $hypotheses)?),
            { $features },
            { $crate::numbers::<$crate::scphd::models::$pose<$scalar>>($features) },
            { $measurements },
        >;
    };
}

/// The memory of a joint map: its state, moving features `M`, archive `A` and hypotheses `H`; `()` for a part that it does not have.
#[derive(Debug)]
pub struct JointBacking<
    P: PlanarState,
    M,
    A,
    H,
    const FEATURES: usize,
    const NUMBERS: usize,
    const MEASUREMENTS: usize,
    N = RangeNoise<ScalarOf<P>>,
> {
    state: JointState<P, Vector2<ScalarOf<P>>, FEATURES, NUMBERS, MEASUREMENTS>,
    movers: M,
    archive: A,
    hypotheses: H,
    noise: PhantomData<N>,
}

impl<
    P: PlanarState,
    M: Empty,
    A: Empty,
    H: Empty,
    const FEATURES: usize,
    const NUMBERS: usize,
    const MEASUREMENTS: usize,
    N,
> JointBacking<P, M, A, H, FEATURES, NUMBERS, MEASUREMENTS, N>
{
    /// An empty memory, all zero.
    #[must_use]
    pub const fn new() -> Self {
        Self { state: JointState::new(), movers: M::EMPTY, archive: A::EMPTY, hypotheses: H::EMPTY, noise: PhantomData }
    }
}

impl<
    P: PlanarState,
    M: Empty,
    A: Empty,
    H: Empty,
    const FEATURES: usize,
    const NUMBERS: usize,
    const MEASUREMENTS: usize,
    N,
> Default for JointBacking<P, M, A, H, FEATURES, NUMBERS, MEASUREMENTS, N>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<T, P, M, A, H, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize, N> Backing<T>
    for JointBacking<P, M, A, H, FEATURES, NUMBERS, MEASUREMENTS, N>
where
    T: Real,
    P: PlanarState<Scalar = T> + 'static,
    M: MoversMemory<P> + 'static,
    A: ArchiveMemory<P> + 'static,
    H: for<'m> HypothesesMemory<'m, P, A::Archive<'m>, M::Movers<'m>> + 'static,
    N: Ranging<T> + 'static,
{
    type Slam<'m> = Joint<<H as HypothesesMemory<'m, P, A::Archive<'m>, M::Movers<'m>>>::Filter, P, N>;

    // Inlined, so that an image contains the generic code only once.
    #[inline]
    fn without_sensors(&mut self, description: &Description<T>, fixes: Fixes<T>) -> Result<Self::Slam<'_>, StartError> {
        let Self { state, movers, archive, hypotheses, noise: _ } = self;
        Joint::without_sensors(description, fixes, state, movers, archive, hypotheses)
    }
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
    ($pose:ident<$scalar:ty>, $features:expr, $movers:expr) => { () };
    ($pose:ident<$scalar:ty>, $features:expr, $movers:expr, $hypotheses:expr) => {
        $crate::scphd::storage::JointHypotheses<
            $crate::scphd::models::$pose<$scalar>,
            { $hypotheses - 1 },
            { $features },
            { $crate::numbers::<$crate::scphd::models::$pose<$scalar>>($features) },
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
            fn without_sensors(
                &mut self,
                description: &$crate::Description<$scalar>,
                fixes: $crate::Fixes<$scalar>,
            ) -> Result<Self::Slam<'_>, $crate::StartError> {
                let Self { state, rooms } = self;
                $crate::Mixture::without_sensors(description, fixes, rooms, |drive, config| {
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
