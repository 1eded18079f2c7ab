//! Bearing-only sensor in the plane, whose measurement cannot be inverted (5.2.1).

use super::{
    Expected, ExpectedOf, FieldOfView, InverseOf, ModelError, PlanarFrame, PlanarPose, RangeBearingWindow, Sensor,
    require,
};
use crate::{Bounds, Component, Real, Symmetric, Vector, wrap};
use core::fmt::Debug;
use nalgebra::{RowVector2, SMatrix, SVector, Vector1, Vector2};

/// A birth intensity that does not depend on the measurements, for areas where features are known to appear (5.2.1): a Gaussian
/// mixture of static features, which may move with the sensor frame.
pub trait BirthIntensity<F, D: Vector>: Debug + Sync {
    /// The component with this index, in map coordinates; `None` behind the last. Labels have no effect.
    fn component(&self, frame: &F, index: usize) -> Option<Component<D>>;
}

/// A sensor that measures only the bearing of a feature in the plane (rad, 0 ahead, positive to the left).
///
/// One bearing has no inverse. Features are therefore born from the birth intensity `B`, not from measurements; bearings from other
/// poses then decide which of its components remain.
///
/// ```
/// use scphd::models::{BearingOnly, PlanarPose, PolarBirths, PolarGrid, Sensor};
/// use nalgebra::Vector2;
///
/// let grid = PolarGrid { nearest_m: 2.0_f32, farthest_m: 20.0, rings: 4, sectors: 24, weight: 0.001 };
/// let camera = BearingOnly::new(0.01, PolarBirths::new(grid)?)?;
/// let frame = camera.frame(&PlanarPose::new(1.0, 0.0, 0.0));
/// let seen = camera.expect(&frame, &Vector2::new(1.0, 2.0)).unwrap();
/// assert_eq!(seen.measurement[0], core::f32::consts::FRAC_PI_2);
/// assert!(camera.invert(&frame, &seen.measurement).is_none());
/// # Ok::<(), scphd::models::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingOnly<T: Real, B> {
    noise: Symmetric<Vector1<T>>,
    births: B,
}

impl<T: Real, B> BearingOnly<T, B> {
    /// A sensor with this standard deviation of the noise, rad.
    ///
    /// # Errors
    /// It must lie between 1e-6 and 10.
    pub fn new(bearing_sigma_rad: T, births: B) -> Result<Self, ModelError> {
        let usable = bearing_sigma_rad >= T::from_f64(1e-6) && bearing_sigma_rad <= T::from_f64(10.0);
        require(usable, "bearing_sigma_rad", "between 1e-6 and 10 rad")?;
        Ok(Self { noise: Symmetric::from_diagonal([bearing_sigma_rad * bearing_sigma_rad]), births })
    }
}

impl<T: Real, B: BirthIntensity<PlanarFrame<T>, Vector2<T>>> Sensor for BearingOnly<T, B> {
    type Pose = PlanarPose<T>;
    type Measurement = Vector1<T>;
    type Frame = PlanarFrame<T>;

    const SORTED_BY: usize = 0;
    const SORTED_BY_ANGLE: bool = true;

    fn frame(&self, pose: &Self::Pose) -> Self::Frame {
        PlanarFrame::of(pose)
    }

    #[inline]
    fn expect(&self, frame: &Self::Frame, feature: &SVector<T, 2>) -> Option<ExpectedOf<Self>> {
        let [[dx, dy]] = (feature - frame.position).data.0;
        let squared = dx * dx + dy * dy;
        // The comparison is written so that NaN fails it.
        if !(squared > T::ZERO && squared.is_finite()) {
            return None;
        }
        Some(Expected {
            measurement: Vector1::new(wrap(dy.atan2(dx) - frame.heading_rad)),
            jacobian: RowVector2::new(-dy / squared, dx / squared),
        })
    }

    #[inline]
    fn innovation(&self, measured: &SVector<T, 1>, expected: &SVector<T, 1>) -> SVector<T, 1> {
        (measured - expected).map(wrap)
    }

    fn noise(&self) -> &Symmetric<Vector1<T>> {
        &self.noise
    }

    fn expected_birth(&self, frame: &Self::Frame, index: usize) -> Option<Component<Vector2<T>>> {
        self.births.component(frame, index)
    }

    /// `None`: any range is possible.
    fn invert(&self, _frame: &Self::Frame, _measured: &SVector<T, 1>) -> Option<InverseOf<Self>> {
        None
    }

    #[inline]
    fn by_pose(&self, frame: &Self::Frame, feature: &SVector<T, 2>, expected: &ExpectedOf<Self>) -> SMatrix<T, 1, 3> {
        frame.by_pose(&expected.jacobian, feature)
    }
}

/// The window for a sensor that does not measure the range on which p_D depends.
impl<T: Real> FieldOfView<PlanarFrame<T>, Vector2<T>, Vector1<T>> for RangeBearingWindow<T> {
    fn detection_probability(&self, frame: &PlanarFrame<T>, feature: &SVector<T, 2>, expected: &SVector<T, 1>) -> T {
        let [[bearing]] = expected.data.0;
        let [[dx, dy]] = (feature - frame.position).data.0;
        let range = (dx * dx + dy * dy).sqrt();
        FieldOfView::<PlanarFrame<T>, Vector2<T>, Vector2<T>>::detection_probability(
            self,
            frame,
            feature,
            &Vector2::new(range, bearing),
        )
    }

    fn bounds(&self, frame: &PlanarFrame<T>) -> Bounds<Vector2<T>> {
        FieldOfView::<PlanarFrame<T>, Vector2<T>, Vector2<T>>::bounds(self, frame)
    }
}

/// A polar grid around a sensor: rings, each farther than the previous one by the same factor, divided into sectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarGrid<T> {
    /// Range of the innermost ring, m; above zero.
    pub nearest_m: T,
    /// Range of the outermost ring, m.
    pub farthest_m: T,
    /// Number of rings, at least two.
    pub rings: u16,
    /// Number of components in a ring.
    pub sectors: u16,
    /// Weight of every component: the expected number of features that appear there between two scans.
    pub weight: T,
}

/// Birth intensity all around the sensor: one component for every cell of a checked [`PolarGrid`], with a size proportional to its
/// range. For a prior that knows only the range of the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarBirths<T> {
    grid: PolarGrid<T>,
}

impl<T: Real> PolarBirths<T> {
    /// The birth intensity of this grid.
    ///
    /// # Errors
    /// 1e-9 m ≤ nearest < farthest ≤ 1e9 m; at least two rings and one sector; a weight between 0 and 1e6.
    pub fn new(grid: PolarGrid<T>) -> Result<Self, ModelError> {
        require(grid.nearest_m >= T::from_f64(1e-9), "nearest_m", "at least 1e-9 m")?;
        let holds = grid.farthest_m > grid.nearest_m && grid.farthest_m <= T::from_f64(1e9);
        require(holds, "farthest_m", "above nearest_m and at most 1e9 m")?;
        require(grid.rings >= 2, "rings", "at least 2")?;
        require(grid.sectors >= 1, "sectors", "at least 1")?;
        require(grid.weight >= T::ZERO && grid.weight <= T::from_f64(1e6), "weight", "between 0 and 1e6")?;
        Ok(Self { grid })
    }
}

impl<T: Real> BirthIntensity<PlanarFrame<T>, Vector2<T>> for PolarBirths<T> {
    fn component(&self, frame: &PlanarFrame<T>, index: usize) -> Option<Component<Vector2<T>>> {
        let PolarGrid { nearest_m, farthest_m, weight, .. } = self.grid;
        let (rings, sectors) = (usize::from(self.grid.rings), usize::from(self.grid.sectors));
        let (ring, sector) = (index.checked_div(sectors)?, index.checked_rem(sectors)?);
        if ring >= rings {
            return None;
        }
        let step = (farthest_m / nearest_m).ln() / T::from_usize(rings - 1);
        let range = nearest_m * (step * T::from_usize(ring)).exp();
        let width = (T::PI + T::PI) / T::from_usize(sectors);
        let (sine, cosine) = (frame.heading_rad + width * T::from_usize(sector)).sin_cos();
        // Standard deviations of half the distance to the neighbours, in the directions of range and of bearing.
        let (along, across) = (range * step * T::from_f64(0.5), range * width * T::from_f64(0.5));
        let covariance = Symmetric::from_fn(|row, column| {
            let (a, b) = ([cosine, sine], [-sine, cosine]);
            let product = |v: [T; 2]| v.get(row).zip(v.get(column)).map_or(T::ZERO, |(&r, &c)| r * c);
            along * along * product(a) + across * across * product(b)
        });
        let mean = frame.position + Vector2::new(range * cosine, range * sine);
        Some(Component { label: 0, ln_weight: weight.ln(), mean, covariance })
    }
}

#[cfg(test)]
mod tests {
    use super::{BearingOnly, BirthIntensity, PolarBirths, PolarGrid};
    use crate::models::testing::check_sensor;
    use crate::tests::alone::{Alone, Models};
    use crate::{
        Births, Component, Config, KnownPose, MapMemory, Noise, PlanarFrame, PlanarPose, RangeBearingWindow, Sensing,
        Sensor, State, Static, UniformClutter, wrap,
    };
    use nalgebra::{Vector1, Vector2};
    use std::boxed::Box;
    use std::vec::Vec;

    const GRID: PolarGrid<f64> = PolarGrid { nearest_m: 2.0, farthest_m: 25.0, rings: 6, sectors: 24, weight: 2e-4 };

    fn births() -> PolarBirths<f64> {
        PolarBirths::new(GRID).unwrap()
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let sensor = BearingOnly::new(0.01, births()).unwrap();
        let pose = PlanarPose::new(1.0, -2.0, 2.9);
        let frame = sensor.frame(&pose);
        for step in 0..20 {
            let angle = 0.31 * f64::from(step);
            check_sensor(&sensor, &pose, &(frame.position + Vector2::new(angle.cos(), angle.sin()) * 7.0), 1e-8);
        }
        assert!(sensor.expect(&frame, &frame.position).is_none());
        assert_eq!(BearingOnly::new(0.0, births()).unwrap_err().field, "bearing_sigma_rad");
    }

    #[test]
    fn births_surround_the_sensor_once() {
        let frame = PlanarFrame::of(&PlanarPose::new(3.0, 1.0, 0.7));
        let births: Vec<_> = (0..).map_while(|index| births().component(&frame, index)).collect();
        assert_eq!(births.len(), 6 * 24);
        for birth in &births {
            let range = (birth.mean - frame.position).norm();
            assert!((1.999..25.001).contains(&range));
            assert!(birth.covariance.factor().is_some());
        }
        let mean = births.iter().map(|birth| birth.mean).sum::<Vector2<f64>>() / births.len() as f64;
        assert!((mean - frame.position).norm() < 1e-9);
    }

    #[test]
    fn an_invalid_grid_is_refused() {
        let refused = |grid| PolarBirths::new(grid).unwrap_err().field;
        assert_eq!(refused(PolarGrid { sectors: 0, ..GRID }), "sectors");
        assert_eq!(refused(PolarGrid { rings: 1, ..GRID }), "rings");
        for bad in [f64::NAN, 0.0, -1.0] {
            assert_eq!(refused(PolarGrid { nearest_m: bad, ..GRID }), "nearest_m");
        }
        for bad in [f64::NAN, 2.0, f64::INFINITY] {
            assert_eq!(refused(PolarGrid { farthest_m: bad, ..GRID }), "farthest_m");
        }
        for bad in [f64::NAN, -1e-9, f64::INFINITY, 1e300] {
            assert_eq!(refused(PolarGrid { weight: bad, ..GRID }), "weight");
        }
    }

    /// Bearings from a path around the landmarks determine their positions, although a single bearing does not.
    #[test]
    fn bearings_from_many_places_make_a_map() {
        let landmarks = [Vector2::new(8.0, 6.0), Vector2::new(12.0, -5.0), Vector2::new(3.0, -9.0)];
        let sensing = Sensing {
            sensor: BearingOnly::new(0.01, births()).unwrap(),
            field_of_view: RangeBearingWindow::full_circle(30.0, 0.95).unwrap(),
            clutter: UniformClutter::of_scan(1.0, core::f64::consts::TAU).unwrap(),
        };
        let models = Models { motion: KnownPose::new(), sensing };
        let config = Config { particles: 1, prune_weight: 1e-5, extraction_weight: 0.5, ..Config::default() };
        type Memory = State<PlanarPose<f64>, 1, 1, MapMemory<Static<Vector2<f64>>, 1, 128, 128, 2048>>;
        let mut state = Box::new(Memory::new());
        let mut filter = Alone::new(models, Births::NONE, config, &mut *state).unwrap();
        let mut noise = Noise::seeded(4);
        filter.reset(PlanarPose::new(0.0, 0.0, 0.0), 1).unwrap();
        for step in 0..150 {
            let pose = PlanarPose::new(0.1 * f64::from(step), 1.5 * (0.1 * f64::from(step)).sin(), 0.0);
            filter.predict(&pose, 0.1).unwrap();
            let mut scan = Vec::new();
            for landmark in &landmarks {
                // A landmark that the last scan missed would not be extracted.
                if step > 140 || noise.uniform::<f64>() < 0.95 {
                    let bearing = (landmark.y - pose.y_m).atan2(landmark.x - pose.x_m);
                    scan.push(Vector1::new(wrap(bearing + 0.01 * noise.normal::<f64>())));
                }
            }
            if noise.uniform::<f64>() < 0.6 {
                scan.push(Vector1::new(wrap(core::f64::consts::TAU * noise.uniform::<f64>())));
            }
            let report = filter.scan(&scan).unwrap();
            assert_eq!((report.births, report.lost), (0, 0));
        }
        let mut features = [Component::ZERO; 16];
        let map = filter.estimate_map(&mut features);
        let found = &features[..map.features];
        std::println!(
            "N̂ {}, {:?}",
            map.expected_features,
            found.iter().map(|f| (f.mean, f.ln_weight)).collect::<Vec<_>>()
        );
        for landmark in &landmarks {
            let nearest = found.iter().map(|feature| (feature.mean - landmark).norm()).fold(f64::MAX, f64::min);
            assert!(nearest < 0.3, "{landmark} is {nearest} m from the next feature");
        }
        assert_eq!(found.len(), 3);
    }
}
