//! The memory of mixtures: sets of capacities, and the cell with a filter and its memory.

use crate::error::{Refusal, SettingError};
use crate::vehicle::Vehicle;
use nalgebra::{Vector1, Vector2};
use pyo3::PyResult;
use pyo3::exceptions::PyRuntimeError;
use scphd::errors::SetupError;
use scphd::models::PlanarPose;
use scphd::storage::{Dynamic, MapStorage, Static};
use scphd::{Config, DetectorMemory, ScPhd, State, memory};
use self_cell::{MutBorrow, self_cell};

/// Maximum number of measurements in a scan.
const MEASUREMENTS: usize = 1024;

/// Scratch memory for scans of a mixture.
pub struct ScanMemory {
    /// For ranges and bearings.
    pub polar: DetectorMemory<Vector2<f32>, MEASUREMENTS>,
    /// For bearings.
    pub direction: DetectorMemory<Vector1<f32>, MEASUREMENTS>,
}

/// Sets of capacities of a mixture. Those of the C interface have the same names and capacities, so that a filter gives the same
/// results even where capacities are exceeded.
mod sets {
    use super::memory;
    use scphd::models::Unicycle;

    memory! {
        pub type Desk: Unicycle<f32> {
            particles: 512, samples: 4, features { pages: 16_384, pages_per_map: 256, in_view: 2048 },
            moving { pages: 4096, pages_per_map: 64, in_view: 1024 },
        }
    }
    memory! {
        pub type Plane32x2: Unicycle<f32> {
            particles: 32, samples: 2, features { pages: 320, pages_per_map: 32, in_view: 256 },
            moving { pages: 128, pages_per_map: 16, in_view: 128 },
        }
    }
    memory! {
        pub type PlaneInformed4: Unicycle<f32> {
            particles: 4, samples: 1, features { pages: 128, pages_per_map: 32, in_view: 256 },
        }
    }
    memory! {
        pub type PlaneInformed4Moving: Unicycle<f32> {
            particles: 4, samples: 1, features { pages: 128, pages_per_map: 32, in_view: 256 },
            moving { pages: 64, pages_per_map: 16, in_view: 128 },
        }
    }
}

/// Memory of a mixture, of any capacities.
pub trait Room: Send {
    /// Starts a filter in this memory.
    fn start(&mut self, motion: Vehicle, config: Config<f32>) -> Result<Mixture<'_>, SetupError>;
}

impl<const PARTICLES: usize, const CANDIDATES: usize, S, V> Room for State<PlanarPose<f32>, PARTICLES, CANDIDATES, S, V>
where
    S: MapStorage<Static<Vector2<f32>>> + Send,
    V: MapStorage<Dynamic<Vector2<f32>>> + Send,
{
    fn start(&mut self, motion: Vehicle, config: Config<f32>) -> Result<Mixture<'_>, SetupError> {
        ScPhd::new(motion, config, self)
    }
}

/// A mixture in its memory.
pub type Mixture<'m> = ScPhd<'m, Vehicle>;

self_cell!(
    /// A mixture and its memory.
    pub struct MixtureCell {
        owner: MutBorrow<Box<dyn Room>>,
        #[not_covariant]
        dependent: Mixture,
    }
);

/// Constructs a value on the heap, in a thread with a large stack: the value may pass through the stack, and threads of Python
/// have small ones.
pub fn made<T: Send>(make: fn() -> T) -> PyResult<Box<T>> {
    let stack = size_of::<T>().saturating_mul(4).saturating_add(1 << 20);
    std::thread::scope(|scope| {
        let maker = std::thread::Builder::new().stack_size(stack).spawn_scoped(scope, || Box::new(make()))?;
        maker.join().map_err(|_| PyRuntimeError::new_err("making the memory of a filter ended with a panic"))
    })
}

/// Scratch memory for scans of a mixture.
pub fn scan_memory() -> PyResult<Box<ScanMemory>> {
    made(|| ScanMemory { polar: DetectorMemory::new(), direction: DetectorMemory::new() })
}

/// A mixture in the memory of this name.
pub fn mixture(set: &str, motion: Vehicle, config: Config<f32>) -> PyResult<MixtureCell> {
    let room: Box<dyn Room> = match set {
        "DESK" => made(sets::Desk::new)?,
        "PLANE_32X2" => made(sets::Plane32x2::new)?,
        "PLANE_INFORMED_4" => made(sets::PlaneInformed4::new)?,
        "PLANE_INFORMED_4_MOVING" => made(sets::PlaneInformed4Moving::new)?,
        _ => return Err(no_such(set, "DESK, PLANE_32X2, PLANE_INFORMED_4, PLANE_INFORMED_4_MOVING")),
    };
    MixtureCell::try_new(MutBorrow::new(room), |room| room.borrow_mut().start(motion, config)).map_err(Refusal::raised)
}

/// The error of an unknown name.
pub fn no_such(set: &str, known: &str) -> pyo3::PyErr {
    SettingError::new_err(format!("memory must be one of {known}, not '{set}'"))
}
