//! The memory of joint maps.

use crate::error::Refusal;
use crate::memory::{made, no_such};
use nalgebra::Vector2;
use pyo3::PyResult;
use scphd::models::{CalibratedPose, PlanarPose, ScalarOf};
use scphd::settings::MovingConfig;
use scphd::storage::{Archive, JointArchive, JointHypotheses, JointMovers, NoMovers, Tracked, joint_numbers};
use scphd::{JointSlam, Real};
use scphd_vehicle::{
    Backing, Description, Empty, Filter, JointBacking, MoversMemory, PlanarState, Services, StartError,
};
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

impl<P: PlanarState, const MOVERS: usize> Empty for MayMove<P, MOVERS> {
    const EMPTY: Self = Self(JointMovers::new());
}

/// Memory of a joint map, its moving features, its archive and its further hypotheses; `()` without archive or hypotheses.
type Memory<P, B, H, const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize, const MOVERS: usize> =
    JointBacking<P, MayMove<P, MOVERS>, B, H, FEATURES, NUMBERS, MEASUREMENTS>;

/// A joint map in its memory, with the sensors and fixes of its description.
type Slam<'m, T> = Box<dyn Services<T> + Send + 'm>;

/// Memory of a joint map, of any capacities.
pub trait Room<T: Real>: Send {
    /// Starts the described filter in this memory.
    fn start(&mut self, description: &Description<T>) -> Result<Slam<'_, T>, StartError>;
}

macro_rules! room {
    ($pose:ident, $scalar:ty, $archive:ty, $hypotheses:ty, [$($generic:tt)*]) => {
        impl<$($generic)* const FEATURES: usize, const NUMBERS: usize, const MEASUREMENTS: usize, const MOVERS: usize> Room<$scalar>
            for Memory<$pose<$scalar>, $archive, $hypotheses, FEATURES, NUMBERS, MEASUREMENTS, MOVERS>
        {
            fn start(&mut self, description: &Description<$scalar>) -> Result<Slam<'_, $scalar>, StartError> {
                Ok(Box::new(Backing::start(self, description)?))
            }
        }
    };
}
room!(PlanarPose, f32, (), (), []);
room!(PlanarPose, f32, JointArchive<PlanarPose<f32>, ARCHIVED>, (), [const ARCHIVED: usize,]);
room!(PlanarPose, f32, (), JointHypotheses<PlanarPose<f32>, OTHERS, FEATURES, NUMBERS, MOVERS>, [const OTHERS: usize,]);
room!(CalibratedPose, f32, (), (), []);
room!(CalibratedPose, f32, (), JointHypotheses<CalibratedPose<f32>, OTHERS, FEATURES, NUMBERS, MOVERS>, [const OTHERS: usize,]);
room!(PlanarPose, f64, (), (), []);
room!(PlanarPose, f64, (), JointHypotheses<PlanarPose<f64>, OTHERS, FEATURES, NUMBERS, MOVERS>, [const OTHERS: usize,]);
room!(CalibratedPose, f64, (), (), []);

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
const SETS: &str = "DESK, JOINT_40, JOINT_100, JOINT_60_MOVERS, JOINT_100_MOVERS, JOINT_40_ARCHIVE, JOINT_60_LEARNING, \
    JOINT_24_HYPOTHESES";

/// Makes memory of these capacities: features, measurements and movers, and archived features or hypotheses.
macro_rules! memory {
    ($pose:ident<$scalar:ty> of $dimension:literal: $features:literal, $measurements:literal, $movers:literal
        $(, archived $archived:literal)? $(, hypotheses $hypotheses:literal)?) => {
        made(|| Memory::<
            $pose<$scalar>,
            optional!($(JointArchive<$pose<$scalar>, $archived>)?),
            optional!($(JointHypotheses<
                $pose<$scalar>,
                { $hypotheses - 1 },
                $features,
                { joint_numbers($dimension, 2, $features) },
                $movers,
            >)?),
            $features,
            { joint_numbers($dimension, 2, $features) },
            $measurements,
            $movers,
        >::new())?
    };
}

/// A type, or `()`.
macro_rules! optional {
    () => {
        ()
    };
    ($memory:ty) => {
        $memory
    };
}

/// The optional parts of a described joint map that its memory depends on: an archive, odometry calibration, hypotheses.
fn parts<T>(description: &Description<T>) -> [bool; 3] {
    match &description.filter {
        Filter::Joint(joint) => [joint.archive_reach_m.is_some(), joint.odometry.is_some(), joint.hypotheses.is_some()],
        Filter::Mixture(_) => [false; 3],
    }
}

/// A joint map in single precision, in the memory of this name. Names and capacities are those of the C interface, so that a filter
/// gives the same results even where capacities are exceeded; sets that have no movers in C have room for one here. The capacities of
/// `DESK` depend on the description.
pub fn single(set: &str, description: &Description<f32>) -> PyResult<Box<dyn Cell<f32>>> {
    let room: Box<dyn Room<f32>> = match (set, parts(description)) {
        ("DESK", [true, ..]) => memory!(PlanarPose<f32> of 3: 200, 256, 128, archived 10_000),
        ("DESK", [_, true, true]) => memory!(CalibratedPose<f32> of 6: 256, 256, 64, hypotheses 8),
        ("DESK", [_, true, _]) => memory!(CalibratedPose<f32> of 6: 512, 256, 128),
        ("DESK", [.., true]) => memory!(PlanarPose<f32> of 3: 256, 256, 64, hypotheses 8),
        ("DESK", _) => memory!(PlanarPose<f32> of 3: 512, 256, 128),
        ("JOINT_40", _) => memory!(PlanarPose<f32> of 3: 40, 32, 1),
        ("JOINT_100", _) => memory!(PlanarPose<f32> of 3: 100, 32, 1),
        ("JOINT_60_MOVERS", _) => memory!(PlanarPose<f32> of 3: 60, 32, 16),
        ("JOINT_100_MOVERS", _) => memory!(PlanarPose<f32> of 3: 100, 32, 32),
        ("JOINT_40_ARCHIVE", _) => memory!(PlanarPose<f32> of 3: 40, 32, 16, archived 1000),
        ("JOINT_60_LEARNING", _) => memory!(CalibratedPose<f32> of 6: 60, 32, 1),
        ("JOINT_24_HYPOTHESES", _) => memory!(PlanarPose<f32> of 3: 24, 16, 8, hypotheses 8),
        _ => return Err(no_such(set, SETS)),
    };
    let cell = Single::try_new(MutBorrow::new(room), |room| room.borrow_mut().start(description));
    Ok(Box::new(cell.map_err(Refusal::raised)?))
}

/// A joint map in double precision.
pub fn double(set: &str, description: &Description<f64>) -> PyResult<Box<dyn Cell<f64>>> {
    let room: Box<dyn Room<f64>> = match (set, parts(description)) {
        ("DESK", [_, true, _]) => memory!(CalibratedPose<f64> of 6: 512, 256, 128),
        ("DESK", [.., true]) => memory!(PlanarPose<f64> of 3: 256, 256, 64, hypotheses 8),
        ("DESK", _) => memory!(PlanarPose<f64> of 3: 512, 256, 128),
        _ => return Err(no_such(set, "DESK in double precision")),
    };
    let cell = Double::try_new(MutBorrow::new(room), |room| room.borrow_mut().start(description));
    Ok(Box::new(cell.map_err(Refusal::raised)?))
}
