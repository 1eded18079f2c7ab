//! The mixture filter of a planar vehicle on board, and its capacities.

use super::Planar;
use super::onboard::{MEASUREMENTS, Memory, Noise, OnBoard};
use crate::Parameters;
use crate::onboard::{Aboard, Capacities, Ram, RamPart, Refusal};
use nalgebra::Vector2;
use scphd::models::PlanarPose;
use scphd::storage::{Dynamic, MapMemory, Static};
use scphd::{Real, ScPhd, State};
use scphd_vehicle::{self as vehicle, Backing, Description, Fixes, PolarRooms, StartError};

/// The mixture filter for black boxes of planar vehicles.
#[derive(Debug, Clone, Copy)]
pub struct BlackBox;

/// Capacities for the particles of section 5.3.1.
#[cfg(not(any(feature = "few-particles", feature = "small-pools")))]
mod room {
    pub(super) const PARTICLES: usize = 32;
    pub(super) const CANDIDATES: usize = 64;
    pub(super) const PAGES: usize = 192;
    pub(super) const MAP_PAGES: usize = 32;
    pub(super) const VIEW: usize = 96;
    pub(super) const MOVING_PAGES: usize = 112;
    pub(super) const MOVING_MAP_PAGES: usize = 10;
    pub(super) const MOVING_VIEW: usize = 72;
}

/// Capacities for informed particles, which need no samples.
#[cfg(feature = "few-particles")]
mod room {
    pub(super) const PARTICLES: usize = 4;
    pub(super) const CANDIDATES: usize = 4;
    pub(super) const PAGES: usize = 176;
    pub(super) const MAP_PAGES: usize = 40;
    pub(super) const VIEW: usize = 256;
    pub(super) const MOVING_PAGES: usize = 48;
    pub(super) const MOVING_MAP_PAGES: usize = 16;
    pub(super) const MOVING_VIEW: usize = 160;
}

/// Capacities for the same number of particles: a quarter of the pages that they need; the other capacities are what the stream
/// `faults` uses.
#[cfg(all(feature = "small-pools", not(feature = "few-particles")))]
mod room {
    pub(super) const PARTICLES: usize = 32;
    pub(super) const CANDIDATES: usize = 64;
    pub(super) const PAGES: usize = 80;
    pub(super) const MAP_PAGES: usize = 8;
    pub(super) const VIEW: usize = 96;
    pub(super) const MOVING_PAGES: usize = 24;
    pub(super) const MOVING_MAP_PAGES: usize = 10;
    pub(super) const MOVING_VIEW: usize = 72;
}

use room::{CANDIDATES, MAP_PAGES, MOVING_MAP_PAGES, MOVING_PAGES, MOVING_VIEW, PAGES, PARTICLES, VIEW};
/// Capacity of an estimated map, features.
const FEATURES: usize = 128;

/// State of a filter with these increases of all capacities of the one on board.
type StateWith<
    T,
    const PARTICLES_AND: usize,
    const CANDIDATES_AND: usize,
    const PAGES_AND: usize,
    const VIEW_AND: usize,
    const MOVING_PAGES_AND: usize,
    const MOVING_VIEW_AND: usize,
> = State<
    PlanarPose<T>,
    PARTICLES_AND,
    CANDIDATES_AND,
    MapMemory<Static<Vector2<T>>, PARTICLES_AND, PAGES_AND, MAP_PAGES, VIEW_AND>,
    MapMemory<Dynamic<Vector2<T>>, PARTICLES_AND, MOVING_PAGES_AND, MOVING_MAP_PAGES, MOVING_VIEW_AND>,
>;

type OnboardState<T> = StateWith<T, PARTICLES, CANDIDATES, PAGES, VIEW, MOVING_PAGES, MOVING_VIEW>;

/// The memory of the mixture.
#[derive(Debug)]
pub struct Backed<T: Real> {
    state: OnboardState<T>,
    rooms: PolarRooms<T, MEASUREMENTS, Noise<T>>,
}

impl<T: Real> Backing<T> for Backed<T> {
    type Slam<'m> = vehicle::Mixture<'m, T, PolarRooms<T, MEASUREMENTS, Noise<T>>>;

    #[inline]
    fn without_sensors(&mut self, description: &Description<T>, fixes: Fixes<T>) -> Result<Self::Slam<'_>, StartError> {
        let Self { state, rooms } = self;
        // The memory may be of an earlier replay, of another number of particles. An empty state needs no check.
        state.clear();
        vehicle::Mixture::without_sensors(description, fixes, rooms, |drive, config| {
            ScPhd::reborrow(drive, config, state)
        })
    }
}

/// All memory of the filter on board.
type Room<T> = Memory<Backed<T>, T, FEATURES>;

/// The size of the state with these increases of the capacities, minus that of the one on board.
macro_rules! price {
    ($particles:expr, $candidates:expr, $pages:expr, $view:expr, $moving_pages:expr, $moving_view:expr) => {
        size_of::<
            StateWith<
                T,
                { PARTICLES + $particles },
                { CANDIDATES + $candidates },
                { PAGES + $pages },
                { VIEW + $view },
                { MOVING_PAGES + $moving_pages },
                { MOVING_VIEW + $moving_view },
            >,
        >() - size_of::<OnboardState<T>>()
    };
}

/// Use of the RAM, from the cost of each capacity: the size of a state with eight more of it.
const fn ram<T: Real>() -> Ram {
    let candidates = price!(0, 8, 0, 0, 0, 0) / 8;
    let particles = price!(8, 8, 0, 0, 0, 0) / 8 - candidates;
    Ram {
        total: size_of::<Room<T>>(),
        state: size_of::<Backed<T>>(),
        particles: particles * PARTICLES + candidates * CANDIDATES,
        pages: price!(0, 0, 8, 0, 0, 0) / 8 * PAGES,
        moving_pages: price!(0, 0, 0, 0, 8, 0) / 8 * MOVING_PAGES,
        scratch: size_of::<PolarRooms<T, MEASUREMENTS, Noise<T>>>()
            + price!(0, 0, 0, 8, 0, 0) / 8 * VIEW
            + price!(0, 0, 0, 0, 0, 8) / 8 * MOVING_VIEW,
    }
}

/// Declares the filter on board, and that of a black box.
macro_rules! on_board {
    ($($name:ident: $black_box:literal;)+) => {$(
        impl<T: Real> Aboard<T> for $name {
            type Kind = Planar;
            type Memory = Room<T>;
            type Filter<'m>
                = OnBoard<'m, <Backed<T> as Backing<T>>::Slam<'m>, T, $black_box>
            where
                T: 'm;

            const MEMORY: Room<T> = Memory::with(Backed { state: State::new(), rooms: PolarRooms::new() });
            const CAPACITIES: Capacities = Capacities {
                candidates: CANDIDATES,
                particles: PARTICLES,
                components: (MAP_PAGES + MOVING_MAP_PAGES) * scphd::storage::PAGE_LEN,
                components_in_all: (PAGES + MOVING_PAGES) * scphd::storage::PAGE_LEN,
                measurements: MEASUREMENTS,
            };
            const RAM_PARTS: [RamPart; 6] = ram::<T>().parts();

            fn start<'m>(
                head: &impl Parameters<Planar>,
                memory: &'m mut Self::Memory,
            ) -> Result<Self::Filter<'m>, Refusal>
            where
                T: 'm,
            {
                memory.start(head, 0)
            }
        }
    )+};
}

on_board! {
    Planar: false;
    BlackBox: true;
}
