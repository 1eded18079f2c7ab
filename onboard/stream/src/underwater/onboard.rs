//! The filter of an underwater vehicle on board, and its capacities.

use super::AuvModels;
use super::{Navigation, Underwater};
use crate::Header;
use crate::onboard::{self, Aboard, Capacities, Helm, Onboard, Ram, RamPart, Refusal, births, config};
use core::marker::PhantomData;
use nalgebra::{Vector3, Vector4};
use scphd::errors::PredictError;
use scphd::models::{Auv, AuvControl, AuvPose, Sensing, StereoCamera, StereoFrustum, UniformClutter};
use scphd::navigation::Navigator;
use scphd::snapshot::{RestoreError, SaveError};
use scphd::storage::{MapMemory, NoMoving, Static};
use scphd::{Detector, DetectorMemory, Real, ScPhd, State};

const PARTICLES: usize = 64;
const CANDIDATES: usize = 64;
/// The rest of 512 KiB in single precision.
const PAGES: usize = 976;
const MAP_PAGES: usize = 128;
/// Maximum number of pairs in an image.
pub const MEASUREMENTS: usize = 96;
const VIEW: usize = 512;
/// Capacity of an estimated map, features.
const FEATURES: usize = 640;

/// State of a filter with these capacities, without moving features.
type AuvState<T, const PARTICLES: usize, const CANDIDATES: usize, const PAGES: usize, const VIEW: usize> = State<
    AuvPose<T>,
    PARTICLES,
    CANDIDATES,
    MapMemory<Static<Vector3<T>>, PARTICLES, PAGES, MAP_PAGES, VIEW>,
    NoMoving,
>;

type OnboardState<T> = AuvState<T, PARTICLES, CANDIDATES, PAGES, VIEW>;

/// The working memory of the detector.
type Scratch<T> = DetectorMemory<Vector4<T>, MEASUREMENTS>;

/// All memory of the filter on board.
pub type Memory<T> = onboard::Memory<OnboardState<T>, Vector3<T>, Vector4<T>, MEASUREMENTS, FEATURES>;

/// The increase of the size of the state with these increases of the capacities.
macro_rules! price {
    ($particles:expr, $candidates:expr, $pages:expr, $view:expr) => {
        size_of::<
            AuvState<T, { PARTICLES + $particles }, { CANDIDATES + $candidates }, { PAGES + $pages }, { VIEW + $view }>,
        >() - size_of::<OnboardState<T>>()
    };
}

/// Use of the RAM, from the cost of each capacity: the size of a state with eight more of it.
const fn ram<T: Real>() -> Ram {
    let candidates = price!(0, 8, 0, 0) / 8;
    let particles = price!(8, 8, 0, 0) / 8 - candidates;
    Ram {
        total: size_of::<Memory<T>>(),
        state: size_of::<OnboardState<T>>() + size_of::<Scratch<T>>(),
        particles: particles * PARTICLES + candidates * CANDIDATES,
        pages: price!(0, 0, 8, 0) / 8 * PAGES,
        moving_pages: 0,
        scratch: size_of::<Scratch<T>>() + price!(0, 0, 0, 8) / 8 * VIEW,
    }
}

impl<T: Real> Aboard<T> for Underwater {
    type Kind = Self;
    type Memory = Memory<T>;
    type Filter<'m>
        = Onboard<'m, Self, Navigator<f64>, Auv<T>, Sensing<StereoCamera<T>, StereoFrustum<T>, UniformClutter<T>>>
    where
        T: 'm;

    const MEMORY: Memory<T> = Memory::with(State::new());
    const CAPACITIES: Capacities = Capacities {
        candidates: CANDIDATES,
        particles: PARTICLES,
        components: MAP_PAGES * scphd::storage::PAGE_LEN,
        components_in_all: PAGES * scphd::storage::PAGE_LEN,
        measurements: MEASUREMENTS,
    };
    const RAM_PARTS: [RamPart; 6] = ram::<T>().parts();

    fn start<'m>(header: &Header<Self>, memory: &'m mut Memory<T>) -> Result<Self::Filter<'m>, Refusal>
    where
        T: 'm,
    {
        let onboard::Memory { state, scratch, measurements, features } = memory;
        let AuvModels { motion, sensing } = header.models.of_filter()?;
        let mut filter = ScPhd::new(motion, config(header), state)?;
        let detector = Detector::new(sensing, births(header))?.over(scratch)?;
        filter.check(&detector)?;
        filter.reset(header.models.start(), header.seed)?;
        Ok(Onboard { filter, detector, helm: header.models.navigator()?, kind: PhantomData, measurements, features })
    }
}

impl<T: Real> Helm<T, Navigation, AuvControl<T>> for Navigator<f64> {
    fn control(&mut self, navigation: &Navigation) -> Result<Option<(AuvControl<T>, T)>, PredictError> {
        let dt_s = navigation.dt_s;
        let control = match &navigation.instruments {
            Some(row) => self.instruments(row, dt_s),
            None => self.onward(dt_s),
        };
        Ok(control?.map(|control| (control.rounded(), T::from_f64(dt_s))))
    }

    const HAS_STATE: bool = true;

    fn save<E>(&self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
        self.save(kind, sink)
    }

    fn restore<E>(
        &mut self,
        kind: u32,
        source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>> {
        self.restore(kind, source)
    }
}
