//! RAM of a state: the total for a vehicle, and the cost of each capacity.

use nalgebra::{Vector2, Vector3};
use scphd::models::PlanarPose;
use scphd::numerics::{Bounds, LnSum, Symmetric};
use scphd::storage::{Candidate, MapMemory, NoMoving, PAGE_LEN, Static, UpdateMemory};
use scphd::{Component, DetectorMemory, State};

type Pose = PlanarPose<f32>;

const PARTICLES: usize = 32;
const CANDIDATES: usize = 64;
const PAGES: usize = 432;
const MAP_PAGES: usize = 32;
const MEASUREMENTS: usize = 64;
const VIEW: usize = 512;

/// Size of the state and of its detector's scratch memory with capacities increased by these numbers, static features only.
macro_rules! bytes {
    ($particles:expr, $candidates:expr, $pages:expr, $map_pages:expr, $measurements:expr, $view:expr) => {
        size_of::<
            State<
                Pose,
                { PARTICLES + $particles },
                { CANDIDATES + $candidates },
                MapMemory<
                    Static<Vector2<f32>>,
                    { PARTICLES + $particles },
                    { PAGES + $pages },
                    { MAP_PAGES + $map_pages },
                    { VIEW + $view },
                >,
            >,
        >() + size_of::<DetectorMemory<Vector2<f32>, { MEASUREMENTS + $measurements }>>()
    };
}

/// An index or a counter.
const INDEX: usize = size_of::<u16>();
const COMPONENT: usize = size_of::<Component<Vector2<f32>>>();
const SCALAR: usize = size_of::<f32>();

#[test]
fn a_vehicle_fits_160_kib() {
    let total = bytes!(0, 0, 0, 0, 0, 0);
    assert!(total < 160 * 1024, "{total} bytes");
}

/// Capacities grow by eight at a time, so that padding of the index arrays has no effect.
#[test]
fn every_capacity_costs_what_its_arrays_cost() {
    let total = bytes!(0, 0, 0, 0, 0, 0);
    // Label, weight, mean, covariance.
    assert_eq!(COMPONENT, size_of::<u32>() + 6 * SCALAR);
    let candidate = size_of::<Candidate<Pose>>();

    // The selected candidate, two covariances and the survivor's index; a row of pages, with its length, the number of distant
    // pages and their bounding box; its row before and after an update, and a place in the list of free rows.
    let spread = size_of::<Symmetric<Vector3<f32>>>();
    let row = (MAP_PAGES + 2) * INDEX + size_of::<Bounds<Vector2<f32>>>();
    // Waiting births: words of their measurements, weights, the pose of the vehicle, Σ p_D w of missed ones, and two words of
    // associated ones.
    let (pose, word) = (3 * SCALAR, size_of::<u64>());
    let waiting = (word + 2 * SCALAR) + pose + SCALAR + 2 * word;
    let particle = candidate + 2 * spread + INDEX + row + 3 * INDEX + waiting;
    assert_eq!(bytes!(8, 0, 0, 0, 0, 0) - total, 8 * particle, "particles");

    // The pose and its weight, and ln L; the difference of its step, for waiting births.
    assert_eq!(bytes!(0, 8, 0, 0, 0, 0) - total, 8 * (candidate + SCALAR + pose), "candidates");

    // Components, their weights, their bounding box and their number; a reference count and a place in the list of free pages.
    let page = (PAGE_LEN * (COMPONENT + SCALAR) + size_of::<Bounds<Vector2<f32>>>() + INDEX).next_multiple_of(SCALAR);
    assert_eq!(bytes!(0, 0, 8, 0, 0, 0) - total, 8 * (page + 2 * INDEX), "pages");

    // An index in the row of every particle, and in that of set-aside pages.
    assert_eq!(bytes!(0, 0, 0, 8, 0, 0) - total, 8 * (PARTICLES + 1) * INDEX, "pages of a map");

    // Range, bearing and the intensity of clutter and births; and the sum η.
    assert_eq!(bytes!(0, 0, 0, 0, 8, 0) - total, 8 * (3 * SCALAR + size_of::<LnSum<f32>>()), "measurements");

    // The component, its origin, its rank, and its links in the lists of the reduction.
    let (origin, ranked, linked) = (2 * SCALAR, SCALAR + 2 * INDEX, 3 * INDEX);
    assert_eq!(bytes!(0, 0, 0, 0, 0, 8) - total, 8 * (COMPONENT + origin + ranked + linked), "view");
}

#[test]
fn a_word_of_waiting_births_costs_what_its_documentation_says() {
    type Of<const WAITING: usize> = State<
        Pose,
        PARTICLES,
        CANDIDATES,
        MapMemory<Static<Vector2<f32>>, PARTICLES, PAGES, MAP_PAGES, VIEW>,
        NoMoving,
        WAITING,
    >;
    // 64 measurements: position and covariance, the intensity without features, p_D w of both kinds. For every particle the
    // measurements of its waiting births, and the associated ones of both kinds.
    let word = 64 * 8 * SCALAR + PARTICLES * 3 * size_of::<u64>();
    assert_eq!([size_of::<Of<2>>(), size_of::<Of<4>>()].map(|size| size - size_of::<Of<1>>()), [word, 3 * word]);
    assert_eq!(64 * 8 * SCALAR, 2048);
}

/// Size of a draft of an [`UpdateMemory`] with capacities increased by these numbers.
macro_rules! draft_bytes {
    ($map_pages:expr, $view:expr) => {
        size_of::<
            UpdateMemory<
                State<
                    Pose,
                    PARTICLES,
                    CANDIDATES,
                    MapMemory<Static<Vector2<f32>>, PARTICLES, PAGES, { MAP_PAGES + $map_pages }, { VIEW + $view }>,
                >,
                1,
            >,
        >()
    };
}

#[test]
fn a_draft_costs_what_its_documentation_says() {
    let total = draft_bytes!(0, 0);
    // A page, an index among the set-aside pages and one among the used ones.
    assert_eq!(draft_bytes!(8, 0) - total, 8 * (276 + 2 * INDEX));
    assert_eq!(draft_bytes!(0, 8) - total, 8 * 50);
}
