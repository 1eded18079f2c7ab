//! Estimated maps, in the caller's array.

use crate::pointer::{Out, Versioned};
use crate::report::count;
use crate::scphd_status;
use nalgebra::{Vector2, Vector3, Vector4};
use scphd::numerics::{Symmetric, Vector};
use scphd::{Component, MapEstimate};

/// A measurement of range and bearing.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_range_bearing {
    /// Range, m.
    pub range_m: f32,
    /// Bearing, rad, 0 ahead, positive to the left.
    pub bearing_rad: f32,
}

/// A static feature in the plane.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_feature {
    /// Identifies the feature from scan to scan.
    pub label: u32,
    /// Expected number of features that it represents; in a joint map its existence probability.
    pub weight: f32,
    /// x, m.
    pub x_m: f32,
    /// y, m.
    pub y_m: f32,
    /// Covariance: xx, xy, yy, m^2.
    pub covariance: [f32; 3],
}

/// A static feature in space.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_feature_3d {
    /// Identifies the feature from scan to scan.
    pub label: u32,
    /// Expected number of features that it represents.
    pub weight: f32,
    /// x, m.
    pub x_m: f32,
    /// y, m.
    pub y_m: f32,
    /// z, m.
    pub z_m: f32,
    /// Covariance: xx, xy, yy, xz, yz, zz, m^2.
    pub covariance: [f32; 6],
}

/// A moving feature in the plane.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_mover {
    /// Identifies the feature from scan to scan.
    pub label: u32,
    /// Expected number of features that it represents.
    pub weight: f32,
    /// x, m.
    pub x_m: f32,
    /// y, m.
    pub y_m: f32,
    /// Velocity along x, m/s.
    pub vx_mps: f32,
    /// Velocity along y, m/s.
    pub vy_mps: f32,
    /// Covariance of (x, y, vx, vy): its lower triangle, row by row.
    pub covariance: [f32; 10],
}

/// Properties of an estimated map, without the features.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct scphd_map {
    /// `sizeof(scphd_map)`, set by the caller.
    pub struct_size: u32,
    /// Number of features that were written to the array.
    pub features: u32,
    /// Number of features that did not fit into the array.
    pub left_out: u32,
    /// The expected number of features.
    pub expected_features: f32,
}

impl scphd_map {
    pub(crate) fn of(estimate: MapEstimate<f32>) -> Self {
        Self {
            struct_size: Self::STRUCT_SIZE,
            features: count(estimate.features),
            left_out: count(estimate.left_out),
            expected_features: estimate.expected_features,
        }
    }
}

impl scphd_feature {
    /// Converts to a component of the library.
    pub(crate) fn component(&self) -> Component<Vector2<f32>> {
        let [xx, xy, yy] = self.covariance;
        let covariance = Symmetric::from_fn(|row, column| match row + column {
            0 => xx,
            1 => xy,
            _ => yy,
        });
        let ln_weight = scphd::Real::ln(self.weight);
        Component { label: self.label, ln_weight, mean: Vector2::new(self.x_m, self.y_m), covariance }
    }
}

/// Has the library write components to the caller's array, and converts each to a feature in place.
pub(crate) fn write<N: Vector<Scalar = f32>, F: From<Component<N>>>(
    array: &mut Out<F>,
    capacity: usize,
    map: &mut Out<scphd_map>,
    estimate: impl FnOnce(&mut [Component<N>]) -> MapEstimate<f32>,
) -> Result<(), scphd_status> {
    let map = map.get()?;
    *map = scphd_map::of(array.written_as(capacity, Component::ZERO, estimate)?);
    Ok(())
}

/// The lower triangle of the covariance, row by row.
fn lower<const N: usize, V: Vector<Scalar = f32>>(component: &Component<V>) -> [f32; N] {
    let mut numbers = component.covariance.as_lower().iter();
    core::array::from_fn(|_| numbers.next().copied().unwrap_or(0.0))
}

fn weight<V: Vector<Scalar = f32>>(component: &Component<V>) -> f32 {
    scphd::Real::exp(component.ln_weight)
}

impl From<Component<Vector2<f32>>> for scphd_feature {
    fn from(component: Component<Vector2<f32>>) -> Self {
        let [[x_m, y_m]] = component.mean.data.0;
        Self { label: component.label, weight: weight(&component), x_m, y_m, covariance: lower(&component) }
    }
}

impl From<Component<Vector3<f32>>> for scphd_feature_3d {
    fn from(component: Component<Vector3<f32>>) -> Self {
        let [[x_m, y_m, z_m]] = component.mean.data.0;
        Self { label: component.label, weight: weight(&component), x_m, y_m, z_m, covariance: lower(&component) }
    }
}

impl From<Component<Vector4<f32>>> for scphd_mover {
    fn from(component: Component<Vector4<f32>>) -> Self {
        let [[x_m, y_m, vx_mps, vy_mps]] = component.mean.data.0;
        Self {
            label: component.label,
            weight: weight(&component),
            x_m,
            y_m,
            vx_mps,
            vy_mps,
            covariance: lower(&component),
        }
    }
}
