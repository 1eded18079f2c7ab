//! The memory of joint maps.

use crate::error::Refusal;
use crate::memory::{made, no_such};
use nalgebra::Vector2;
use pyo3::PyResult;
use scphd::models::{CalibratedPose, PlanarPose, ScalarOf};
use scphd::settings::MovingConfig;
use scphd::storage::{Archive, JointArchive, JointMovers, NoMovers, Tracked, joint_numbers};
use scphd::{JointSlam, JointState, Real};
use scphd_vehicle::{Description, Filter, Joint, MoversMemory, PlanarState, Services, StartError};
use self_cell::{MutBorrow, self_cell};

/// Memory for moving features, used if the description has them.
struct MayMove<P: PlanarState, const MOVERS: usize>(JointMovers<P, MOVERS>);

impl<P: PlanarState + 'static, const MOVERS: usize> MoversMemory<P> for MayMove<P, MOVERS> {
    type Movers<'m> = Option<Tracked<'m, P>>;

    fn add_movers<'m, A: Archive<P>>(
        &'m mut self,
        map: JointSlam<'m, P::Moves, Vector2<ScalarOf<P>>, A, NoMovers>,
        moving: Option<MovingConfig<ScalarOf<P>>>,
    ) -> Result<JointSlam<'m, P::Moves, Vector2<ScalarOf<P>>, A, Self::Movers<'m>>, StartError> {
        Ok(map.with_movers_if(moving.map(|moving| (&mut self.0, moving)))?)
    }
}

/// Memory of a joint map, its moving features and its archive; `()` without an archive.
struct Memory<
    P: PlanarState,
    B,
    const FEATURES: usize,
    const NUMBERS: usize,
    const MEASUREMENTS: usize,
    const MOVERS: usize,
> {
    state: JointState<P, Vector2<ScalarOf<P>>, FEATURES, NUMBERS, MEASUREMENTS>,
    movers: MayMove<P, MOVERS>,
    archive: B,
}

/// A joint map in its memory, with the sensors and fixes of its description.
type Slam<'m, T> = Box<dyn Services<T> + Send + 'm>;

/// Memory of a joint map, of any capacities.
pub trait Room<T: Real>: Send {
    /// Starts the described filter in this memory.
    fn start(&mut self, description: &Description<T>) -> Result<Slam<'_, T>, StartError>;
}

macro_rules! room {
    ($pose:ident, $scalar:ty, $archive:ty, [$($archived:tt)*]) => {
        impl<$($archived)* const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize, const MOVERS: usize> Room<$scalar>
            for Memory<$pose<$scalar>, $archive, FEATURES, NUMBERS, MEASUREMENTS, MOVERS>
        {
            fn start(&mut self, description: &Description<$scalar>) -> Result<Slam<'_, $scalar>, StartError> {
                let Self { state, movers, archive } = self;
                Ok(Box::new(Joint::start(description, state, movers, archive)?))
            }
        }
    };
}
room!(PlanarPose, f32, (), []);
room!(PlanarPose, f32, JointArchive<PlanarPose<f32>, ARCHIVED>, [const ARCHIVED: usize,]);
room!(CalibratedPose, f32, (), []);
room!(PlanarPose, f64, (), []);
room!(CalibratedPose, f64, (), []);

self_cell!(
    struct Single {
        owner: MutBorrow<Box<dyn Room<f32>>>,
        #[not_covariant]
        dependent: Slam32,
    }
);
self_cell!(
    struct Double {
        owner: MutBorrow<Box<dyn Room<f64>>>,
        #[not_covariant]
        dependent: Slam64,
    }
);
type Slam32<'m> = Slam<'m, f32>;
type Slam64<'m> = Slam<'m, f64>;

/// A joint map together with its memory.
pub trait Cell<T: Real>: Send {
    /// Calls a function with the filter.
    fn enter(&mut self, work: &mut dyn FnMut(&mut dyn Services<T>));
}

impl Cell<f32> for Single {
    fn enter(&mut self, work: &mut dyn FnMut(&mut dyn Services<f32>)) {
        self.with_dependent_mut(|_, slam| work(&mut **slam));
    }
}

impl Cell<f64> for Double {
    fn enter(&mut self, work: &mut dyn FnMut(&mut dyn Services<f64>)) {
        self.with_dependent_mut(|_, slam| work(&mut **slam));
    }
}

/// Names of the sets of capacities.
const SETS: &str = "DESK, JOINT_40, JOINT_100, JOINT_60_MOVERS, JOINT_100_MOVERS, JOINT_40_ARCHIVE, JOINT_60_LEARNING";

/// Makes memory of these capacities.
macro_rules! memory {
    ($pose:ident<$scalar:ty> of $dimension:literal, $archive:ty: $empty:expr, $features:literal, $measurements:literal, $movers:literal) => {
        made(|| Memory::<
            $pose<$scalar>,
            $archive,
            $features,
            { joint_numbers($dimension, 2, $features) },
            $measurements,
            $movers,
        > {
            state: JointState::new(),
            movers: MayMove(JointMovers::new()),
            archive: $empty,
        })?
    };
}

/// A joint map in single precision, in the memory of this name. Those of the C interface have the same names and capacities, so
/// that a filter gives the same results even where capacities are exceeded. The capacities of `DESK` depend on the description.
pub fn single(set: &str, description: &Description<f32>) -> PyResult<Box<dyn Cell<f32>>> {
    let (archived, learnt) = match &description.filter {
        Filter::Joint(joint) => (joint.archive_reach_m.is_some(), joint.odometry.is_some()),
        Filter::Mixture(_) => (false, false),
    };
    let room: Box<dyn Room<f32>> = match set {
        "DESK" if archived => memory!(
            PlanarPose<f32> of 3, JointArchive<PlanarPose<f32>, 10_000>: JointArchive::new(), 200, 256, 128),
        "DESK" if learnt => memory!(CalibratedPose<f32> of 6, (): (), 512, 256, 128),
        "DESK" => memory!(PlanarPose<f32> of 3, (): (), 512, 256, 128),
        "JOINT_40" => memory!(PlanarPose<f32> of 3, (): (), 40, 32, 1),
        "JOINT_100" => memory!(PlanarPose<f32> of 3, (): (), 100, 32, 1),
        "JOINT_60_MOVERS" => memory!(PlanarPose<f32> of 3, (): (), 60, 32, 16),
        "JOINT_100_MOVERS" => memory!(PlanarPose<f32> of 3, (): (), 100, 32, 32),
        "JOINT_40_ARCHIVE" => memory!(
            PlanarPose<f32> of 3, JointArchive<PlanarPose<f32>, 1000>: JointArchive::new(), 40, 32, 16),
        "JOINT_60_LEARNING" => memory!(CalibratedPose<f32> of 6, (): (), 60, 32, 1),
        _ => return Err(no_such(set, SETS)),
    };
    let cell = Single::try_new(MutBorrow::new(room), |room| room.borrow_mut().start(description));
    Ok(Box::new(cell.map_err(Refusal::raised)?))
}

/// A joint map in double precision.
pub fn double(set: &str, description: &Description<f64>) -> PyResult<Box<dyn Cell<f64>>> {
    let learnt = matches!(&description.filter, Filter::Joint(joint) if joint.odometry.is_some());
    let room: Box<dyn Room<f64>> = match set {
        "DESK" if learnt => memory!(CalibratedPose<f64> of 6, (): (), 512, 256, 128),
        "DESK" => memory!(PlanarPose<f64> of 3, (): (), 512, 256, 128),
        _ => return Err(no_such(set, "DESK in double precision")),
    };
    let cell = Double::try_new(MutBorrow::new(room), |room| room.borrow_mut().start(description));
    Ok(Box::new(cell.map_err(Refusal::raised)?))
}
