//! The models of an underwater vehicle in the head of a stream.

use crate::numbers::numbers;
use nalgebra::SMatrix;
use scphd::Real;
use scphd::models::{
    Auv, AuvPose, FrustumLimits, ModelError, Sensing, StereoCamera, StereoFrustum, UniformClutter, pixel_noise,
};
use scphd::navigation::{Navigator, VelocityNoise};

numbers! {
    /// Initial pose, noise of vehicle and instruments, and camera of an underwater vehicle.
    Models {
        /// Initial position, m.
        start_m: [f64; 3],
        /// Initial yaw, rad.
        start_yaw_rad: f64,
        /// Initial roll and pitch, rad.
        start_tilt_rad: [f64; 2],
        /// Random walk of each velocity component, (m/s)/√s.
        velocity_walk_mps_rts: f64,
        /// Standard deviation of each velocity component of the Doppler log, m/s.
        velocity_sigma_mps: f64,
        /// Standard deviation of z, m.
        z_sigma_m: f64,
        /// Gate of the Doppler log and the pressure sensor, standard deviations.
        gate_sigmas: f64,
        /// Number of consecutive outliers after which the Doppler log is accepted again; an integer.
        outliers_believed: f64,
        /// Standard deviation of the angular acceleration about the vertical, rad/s².
        yaw_acceleration_sigma_radps2: f64,
        /// Correlation time of an error of the filtered velocity, s.
        velocity_interval_s: f64,
        /// Projection matrices of the left and the right camera, row by row: from the vehicle's frame (x ahead, y to the left, z
        /// upwards, m) to homogeneous pixels.
        projections: [[[f64; 4]; 3]; 2],
        /// Independent standard deviations of (u_l, v_l, u_r, v_r), px.
        pixel_sigmas: [f64; 4],
        /// Standard deviations of the noise that is common to the columns, and to the rows, of both images, px.
        common_sigmas: [f64; 2],
        /// Epipolar gate: squared Mahalanobis distance of the part of a pair that no point in space can cause.
        epipolar_gate: f64,
        /// Width and height of the images, px.
        size_px: [f64; 2],
        /// Half width of the soft edge around the images, px.
        edge_px: f64,
        /// Least depth, m.
        near_m: f64,
        /// Greatest depth, m.
        far_m: f64,
        /// Half width of the soft edge at either depth, m.
        depth_edge_m: f64,
        /// p_D.
        detection: f64,
        /// λ, mean number of false pairs in an image.
        clutter_per_scan: f64,
        /// Least and greatest disparity that the matcher accepts, px.
        disparities_px: [f64; 2],
        /// Greatest difference of the rows of a pair that the matcher accepts, px.
        row_tolerance_px: f64,
    }
}

/// The models of the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AuvModels<T: Real> {
    /// The motion model.
    pub motion: Auv<T>,
    /// The models of the camera.
    pub sensing: Sensing<StereoCamera<T>, StereoFrustum<T>, UniformClutter<T>>,
}

impl Models {
    /// The models of the filter.
    ///
    /// # Errors
    /// A number is out of range.
    pub fn of_filter<T: Real>(&self) -> Result<AuvModels<T>, ModelError> {
        let real = T::from_f64;
        let [left, right] = self.projections.map(|rows| {
            let [[a, b, c, d], [e, f, g, h], [i, j, k, l]] = rows.map(|row| row.map(real));
            SMatrix::<T, 3, 4>::new(a, b, c, d, e, f, g, h, i, j, k, l)
        });
        let noise = pixel_noise(self.pixel_sigmas.map(real), self.common_sigmas.map(real));
        let sensor = StereoCamera::new(left, right, noise, real(self.epipolar_gate))?;
        let [width_px, height_px] = self.size_px.map(real);
        let limits = FrustumLimits {
            width_px,
            height_px,
            edge_px: real(self.edge_px),
            near_m: real(self.near_m),
            far_m: real(self.far_m),
            depth_edge_m: real(self.depth_edge_m),
            probability: real(self.detection),
        };
        let field_of_view = StereoFrustum::new(&sensor, limits)?;
        let [least, greatest] = self.disparities_px.map(real);
        let measure = field_of_view.measure(least, greatest, real(self.row_tolerance_px));
        let clutter = UniformClutter::of_scan(real(self.clutter_per_scan), measure)?;
        Ok(AuvModels {
            motion: Auv::new(real(self.yaw_acceleration_sigma_radps2), real(self.velocity_interval_s))?,
            sensing: Sensing { sensor, field_of_view, clutter },
        })
    }

    /// Process noise of the velocity, and noise of its instruments.
    #[must_use]
    pub fn velocity_noise(&self) -> VelocityNoise<f64> {
        VelocityNoise {
            walk_mps_rts: self.velocity_walk_mps_rts,
            dvl_sigma_mps: self.velocity_sigma_mps,
            z_sigma_m: self.z_sigma_m,
            gate_sigmas: self.gate_sigmas,
            outliers_believed: self.outliers_believed as u16,
        }
    }

    /// The velocity filter, in its initial state.
    ///
    /// # Errors
    /// The noise is out of range, or the initial state not finite.
    pub fn navigator(&self) -> Result<Navigator<f64>, ModelError> {
        let [_, _, z] = self.start_m;
        Navigator::new(self.velocity_noise(), z, self.start_tilt_rad)
    }

    /// The initial pose.
    #[must_use]
    pub fn start<T: Real>(&self) -> AuvPose<T> {
        let [x, y, z] = self.start_m.map(T::from_f64);
        let [roll_rad, pitch_rad] = self.start_tilt_rad.map(T::from_f64);
        AuvPose { roll_rad, pitch_rad, ..AuvPose::new(x, y, z, T::from_f64(self.start_yaw_rad)) }
    }
}
