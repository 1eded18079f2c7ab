//! Order and cut-off that the set distances share.

use crate::score::assignment::assign;

/// Order p and cut-off c of a set distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutoff {
    order: f64,
    distance: f64,
}

impl Cutoff {
    /// Order p ≥ 1 and cut-off c > 0 (in the unit of the points, m for maps), both finite.
    ///
    /// # Panics
    ///
    /// If they are not.
    #[must_use]
    pub const fn new(order: f64, distance: f64) -> Self {
        assert!(order >= 1.0 && order < f64::INFINITY, "the order is finite and at least 1");
        assert!(distance > 0.0 && distance < f64::INFINITY, "the cut-off is finite and more than 0");
        Self { order, distance }
    }

    /// Order p.
    #[must_use]
    pub const fn order(&self) -> f64 {
        self.order
    }

    /// Cut-off c, in the unit of the points.
    #[must_use]
    pub const fn distance(&self) -> f64 {
        self.distance
    }

    /// Distance of two points cut off at c (3.30). Anything that is not a number is as far as can be.
    ///
    /// # Panics
    ///
    /// If the points differ in dimension.
    pub(super) fn between(&self, a: &[f64], b: &[f64]) -> f64 {
        assert_eq!(a.len(), b.len(), "points of one dimension");
        let d = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        if d < self.distance { d } else { self.distance }
    }

    /// dᵖ. The usual orders are computed without a power function, whose last bit differs between machines.
    pub(super) fn power(&self, d: f64) -> f64 {
        if self.order == 1.0 {
            d
        } else if self.order == 2.0 {
            d * d
        } else {
            libm::pow(d, self.order)
        }
    }

    /// The p-th root.
    pub(super) fn root(&self, x: f64) -> f64 {
        if self.order == 1.0 {
            x
        } else if self.order == 2.0 {
            x.sqrt()
        } else {
            libm::pow(x, 1.0 / self.order)
        }
    }

    /// Cut-off distances of the pairs of the assignment that has the least sum of their p-th powers.
    pub(super) fn matched<X: AsRef<[f64]>, Y: AsRef<[f64]>>(&self, x: &[X], y: &[Y]) -> Vec<f64> {
        let distances: Vec<f64> =
            x.iter().flat_map(|a| y.iter().map(|b| self.between(a.as_ref(), b.as_ref()))).collect();
        // In units of c, so that high powers do not overflow.
        let costs: Vec<f64> = distances.iter().map(|d| self.power(d / self.distance)).collect();
        let pairs = assign(&costs, x.len(), y.len());
        pairs.into_iter().map(|(row, column)| distances[row * y.len() + column]).collect()
    }
}
