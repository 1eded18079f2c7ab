//! Models of a user that return invalid values: none of them makes a weight or a stored feature non-finite, or causes an endless
//! loop.

use crate::numerics::work::limited;
use crate::tests::alone::{Alone, Models};
use crate::*;
use core::sync::atomic::{AtomicUsize, Ordering};
use nalgebra::{Matrix2, Matrix2x3, SVector, Vector2, Vector3};
use std::boxed::Box;
use std::vec::Vec;

/// Values that a model returns instead of a valid one.
const HOSTILE: [f64; 10] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -f64::MAX, 0.0, -1.0, 1.0, 1.5, 5e-324];

/// The function of a model that returns them.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Lie {
    Detection,
    Bounds,
    Clutter,
    ClutterPerScan,
    Expected,
    Jacobian,
    Innovation,
    OwnNoise,
    Inverse,
    InverseJacobian,
    ByPose,
    Birth,
    BirthCovariance,
    BirthWeight,
    Pose,
    Spread,
    Transition,
}

const LIES: [Lie; 17] = [
    Lie::Detection,
    Lie::Bounds,
    Lie::Clutter,
    Lie::ClutterPerScan,
    Lie::Expected,
    Lie::Jacobian,
    Lie::Innovation,
    Lie::OwnNoise,
    Lie::Inverse,
    Lie::InverseJacobian,
    Lie::ByPose,
    Lie::Birth,
    Lie::BirthCovariance,
    Lie::BirthWeight,
    Lie::Pose,
    Lie::Spread,
    Lie::Transition,
];

/// A model that returns `number` at every `period`th call of the function `lie`.
struct Liar {
    lie: Lie,
    number: f64,
    period: usize,
    asked: AtomicUsize,
    noise: Symmetric<Vector2<f64>>,
    /// Number of components of the birth intensity.
    births: usize,
}

impl Liar {
    fn new(lie: Lie, number: f64, period: usize) -> Self {
        let noise = Symmetric::from_diagonal([0.04, 0.04]);
        Self { lie, number, period, asked: AtomicUsize::new(0), noise, births: 4 }
    }

    fn says(&self, lie: Lie, truth: f64) -> f64 {
        let lies = lie == self.lie && self.asked.fetch_add(1, Ordering::Relaxed).is_multiple_of(self.period);
        if lies { self.number } else { truth }
    }
}

impl Motion for &Liar {
    type Pose = PlanarPose<f64>;
    type Control = Vector2<f64>;

    fn admits(&self, _: &Vector2<f64>) -> bool {
        true
    }
    fn rates(&self, _: &Vector2<f64>) -> Rates<f64> {
        Rates::NONE
    }
    fn propagate(&self, pose: &PlanarPose<f64>, control: &Vector2<f64>, dt: f64) -> PlanarPose<f64> {
        PlanarPose { x_m: self.says(Lie::Pose, pose.x_m + control.x * dt), ..*pose }
    }
    fn sample(&self, pose: &PlanarPose<f64>, control: &Vector2<f64>, dt: f64, noise: &mut Noise) -> PlanarPose<f64> {
        let moved = self.propagate(pose, control, dt);
        PlanarPose { y_m: moved.y_m + 0.1 * noise.normal::<f64>(), ..moved }
    }
    fn linearise(&self, _: &PlanarPose<f64>, _: &Vector2<f64>, dt: f64) -> Linearised<Vector3<f64>> {
        let variance = self.says(Lie::Spread, 0.01 * dt);
        let mut transition = nalgebra::Matrix3::identity();
        transition[(0, 0)] = self.says(Lie::Transition, 1.0);
        Linearised { transition, noise: Symmetric::from_diagonal([variance, 0.01 * dt, 0.0]) }
    }
}

impl Sensor for &Liar {
    type Pose = PlanarPose<f64>;
    type Measurement = Vector2<f64>;
    type Frame = Vector2<f64>;
    const SORTED_BY: usize = 0;
    const SORTED_BY_ANGLE: bool = false;
    const SIFTED_BY: Option<usize> = Some(1);

    fn frame(&self, pose: &PlanarPose<f64>) -> Vector2<f64> {
        Vector2::new(pose.x_m, pose.y_m)
    }
    fn expect(&self, frame: &Vector2<f64>, feature: &Vector2<f64>) -> Option<Expected<Vector2<f64>, Vector2<f64>>> {
        let offset = feature - frame;
        let jacobian = Matrix2::new(self.says(Lie::Jacobian, 1.0), 0.0, 0.0, 1.0);
        Some(Expected { measurement: Vector2::new(offset.x, self.says(Lie::Expected, offset.y)), jacobian })
    }
    fn innovation(&self, measured: &Vector2<f64>, expected: &Vector2<f64>) -> Vector2<f64> {
        let difference = measured - expected;
        Vector2::new(self.says(Lie::Innovation, difference.x), difference.y)
    }
    fn noise(&self) -> &Symmetric<Vector2<f64>> {
        &self.noise
    }
    fn noise_of(&self, _: &Vector2<f64>, _: &Vector2<f64>) -> Option<Symmetric<Vector2<f64>>> {
        let variance = || self.says(Lie::OwnNoise, 0.04);
        (self.lie == Lie::OwnNoise).then(|| Symmetric::from_diagonal([variance(), 0.04]))
    }
    fn expected_birth(&self, frame: &Vector2<f64>, index: usize) -> Option<Component<Vector2<f64>>> {
        let variance = self.says(Lie::BirthCovariance, 1.0);
        (index < self.births).then(|| Component {
            label: 0,
            ln_weight: self.says(Lie::BirthWeight, -3.0),
            mean: frame + Vector2::new(self.says(Lie::Birth, index as f64), 2.0),
            covariance: Symmetric::from_diagonal([variance, 1.0]),
        })
    }
    fn invert(&self, frame: &Vector2<f64>, measured: &Vector2<f64>) -> Option<Inverse<Vector2<f64>, Vector2<f64>>> {
        let feature = frame + measured;
        let jacobian = Matrix2::new(1.0, 0.0, 0.0, self.says(Lie::InverseJacobian, 1.0));
        Some(Inverse { feature: Vector2::new(self.says(Lie::Inverse, feature.x), feature.y), jacobian })
    }

    fn by_pose(&self, _: &Vector2<f64>, _: &Vector2<f64>, _: &Expected<Vector2<f64>, Vector2<f64>>) -> Matrix2x3<f64> {
        Matrix2x3::new(self.says(Lie::ByPose, -1.0), 0.0, 0.0, 0.0, -1.0, 0.0)
    }
}

impl FieldOfView<Vector2<f64>, Vector2<f64>, Vector2<f64>> for &Liar {
    fn detection_probability(&self, _: &Vector2<f64>, _: &Vector2<f64>, _: &Vector2<f64>) -> f64 {
        self.says(Lie::Detection, 0.9)
    }
    fn bounds(&self, frame: &Vector2<f64>) -> Bounds<Vector2<f64>> {
        Bounds::around(frame, self.says(Lie::Bounds, 20.0))
    }
}

impl Clutter<Vector2<f64>> for &Liar {
    fn ln_intensity(&self, _: &SVector<f64, 2>) -> f64 {
        self.says(Lie::Clutter, -4.0)
    }
    fn per_scan(&self) -> f64 {
        self.says(Lie::ClutterPerScan, 3.0)
    }
}

type Filter<'s, 'l> = Alone<'s, &'l Liar, Sensing<&'l Liar, &'l Liar, &'l Liar>>;
type Memory = State<
    PlanarPose<f64>,
    3,
    6,
    MapMemory<Static<Vector2<f64>>, 3, 24, 8, 64>,
    MapMemory<Dynamic<Vector2<f64>>, 3, 12, 4, 32>,
>;

const BIRTHS: Births<f64> = Births { of_static: 0.01, of_moving: 0.01 };

fn models(liar: &Liar) -> Models<&Liar, Sensing<&Liar, &Liar, &Liar>> {
    Models { motion: liar, sensing: Sensing { sensor: liar, field_of_view: liar, clutter: liar } }
}

fn check<N: Vector<Scalar = f64>>(component: &Component<N>) -> bool {
    component.is_usable()
}

#[test]
fn no_lie_becomes_a_weight_or_a_feature() {
    let mut state = Box::new(Memory::new());
    let informed = |drawn| Proposal::Informed(Informed { sampled_fraction: drawn, ..Informed::default() });
    for (lie, number) in LIES.iter().flat_map(|&lie| HOSTILE.iter().map(move |&number| (lie, number))) {
        for period in [1, 2, 7, 3] {
            for proposal in [Proposal::Blind, informed(1.0), informed(0.5)] {
                let what = || std::format!("{lie:?} {number} every {period} with {proposal:?}");
                let liar = Liar::new(lie, number, period);
                state.clear();
                let config =
                    Config { particles: 3, samples: 2, proposal, plausible: Plausible::ANYTHING, ..Config::default() };
                let mut filter = Filter::new(models(&liar), BIRTHS, config, &mut *state).unwrap();
                filter.reset(PlanarPose::ZERO, 1).unwrap();
                for step in 0..5 {
                    let scan: Vec<_> =
                        (0..8).map(|k| Vector2::new(f64::from(k) - 3.0, 2.0 - 0.1 * f64::from(step))).collect();
                    let work = || {
                        filter.predict(&Vector2::new(1.0, 0.0), 0.1).unwrap();
                        filter.scan(&scan).unwrap()
                    };
                    limited(1_000_000, work);
                    let total: f64 = filter.candidates().iter().map(|candidate| candidate.ln_weight.exp()).sum();
                    assert!((total - 1.0).abs() < 1e-9, "{}: weights sum to {total}", what());
                    assert!(filter.candidates().iter().all(|candidate| candidate.pose.is_finite()), "{}", what());
                    assert!(filter.ln_likelihoods().iter().all(|ln_l| *ln_l < f64::INFINITY), "{}", what());
                    for particle in 0..filter.particles() {
                        assert!(filter.map(particle).all(check), "{}", what());
                        assert!(filter.moving_map(particle).all(check), "{}", what());
                    }
                    let map = filter.estimate_map(&mut [Component::ZERO; 8]);
                    assert!(map.expected_features.is_finite(), "{}", what());
                }
            }
        }
    }
}

#[test]
fn endless_births_are_refused_or_limited() {
    let mut state = Box::new(Memory::new());
    let config = Config { particles: 3, samples: 2, ..Config::default() };
    let mut liar = Liar::new(Lie::Birth, 0.0, usize::MAX);
    for births in [65, usize::MAX] {
        liar.births = births;
        let (refused, _) = limited(1000, || Filter::new(models(&liar), BIRTHS, config, &mut *state).err());
        assert_eq!(refused, Some(SetupError::TooManyBirths { capacity: 64 }));
    }
    liar.births = 64;
    assert!(Filter::new(models(&liar), BIRTHS, config, &mut *state).is_ok());
    // A sensor with more components of the birth intensity away from the origin than at it.
    let endless = Endless { noise: Symmetric::from_diagonal([0.04, 0.04]) };
    let models = Models {
        motion: Unicycle::new(Step::Arc, ControlNoise::white(0.1, 0.1)).unwrap(),
        sensing: Sensing {
            sensor: endless,
            field_of_view: Everywhere,
            clutter: UniformClutter::of_scan(1.0, 1.0).unwrap(),
        },
    };
    state.clear();
    let mut filter = Alone::new(models, Births::of_static(0.01), config, &mut *state).unwrap();
    filter.reset(PlanarPose::new(5.0, 0.0, 0.0), 1).unwrap();
    for _ in 0..3 {
        filter.predict(&UnicycleControl { speed_mps: 1.0, rate_radps: 0.0 }, 0.1).unwrap();
        let (report, _) = limited(1_000_000, || filter.scan(&[Vector2::new(1.0, 2.0)]).unwrap());
        assert!(report.health.contains(Health::COMPONENTS_LOST), "{report:?}");
    }
}

/// Two births at the origin, and endless ones elsewhere.
struct Endless {
    noise: Symmetric<Vector2<f64>>,
}

impl Sensor for Endless {
    type Pose = PlanarPose<f64>;
    type Measurement = Vector2<f64>;
    type Frame = Vector2<f64>;
    const SORTED_BY: usize = 0;
    const SORTED_BY_ANGLE: bool = false;

    fn frame(&self, pose: &PlanarPose<f64>) -> Vector2<f64> {
        Vector2::new(pose.x_m, pose.y_m)
    }
    fn expect(&self, frame: &Vector2<f64>, feature: &Vector2<f64>) -> Option<Expected<Vector2<f64>, Vector2<f64>>> {
        Some(Expected { measurement: feature - frame, jacobian: Matrix2::identity() })
    }
    fn innovation(&self, measured: &Vector2<f64>, expected: &Vector2<f64>) -> Vector2<f64> {
        measured - expected
    }
    fn noise(&self) -> &Symmetric<Vector2<f64>> {
        &self.noise
    }
    fn expected_birth(&self, frame: &Vector2<f64>, index: usize) -> Option<Component<Vector2<f64>>> {
        let covariance = Symmetric::from_diagonal([1.0, 1.0]);
        let mean = frame + Vector2::new(index as f64, 0.0);
        (index < 2 || frame.x != 0.0).then_some(Component { label: 0, ln_weight: -5.0, mean, covariance })
    }
    fn invert(&self, _: &Vector2<f64>, _: &Vector2<f64>) -> Option<Inverse<Vector2<f64>, Vector2<f64>>> {
        None
    }

    fn by_pose(&self, _: &Vector2<f64>, _: &Vector2<f64>, _: &Expected<Vector2<f64>, Vector2<f64>>) -> Matrix2x3<f64> {
        Matrix2x3::zeros()
    }
}

struct Everywhere;

impl FieldOfView<Vector2<f64>, Vector2<f64>, Vector2<f64>> for Everywhere {
    fn detection_probability(&self, _: &Vector2<f64>, _: &Vector2<f64>, _: &Vector2<f64>) -> f64 {
        0.9
    }
    fn bounds(&self, _: &Vector2<f64>) -> Bounds<Vector2<f64>> {
        Bounds::EVERYWHERE
    }
}

/// The `check` of a user's model is called, and its error returned.
#[test]
fn a_model_whose_check_fails_is_refused() {
    struct Wrong;
    impl Clutter<Vector2<f64>> for Wrong {
        fn check(&self) -> Result<(), ModelError> {
            PolarBirths::new(PolarGrid { nearest_m: f64::NAN, farthest_m: 1.0, rings: 2, sectors: 1, weight: 1.0 })
                .map(|_| ())
        }
        fn ln_intensity(&self, _: &SVector<f64, 2>) -> f64 {
            0.0
        }
    }
    let liar = Liar::new(Lie::Birth, 0.0, usize::MAX);
    let wrong = Models { motion: &liar, sensing: Sensing { sensor: &liar, field_of_view: &liar, clutter: Wrong } };
    let mut state = Box::new(Memory::new());
    let config = Config { particles: 3, ..Config::default() };
    let refused = Alone::new(wrong, Births::of_static(0.01), config, &mut *state).map(|_| ()).unwrap_err();
    assert!(matches!(refused, SetupError::Model(ModelError { field: "nearest_m", .. })), "{refused:?}");
    for bad in [[0.0, 1.0], [1.0, -1.0], [f64::NAN, 1.0], [1.0, f64::INFINITY]] {
        let liar = Liar { noise: Symmetric::from_diagonal(bad), ..Liar::new(Lie::Birth, 0.0, usize::MAX) };
        let refused = Filter::new(models(&liar), BIRTHS, config, &mut *state).map(|_| ()).unwrap_err();
        assert!(matches!(refused, SetupError::Model(ModelError { field: "noise", .. })), "{refused:?}");
    }
}
