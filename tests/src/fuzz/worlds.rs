//! Vehicles and their sensors for the fuzzer, in the plane and in space, with random models.

use super::draw::Draw;
use nalgebra::{Matrix3, Vector1, Vector2, Vector3, Vector4};
use scphd::Real;
use scphd::models::{
    Ackermann, AckermannControl, AckermannGeometry, Auv, AuvControl, AuvPose, BearingOnly, ControlNoise, FrustumLimits,
    KnownPose, MeasurementModel, ModelError, Motion, Mounting, PlanarPose, PolarBirths, PolarGrid, Pose, PositionOf,
    RangeBearing, RangeBearingElevation, RangeBearingLimits, RangeBearingWindow, Reading, Sensing, SonarLimits,
    SonarWindow, Step, StereoCamera, StereoFrustum, Unicycle, UnicycleControl, UniformClutter, pixel_noise, projection,
};
use scphd::numerics::Symmetric;
use std::fmt::Debug;
use std::marker::PhantomData;

/// Models of a vehicle with one sensor.
#[derive(Debug, Clone, Copy)]
pub struct Models<M, X> {
    pub motion: M,
    pub sensing: X,
}

pub type ModelsOf<W> = Models<<W as World>::Motion, <W as World>::Sensing>;
pub type FeatureOf<W> = PositionOf<<W as World>::Pose>;
pub type MeasurementOf<W> = <<W as World>::Sensing as MeasurementModel>::Measurement;

/// A vehicle with a sensor, and random inputs for it.
pub trait World: Sized {
    /// Its name in reports.
    const NAME: &'static str;
    /// `f32` or `f64`.
    type Scalar: Real;
    type Pose: Drawn<Scalar = Self::Scalar>;
    type Motion: Motion<Pose = Self::Pose, Control: Debug> + Copy + Debug;
    /// Models of measurement, field of view and clutter.
    type Sensing: MeasurementModel<Pose = Self::Pose, Sensor: Copy> + Copy + Debug;

    fn models(draw: &mut Draw) -> Result<ModelsOf<Self>, ModelError>;
    /// A random control from a pose.
    fn control(draw: &mut Draw, from: &Self::Pose) -> <Self::Motion as Motion>::Control;
    /// A random false measurement.
    fn clutter(draw: &mut Draw) -> MeasurementOf<Self>;
    /// Standard deviations of the difference of a measurement from the expected one.
    const SPREAD: &'static [f64];
    /// How far below the vehicle a feature may be, m; without effect in the plane.
    const DEPTH_M: f64 = 0.0;

    /// A random feature near a pose.
    fn feature(draw: &mut Draw, near: &Self::Pose) -> FeatureOf<Self> {
        near.feature(draw, Self::DEPTH_M)
    }
}

/// Random poses, in the plane or in space.
pub trait Drawn: Pose {
    /// A random start pose.
    fn drawn(draw: &mut Draw) -> Self;
    /// A random mounting of a sensor.
    fn mounting(draw: &mut Draw) -> Result<Mounting<Self::Scalar>, ModelError>;
    /// A random feature near this pose, at most this far below it, m.
    fn feature(&self, draw: &mut Draw, depth_m: f64) -> Self::Position;
}

impl<T: Real> Drawn for PlanarPose<T> {
    fn drawn(draw: &mut Draw) -> Self {
        let far = draw.magnitude(1.0, 1e5);
        Self::new(draw.real(-far, far), draw.real(-far, far), draw.real(-3.2, 3.2))
    }

    fn mounting(draw: &mut Draw) -> Result<Mounting<T>, ModelError> {
        Mounting::in_plane(draw.real(-4.0, 4.0), draw.real(-1.0, 1.0), draw.real(-3.2, 3.2))
    }

    fn feature(&self, draw: &mut Draw, _: f64) -> Vector2<T> {
        Vector2::new(place(draw, self.x_m, -25.0, 25.0), place(draw, self.y_m, -25.0, 25.0))
    }
}

impl<T: Real> Drawn for AuvPose<T> {
    fn drawn(draw: &mut Draw) -> Self {
        let far = draw.magnitude(1.0, 1e4);
        Self {
            yaw_rate_radps: draw.real(-0.2, 0.2),
            roll_rad: draw.real(-0.3, 0.3),
            pitch_rad: draw.real(-0.3, 0.3),
            ..Self::new(draw.real(-far, far), draw.real(-far, far), draw.real(-50.0, 0.0), draw.real(-3.2, 3.2))
        }
    }

    fn mounting(draw: &mut Draw) -> Result<Mounting<T>, ModelError> {
        let place = [draw.real(-1.0, 1.0), draw.real(-1.0, 1.0), draw.real(-0.5, 0.5)];
        Mounting::in_space(place, [draw.real(-0.3, 0.3), draw.real(-0.3, 0.3), draw.real(-3.2, 3.2)])
    }

    fn feature(&self, draw: &mut Draw, depth_m: f64) -> Vector3<T> {
        let (x, y) = (place(draw, self.x_m, -2.0, 2.0), place(draw, self.y_m, -2.0, 2.0));
        Vector3::new(x, y, place(draw, self.z_m, -depth_m, 0.0))
    }
}

/// A coordinate this far from `at`.
fn place<T: Real>(draw: &mut Draw, at: T, low: f64, high: f64) -> T {
    let place = at.to_f64() + draw.even(low, high);
    T::from_f64(draw.spoilt(place))
}

fn control_noise<T: Real>(draw: &mut Draw) -> ControlNoise<T> {
    ControlNoise {
        speed_sigma_mps: draw.real(0.0, 0.5),
        speed_sigma_ratio: draw.real(0.0, 0.2),
        turn_sigma: draw.real(0.0, 0.1),
        turn_sigma_ratio: draw.real(0.0, 0.2),
        interval_s: draw.real(0.0, 1.0),
    }
}

fn window<T: Real>(draw: &mut Draw) -> Result<RangeBearingWindow<T>, ModelError> {
    let near = draw.real(0.5, 0.99);
    let mut limits = RangeBearingLimits::full_circle(draw.real(8.0, 30.0), near);
    if draw.chance(0.5) {
        limits = RangeBearingLimits {
            range_min_m: draw.real(0.0, 2.0),
            range_edge_m: draw.real(0.0, 1.0),
            bearing_center_rad: draw.real(-3.0, 3.0),
            bearing_half_width_rad: draw.real(0.3, 3.5),
            bearing_edge_rad: draw.real(0.0, 0.2),
            probability_far: draw.real(0.1, 0.95),
            ..limits
        };
    }
    RangeBearingWindow::new(limits)
}

fn clutter<T: Real>(draw: &mut Draw, measure: T) -> Result<UniformClutter<T>, ModelError> {
    let per_scan = if draw.chance(0.1) { T::ZERO } else { T::from_f64(draw.magnitude(1e-3, 20.0)) };
    UniformClutter::of_scan(T::from_f64(draw.spoilt(per_scan.to_f64())), measure)
}

fn planar_clutter<T: Real>(draw: &mut Draw) -> Vector2<T> {
    Vector2::new(draw.real(0.0, 30.0), draw.real(-3.2, 3.2))
}

/// A unicycle with a range and bearing sensor.
#[derive(Debug)]
pub struct Rover<T>(PhantomData<T>);

impl<T: Real> World for Rover<T> {
    const NAME: &'static str = "rover";
    type Scalar = T;
    type Pose = PlanarPose<T>;
    type Motion = Unicycle<T>;
    type Sensing = Sensing<RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>>;
    const SPREAD: &'static [f64] = &[0.1, 0.01];

    fn models(draw: &mut Draw) -> Result<ModelsOf<Self>, ModelError> {
        let field_of_view = window(draw)?;
        let motion = Unicycle::new(if draw.chance(0.5) { Step::Arc } else { Step::Euler }, control_noise(draw))?;
        Ok(Models {
            motion,
            sensing: Sensing {
                sensor: RangeBearing::new(
                    T::from_f64(draw.magnitude(1e-3, 1.0)),
                    T::from_f64(draw.magnitude(1e-4, 0.2)),
                )?,
                field_of_view,
                clutter: clutter(draw, field_of_view.measure())?,
            },
        })
    }

    fn control(draw: &mut Draw, _: &PlanarPose<T>) -> UnicycleControl<T> {
        UnicycleControl { speed_mps: draw.real(-1.0, 3.0), rate_radps: draw.real(-0.5, 0.5) }
    }

    fn clutter(draw: &mut Draw) -> Vector2<T> {
        planar_clutter(draw)
    }
}

/// A car with a range and bearing sensor.
#[derive(Debug)]
pub struct Car<T>(PhantomData<T>);

impl<T: Real> World for Car<T> {
    const NAME: &'static str = "car";
    type Scalar = T;
    type Pose = PlanarPose<T>;
    type Motion = Ackermann<T>;
    type Sensing = Sensing<RangeBearing<T>, RangeBearingWindow<T>, UniformClutter<T>>;
    const SPREAD: &'static [f64] = &[0.1, 0.01];

    fn models(draw: &mut Draw) -> Result<ModelsOf<Self>, ModelError> {
        let Models { sensing, .. } = Rover::<T>::models(draw)?;
        let geometry = AckermannGeometry {
            wheelbase_m: draw.real(1.0, 4.0),
            encoder_offset_m: draw.real(-1.0, 1.0),
            sensor_forward_m: draw.real(0.0, 4.0),
            sensor_left_m: draw.real(-1.0, 1.0),
        };
        Ok(Models { motion: Ackermann::new(geometry, control_noise(draw))?, sensing })
    }

    fn control(draw: &mut Draw, _: &PlanarPose<T>) -> AckermannControl<T> {
        AckermannControl { speed_mps: draw.real(-1.0, 20.0), steering_rad: draw.real(-0.6, 0.6) }
    }

    fn clutter(draw: &mut Draw) -> Vector2<T> {
        planar_clutter(draw)
    }
}

/// A bearing sensor at a known pose, with births on a grid around it.
#[derive(Debug)]
pub struct Tracker<T>(PhantomData<T>);

impl<T: Real> World for Tracker<T> {
    const NAME: &'static str = "tracker";
    type Scalar = T;
    type Pose = PlanarPose<T>;
    type Motion = KnownPose<PlanarPose<T>>;
    type Sensing = Sensing<BearingOnly<T, PolarBirths<T>>, RangeBearingWindow<T>, UniformClutter<T>>;
    const SPREAD: &'static [f64] = &[0.01];

    fn models(draw: &mut Draw) -> Result<ModelsOf<Self>, ModelError> {
        let births = PolarBirths::new(PolarGrid {
            nearest_m: draw.real(1.0, 3.0),
            farthest_m: draw.real(6.0, 20.0),
            rings: 2 + draw.below(3) as u16,
            sectors: 4 + draw.below(8) as u16,
            weight: draw.real(1e-4, 0.05),
        })?;
        let field_of_view = window(draw)?;
        let motion = KnownPose::new();
        Ok(Models {
            motion,
            sensing: Sensing {
                sensor: BearingOnly::new(T::from_f64(draw.magnitude(1e-3, 0.1)), births)?,
                field_of_view,
                clutter: clutter(draw, T::from_f64(std::f64::consts::TAU))?,
            },
        })
    }

    fn control(draw: &mut Draw, from: &PlanarPose<T>) -> PlanarPose<T> {
        let mut near = |at: T| T::from_f64(draw.even(-1.0, 1.0)) + at;
        let (x, y) = (near(from.x_m), near(from.y_m));
        PlanarPose::new(
            T::from_f64(draw.spoilt(x.to_f64())),
            T::from_f64(draw.spoilt(y.to_f64())),
            draw.real(-3.2, 3.2),
        )
    }

    fn clutter(draw: &mut Draw) -> Vector1<T> {
        Vector1::new(draw.real(-3.2, 3.2))
    }
}

fn auv_control<T: Real>(draw: &mut Draw, from: &AuvPose<T>) -> AuvControl<T> {
    let z = from.z_m.to_f64() + draw.even(-0.1, 0.1);
    AuvControl {
        velocity_mps: Vector3::from_fn(|_, _| draw.real(-1.0, 1.0)),
        velocity_covariance: Symmetric::from_fn(|row, column| {
            if row == column { draw.real(1e-4, 0.05) } else { T::from_f64(draw.spoilt(0.0)) }
        }),
        roll_rad: draw.real(-0.3, 0.3),
        pitch_rad: draw.real(-0.3, 0.3),
        yaw_rate_radps: draw.chance(0.8).then(|| Reading { value: draw.real(-0.3, 0.3), sigma: draw.real(0.01, 0.05) }),
        z_m: draw.chance(0.8).then(|| Reading { value: T::from_f64(draw.spoilt(z)), sigma: draw.real(0.01, 0.1) }),
    }
}

/// An underwater vehicle with a stereo camera that looks down.
#[derive(Debug)]
pub struct Diver<T>(PhantomData<T>);

impl<T: Real> World for Diver<T> {
    const NAME: &'static str = "diver";
    type Scalar = T;
    type Pose = AuvPose<T>;
    type Motion = Auv<T>;
    type Sensing = Sensing<StereoCamera<T>, StereoFrustum<T>, UniformClutter<T>>;
    const SPREAD: &'static [f64] = &[1.0; 4];
    const DEPTH_M: f64 = 4.0;

    fn models(draw: &mut Draw) -> Result<ModelsOf<Self>, ModelError> {
        let number = T::from_f64;
        let calibration = Matrix3::new(500.0, 0.0, 400.0, 0.0, 500.0, 300.0, 0.0, 0.0, 1.0).map(number);
        let down = Matrix3::new(0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0).map(number);
        let base = draw.real::<f64>(0.05, 0.2);
        let side = |y: f64| projection(&calibration, &down, &Vector3::new(0.0, y, 0.0).map(number));
        let noise = pixel_noise([draw.real(0.5, 3.0); 4], [draw.real(0.0, 1.0), draw.real(0.0, 1.0)]);
        let sensor = StereoCamera::new(side(base), side(-base), noise, draw.real(4.0, 25.0))?;
        let limits = FrustumLimits {
            width_px: number(800.0),
            height_px: number(600.0),
            edge_px: draw.real(0.0, 20.0),
            near_m: draw.real(0.5, 1.0),
            far_m: draw.real(3.0, 6.0),
            depth_edge_m: draw.real(0.0, 0.3),
            probability: draw.real(0.5, 0.95),
        };
        let field_of_view = StereoFrustum::new(&sensor, limits)?;
        let measure = field_of_view.measure(number(20.0), number(170.0), number(10.0));
        let motion = Auv::new(draw.real(0.05, 0.5), draw.real(0.0, 2.0))?;
        Ok(Models { motion, sensing: Sensing { sensor, field_of_view, clutter: clutter(draw, measure)? } })
    }

    fn control(draw: &mut Draw, from: &AuvPose<T>) -> AuvControl<T> {
        auv_control(draw, from)
    }

    fn clutter(draw: &mut Draw) -> Vector4<T> {
        let (u, v, disparity) = (draw.even(0.0, 800.0), draw.even(0.0, 600.0), draw.even(20.0, 170.0));
        let pixels = [u, v, u - disparity, v + draw.even(-9.0, 9.0)];
        Vector4::from(pixels.map(|pixel| T::from_f64(draw.spoilt(pixel))))
    }
}

/// An underwater vehicle with a sonar that measures range, bearing and elevation.
#[derive(Debug)]
pub struct Listener<T>(PhantomData<T>);

impl<T: Real> World for Listener<T> {
    const NAME: &'static str = "listener";
    type Scalar = T;
    type Pose = AuvPose<T>;
    type Motion = Auv<T>;
    type Sensing = Sensing<RangeBearingElevation<T>, SonarWindow<T>, UniformClutter<T>>;
    const SPREAD: &'static [f64] = &[0.05, 0.02, 0.02];
    const DEPTH_M: f64 = 10.0;

    fn models(draw: &mut Draw) -> Result<ModelsOf<Self>, ModelError> {
        let field_of_view = SonarWindow::new(SonarLimits {
            range_max_m: draw.real(5.0, 30.0),
            range_edge_m: draw.real(0.0, 1.0),
            bearing_half_width_rad: draw.real(0.5, 3.5),
            elevation_half_width_rad: draw.real(0.3, 1.6),
            angle_edge_rad: draw.real(0.0, 0.1),
            probability: draw.real(0.5, 0.95),
        })?;
        let motion = Auv::new(draw.real(0.05, 0.5), draw.real(0.0, 2.0))?;
        Ok(Models {
            motion,
            sensing: Sensing {
                sensor: RangeBearingElevation::new(
                    draw.real(0.02, 0.2),
                    draw.real(0.005, 0.05),
                    draw.real(0.005, 0.05),
                )?,
                field_of_view,
                clutter: clutter(draw, T::from_f64(200.0))?,
            },
        })
    }

    fn control(draw: &mut Draw, from: &AuvPose<T>) -> AuvControl<T> {
        auv_control(draw, from)
    }

    fn clutter(draw: &mut Draw) -> Vector3<T> {
        Vector3::new(draw.real(0.0, 30.0), draw.real(-3.2, 3.2), draw.real(-1.5, 1.5))
    }
}
