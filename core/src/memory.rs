//! Macros for the memory of a filter, with named capacities.

/// Defines the type of the memory of a [`ScPhd`](crate::ScPhd): a [`State`](crate::State) for a motion model, with named
/// capacities.
///
/// | name | meaning |
/// |---|---|
/// | `particles` | maximum number of particles |
/// | `samples` | samples per particle between a prediction and its scan |
/// | `pages` | total number of pages of all particles' maps; a page has [`PAGE_LEN`](crate::PAGE_LEN) components |
/// | `pages_per_map` | maximum number of pages of one particle's map |
/// | `in_view` | maximum number of components of one map in view during an update |
/// | `waiting` | number of measurements of a scan whose births can be delayed, up to 256 in steps of 64; 64 by default |
///
/// ```
/// use scphd::models::Ackermann;
/// use scphd::memory;
///
/// memory! {
///     /// The memory of the car's filter.
///     pub type CarMemory: Ackermann<f32> {
///         particles: 32, samples: 2,
///         features { pages: 192, pages_per_map: 32, in_view: 256 },
///         moving { pages: 112, pages_per_map: 16, in_view: 128 },
///     }
/// }
/// memory! {
///     type SmallMemory: Ackermann<f32> {
///         particles: 4, samples: 1, features { pages: 64, pages_per_map: 16, in_view: 128 }, waiting: 128
///     }
/// }
/// static CAR: std::sync::Mutex<CarMemory> = std::sync::Mutex::new(CarMemory::new());
/// assert!(size_of::<CarMemory>() < 160 * 1024 && size_of::<SmallMemory>() < 42 * 1024);
/// ```
#[macro_export]
macro_rules! memory {
    ($(#[$about:meta])* $public:vis type $name:ident: $motion:ty {
        particles: $particles:expr, samples: $samples:expr,
        features { pages: $pages:expr, pages_per_map: $map_pages:expr, in_view: $view:expr $(,)? }
        $(, moving { pages: $moving_pages:expr, pages_per_map: $moving_map_pages:expr, in_view: $moving_view:expr $(,)? })?
        $(, waiting: $waiting:expr)? $(,)?
    }) => {
        $(#[$about])*
        $public type $name = $crate::State<
            <$motion as $crate::models::Motion>::Pose,
            { $particles },
            { $particles * $samples },
            $crate::memory!(@maps Static of $motion: { $particles }, { $pages }, { $map_pages }, { $view }),
            $crate::memory!(
                @maps Dynamic of $motion: { $particles } $(, { $moving_pages }, { $moving_map_pages }, { $moving_view })?
            ),
            $({ usize::div_ceil($waiting, 64) })?
        >;
    };
    (@maps Dynamic of $motion:ty: $particles:block) => { $crate::storage::NoMoving };
    (@maps $kind:ident of $motion:ty: $particles:block, $pages:block, $map_pages:block, $view:block) => {
        $crate::storage::MapMemory<
            $crate::storage::$kind<$crate::models::PositionOf<<$motion as $crate::models::Motion>::Pose>>,
            $particles,
            $pages,
            $map_pages,
            $view,
        >
    };
}

/// Defines the type of the memory of a [`JointSlam`](crate::JointSlam): a [`JointState`](crate::JointState) for a motion model,
/// with named capacities. `measurement` is the measurement with the most dimensions of all sensors of the vehicle.
///
/// ```
/// use nalgebra::Vector2;
/// use scphd::models::Unicycle;
/// use scphd::joint_memory;
///
/// joint_memory! {
///     /// One Gaussian over the robot and up to 40 landmarks.
///     pub type RobotMap: Unicycle<f32> { measurement: Vector2<f32>, features: 40, measurements: 16 }
/// }
/// assert!(size_of::<RobotMap>() < 24 * 1024);
/// ```
#[macro_export]
macro_rules! joint_memory {
    ($(#[$about:meta])* $public:vis type $name:ident: $motion:ty {
        measurement: $measurement:ty, features: $features:expr, measurements: $measurements:expr $(,)?
    }) => {
        $(#[$about])*
        $public type $name = $crate::JointState<
            <$motion as $crate::models::Motion>::Pose,
            $measurement,
            { $features },
            {
                $crate::storage::joint_numbers(
                    <$crate::models::TangentOf<<$motion as $crate::models::Motion>::Pose> as $crate::numerics::Vector>::DIMENSION,
                    <$crate::models::PositionOf<<$motion as $crate::models::Motion>::Pose> as $crate::numerics::Vector>::DIMENSION,
                    $features,
                )
            },
            { $measurements },
        >;
    };
}
