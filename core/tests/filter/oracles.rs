//! Numbers from independent implementations, read from `tests/oracles`; closed forms beside them.

use crate::alone::{Alone, Models};
use crate::*;
use nalgebra::{Matrix2, Matrix2x3, Vector2};
use scphd_shared_data::oracle;
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn vector(value: &Value) -> Vector2<f64> {
    Vector2::new(number(&value[0]), number(&value[1]))
}

fn symmetric(value: &Value) -> Symmetric<Vector2<f64>> {
    Symmetric::from_fn(|row, column| number(&value[row][column]))
}

fn components(value: &Value) -> Vec<Component<Vector2<f64>>> {
    let component = |value: &Value| Component {
        label: 0,
        ln_weight: number(&value["weight"]).ln(),
        mean: vector(&value["mean"]),
        covariance: symmetric(&value["cov"]),
    };
    value.as_array().unwrap().iter().map(component).collect()
}

/// A sensor that measures position itself.
#[derive(Clone, Copy)]
struct Direct {
    noise: Symmetric<Vector2<f64>>,
}

impl Sensor for Direct {
    type Pose = PlanarPose<f64>;
    type Measurement = Vector2<f64>;
    type Frame = PlanarFrame<f64>;
    const SORTED_BY: usize = 0;
    const SORTED_BY_ANGLE: bool = false;

    fn frame(&self, pose: &PlanarPose<f64>) -> PlanarFrame<f64> {
        RangeBearing::new(1.0, 1.0).unwrap().frame(pose)
    }
    fn expect(&self, _: &PlanarFrame<f64>, feature: &Vector2<f64>) -> Option<Expected<Vector2<f64>, Vector2<f64>>> {
        Some(Expected { measurement: *feature, jacobian: Matrix2::identity() })
    }
    fn innovation(&self, measured: &Vector2<f64>, expected: &Vector2<f64>) -> Vector2<f64> {
        measured - expected
    }
    fn noise(&self) -> &Symmetric<Vector2<f64>> {
        &self.noise
    }
    fn invert(&self, _: &PlanarFrame<f64>, measured: &Vector2<f64>) -> Option<Inverse<Vector2<f64>, Vector2<f64>>> {
        Some(Inverse { feature: *measured, jacobian: Matrix2::identity() })
    }

    // It tells nothing of where it is.
    fn by_pose(
        &self,
        _: &PlanarFrame<f64>,
        _: &Vector2<f64>,
        _: &Expected<Vector2<f64>, Vector2<f64>>,
    ) -> Matrix2x3<f64> {
        Matrix2x3::zeros()
    }
}

/// The same probability of detection everywhere.
struct Everywhere(f64);

impl<F> FieldOfView<F, Vector2<f64>, Vector2<f64>> for Everywhere {
    fn detection_probability(&self, _: &F, _: &Vector2<f64>, _: &Vector2<f64>) -> f64 {
        self.0
    }
    fn bounds(&self, _: &F) -> Bounds<Vector2<f64>> {
        Bounds::EVERYWHERE
    }
}

struct Intensity(f64);

impl Clutter<Vector2<f64>> for Intensity {
    fn ln_intensity(&self, _: &Vector2<f64>) -> f64 {
        self.0.ln()
    }
}

/// What one scan makes of a prior map, seen from the origin by one particle: ln L and the posterior map. A lone sample, which the
/// update weighs, and two of the same pose, which are weighed before it, must say the same.
fn one_scan<S: Sensor<Pose = PlanarPose<f64>, Measurement = Vector2<f64>> + Copy>(
    sensor: S,
    p_d: f64,
    kappa: f64,
    births: f64,
    config: Config<f64>,
    prior: &[Component<Vector2<f64>>],
    scan: &[Vector2<f64>],
) -> (f64, Vec<Component<Vector2<f64>>>) {
    let origin = PlanarPose::new(0.0, 0.0, 0.0);
    let mut state = Box::new(State::<PlanarPose<f64>, 1, 2, MapMemory<Static<Vector2<f64>>, 1, 16, 16, 64>>::new());
    let mut by = |samples| {
        let sensing = Sensing { sensor, field_of_view: Everywhere(p_d), clutter: Intensity(kappa) };
        let models = Models { motion: KnownPose::new(), sensing };
        let config = Config { particles: 1, samples, ..config };
        let mut filter = Alone::new(models, Births::of_static(births), config, &mut *state).unwrap();
        filter.reset(origin, 1).unwrap();
        filter.load_map(prior).unwrap();
        filter.predict(&origin, 1.0).unwrap();
        let report = filter.scan(scan).unwrap();
        assert!(report.health.is_good() || report.health == Health::INNOVATION_HIGH, "{:?}", report.health);
        assert_eq!((report.candidates, report.n_eff.round()), (samples, samples as f64));
        let ln_l = filter.ln_likelihoods()[0];
        assert!((report.ln_evidence - ln_l).abs() < 1e-12);
        (ln_l, report.in_view, filter.map(0).copied().collect::<Vec<_>>())
    };
    let (lone, two) = (by(1), by(2));
    assert!((lone.0 - two.0).abs() < 1e-12 && (lone.1, &lone.2) == (two.1, &two.2));
    (lone.0, lone.2)
}

/// Nothing pruned, nothing merged, nothing born.
fn bare() -> Config<f64> {
    Config { prune_weight: 1e-300, merge_distance: 0.0, negligible: 1e-300, ..Config::default() }
}

/// Every component of `expected` has a counterpart of the same weight, mean and covariance, and nothing is left over.
fn assert_same_mixture(ours: &[Component<Vector2<f64>>], expected: &[Component<Vector2<f64>>]) {
    let mut free: Vec<_> = ours.to_vec();
    for component in expected {
        let distance = |other: &Component<Vector2<f64>>| {
            let weight = (other.ln_weight - component.ln_weight).exp_m1().abs();
            let mean = (other.mean - component.mean).norm();
            let covariance = (other.covariance.to_matrix() - component.covariance.to_matrix()).norm();
            weight.max(mean).max(covariance)
        };
        let place = (0..free.len()).min_by(|&a, &b| distance(&free[a]).total_cmp(&distance(&free[b])));
        let nearest = free.swap_remove(place.expect("a component is missing"));
        assert!(distance(&nearest) < 1e-9, "{component:?}\nis nearest to\n{nearest:?}");
    }
    assert!(free.is_empty(), "left over: {free:?}");
}

#[test]
fn gmphd_update_linear() {
    let file = oracle("gmphd_update.json");
    let case = &file["cases"][0];
    let scan: Vec<_> = case["measurements"].as_array().unwrap().iter().map(vector).collect();
    let sensor = Direct { noise: symmetric(&case["R"]) };
    let (p_d, kappa) = (number(&case["pd"]), number(&case["clutter_density"]));
    let (ln_l, posterior) = one_scan(sensor, p_d, kappa, 0.0, bare(), &components(&case["prior"]), &scan);
    assert_same_mixture(&posterior, &components(&case["posterior"]));

    // Confirmed by Monte Carlo; the oracle counts the clutter's own exp(−λ) in.
    let likelihood = &file["single_cluster_likelihood"];
    let expected = number(&likelihood["log_likelihood"]) + number(&likelihood["lambda_c"]);
    assert!((ln_l - expected).abs() < 1e-9, "{ln_l} against {expected}");
    assert!((expected - number(&likelihood["lambda_c"]) + 14.2955).abs() < 1e-4);
}

#[test]
fn gmphd_update_range_bearing() {
    let file = oracle("gmphd_update.json");
    let case = &file["cases"][1];
    // The oracle has bearing first.
    let swapped = |value: &Value| Vector2::new(number(&value[1]), number(&value[0]));
    let scan: Vec<_> = case["measurements_bearing_range"].as_array().unwrap().iter().map(swapped).collect();
    let r = symmetric(&case["R_bearing_range"]);
    let sensor = RangeBearing::new(r.get(1, 1).sqrt(), r.get(0, 0).sqrt()).unwrap();
    let (p_d, kappa) = (number(&case["pd"]), number(&case["clutter_density"]));
    let (_, posterior) = one_scan(sensor, p_d, kappa, 0.0, bare(), &components(&case["prior"]), &scan);
    assert_same_mixture(&posterior, &components(&case["posterior"]));
}

#[test]
fn vo_and_ma_reduction() {
    let file = oracle("gm_merge_prune.json");
    let config = Config { prune_weight: number(&file["prune_T"]), merge_distance: number(&file["merge_U"]), ..bare() };
    // An empty scan of a sensor that sees next to nothing leaves the mixture to the reduction alone.
    let sensor = Direct { noise: Symmetric::from_diagonal([1.0, 1.0]) };
    let (_, reduced) = one_scan(sensor, 1e-12, 1.0, 0.0, config, &components(&file["input"]), &[]);
    assert_same_mixture(&reduced, &components(&file["vo_ma"]));
}

fn feature(weight: f64, x: f64, y: f64) -> Component<Vector2<f64>> {
    Component {
        label: 0,
        ln_weight: weight.ln(),
        mean: Vector2::new(x, y),
        covariance: Symmetric::from_diagonal([0.5, 0.25]),
    }
}

fn unit_sensor() -> Direct {
    Direct { noise: Symmetric::from_diagonal([0.5, 0.75]) }
}

#[test]
fn an_unseen_feature_lowers_the_likelihood() {
    // One feature in view and nothing measured: L = exp(−p_D w). With the sign of (5.24) as printed it would be
    // exp(+w), and a pose would be the better the more it fails to see.
    let (ln_l, posterior) = one_scan(unit_sensor(), 0.9, 0.01, 0.0, bare(), &[feature(0.8, 3.0, 4.0)], &[]);
    assert!((ln_l + 0.9 * 0.8).abs() < 1e-15, "{ln_l}");
    // The missed component keeps w (1 − p_D).
    assert_same_mixture(&posterior, &[feature(0.8 * 0.1, 3.0, 4.0)]);
}

#[test]
fn a_detection_in_closed_form() {
    // S = P + R is the unit matrix, and the measurement lies (1, 0) off: N = exp(−½)/2π.
    let density = (-0.5_f64).exp() / core::f64::consts::TAU;
    let (p_d, w, kappa, birth) = (0.9, 0.8, 0.02, 0.01);
    let eta = kappa + birth + p_d * w * density;
    let (ln_l, posterior) =
        one_scan(unit_sensor(), p_d, kappa, birth, bare(), &[feature(w, 3.0, 4.0)], &[Vector2::new(4.0, 4.0)]);
    assert!((ln_l - (eta.ln() - p_d * w)).abs() < 1e-14);
    let missed = feature(w * (1.0 - p_d), 3.0, 4.0);
    let gain = Vector2::new(0.5, 0.25);
    let detected = Component {
        label: 0,
        ln_weight: (p_d * w * density / eta).ln(),
        mean: Vector2::new(3.0 + gain.x, 4.0),
        covariance: Symmetric::from_diagonal([0.5 * (1.0 - gain.x), 0.25 * (1.0 - gain.y)]),
    };
    let born = Component {
        label: 0,
        ln_weight: (birth / eta).ln(),
        mean: Vector2::new(4.0, 4.0),
        covariance: unit_sensor().noise,
    };
    assert_same_mixture(&posterior, &[missed, detected, born]);
}

#[test]
fn merging_keeps_mass_mean_and_covariance() {
    let parts = [feature(0.5, 0.0, 0.0), feature(0.3, 0.4, -0.3), feature(0.2, -0.2, 0.1)];
    let config = Config { merge_distance: 100.0, ..bare() };
    let (_, merged) = one_scan(unit_sensor(), 1e-15, 1.0, 0.0, config, &parts, &[]);
    assert_eq!(merged.len(), 1);
    let mass: f64 = parts.iter().map(|part| part.ln_weight.exp()).sum();
    let mean = parts.iter().fold(Vector2::zeros(), |sum, part| sum + part.mean * part.ln_weight.exp()) / mass;
    let covariance = parts.iter().fold(Matrix2::zeros(), |sum, part| {
        let offset = part.mean - mean;
        sum + (part.covariance.to_matrix() + offset * offset.transpose()) * (part.ln_weight.exp() / mass)
    });
    assert!((merged[0].ln_weight.exp() - mass).abs() < 1e-14);
    assert!((merged[0].mean - mean).norm() < 1e-14);
    assert!((merged[0].covariance.to_matrix() - covariance).norm() < 1e-14);
}
