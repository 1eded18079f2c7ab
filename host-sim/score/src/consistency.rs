//! Consistency of the filter: evidence, innovations, and position errors relative to their covariance; the same in the plane and
//! in space.

use crate::chi_squared;
use crate::moving::median;
use crate::record::ScanRecord;
use scphd_log::angle::wrap;
use scphd_log::dimensions::{Coordinates, Dimensions};

/// Figures that the filter reported for its scans.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Consistency {
    scans: usize,
    ln_evidence: Option<f64>,
    innovation_sum: f64,
    innovations: usize,
    innovations_within: usize,
}

impl Consistency {
    /// Adds a scan: its log likelihood and its mean squared innovation, if the filter reports them. The latter is over at most
    /// `detections` of `dimension` numbers each.
    pub fn scan(&mut self, ln_evidence: Option<f64>, innovation: Option<f64>, detections: usize, dimension: usize) {
        self.scans += 1;
        if let Some(ln_evidence) = ln_evidence {
            self.ln_evidence = Some(self.ln_evidence.unwrap_or(0.0) + ln_evidence);
        }
        if let Some(innovation) = innovation {
            self.innovation_sum += innovation;
            self.innovations += 1;
            self.innovations_within += usize::from(is_within(innovation, dimension * detections.max(1)));
        }
    }

    /// The log likelihood of all scans. The filter omits the factor exp(−∫ κ + w_b dz) of every scan, which is the same for all
    /// particles, but not for all settings: `expected` is this integral, the mean number of false measurements and births.
    pub fn ln_evidence(&self, expected: f64) -> Option<f64> {
        self.ln_evidence.map(|sum| sum - self.scans as f64 * expected)
    }

    /// Share of the scans with detections whose mean squared innovation is within the two-sided 95 % bounds of χ².
    pub fn innovation_within(&self) -> Option<f64> {
        (self.innovations > 0).then(|| self.innovations_within as f64 / self.innovations as f64)
    }

    /// Mean squared innovation divided by its expected value.
    pub fn innovation(&self) -> Option<f64> {
        (self.innovations > 0).then(|| self.innovation_sum / self.innovations as f64)
    }
}

/// Squared errors of the scans of a run relative to the filter's covariance, eᵀ P⁻¹ e divided by the dimension (NEES/dim).
#[derive(Debug, Clone, PartialEq)]
pub struct SquaredErrors {
    dimension: usize,
    values: Vec<f64>,
}

impl SquaredErrors {
    /// Computes those of the positions of scans with truth.
    pub fn of_positions<D: Dimensions>(scans: &[ScanRecord<D>]) -> Self {
        Self { dimension: D::Position::COUNT, values: scans.iter().filter_map(of_position).collect() }
    }

    /// Computes those of positions and headings together, if the truth has both.
    pub fn of_poses<D: Dimensions>(scans: &[ScanRecord<D>]) -> Self {
        Self { dimension: D::Position::COUNT + 1, values: scans.iter().filter_map(of_pose).collect() }
    }

    /// Median; `None` without values, or if P is singular in all scans. The mean would be dominated by the few scans in which a
    /// single particle has all the weight, with nearly zero P.
    pub fn median(&self) -> Option<f64> {
        median(&self.values)
    }

    /// Share within the two-sided 95 % bounds of χ².
    pub fn within(&self) -> Option<f64> {
        let within = self.values.iter().filter(|&&value| is_within(value, self.dimension)).count();
        (!self.values.is_empty()).then(|| within as f64 / self.values.len() as f64)
    }

    pub fn last(&self) -> Option<f64> {
        self.values.last().copied()
    }
}

/// Whether a mean square over this number of degrees of freedom is within the two-sided 95 % bounds of χ².
fn is_within(mean_square: f64, freedom: usize) -> bool {
    chi_squared::is_within(mean_square * freedom as f64, freedom)
}

/// Squared position error of a scan relative to the sum of the filter's covariance and that of the truth, divided by the
/// dimension; `None` if the covariance is singular or the truth is not known.
pub fn of_position<D: Dimensions>(scan: &ScanRecord<D>) -> Option<f64> {
    squared(&position_error(scan)?, &with_truth(scan))
}

/// The same for position and heading together.
pub fn of_pose<D: Dimensions>(scan: &ScanRecord<D>) -> Option<f64> {
    let mut error = position_error(scan)?;
    error.push(wrap(D::heading(&scan.pose) - scan.true_heading_rad?));
    squared(&error, &with_truth(scan))
}

/// The covariance of the difference of estimate and truth.
fn with_truth<D: Dimensions>(scan: &ScanRecord<D>) -> Vec<Vec<f64>> {
    let mut covariance: Vec<Vec<f64>> = scan.pose_covariance.as_ref().iter().map(|row| row.as_ref().to_vec()).collect();
    for (coordinate, row) in covariance.iter_mut().enumerate().take(D::Position::COUNT) {
        row[coordinate] += scan.truth_sigma_m * scan.truth_sigma_m;
    }
    covariance
}

fn position_error<D: Dimensions>(scan: &ScanRecord<D>) -> Option<Vec<f64>> {
    let truth = scan.true_position?;
    Some(scan.pose.as_ref().iter().zip(truth.as_ref()).map(|(estimate, truth)| estimate - truth).collect())
}

/// eᵀ P⁻¹ e / D for the first D coordinates, with P = L Lᵀ; `None` if P is not positive definite.
fn squared(error: &[f64], covariance: &[impl AsRef<[f64]>]) -> Option<f64> {
    let dimension = error.len();
    let mut lower = vec![vec![0.0; dimension]; dimension];
    let mut whitened = vec![0.0; dimension];
    let mut sum = 0.0;
    for row in 0..dimension {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| lower[row][k] * lower[column][k]).sum();
            let rest = covariance[row].as_ref()[column] - known;
            lower[row][column] = if column < row {
                rest / lower[column][column]
            } else if rest > 0.0 {
                rest.sqrt()
            } else {
                return None;
            };
        }
        let known: f64 = (0..row).map(|k| lower[row][k] * whitened[k]).sum();
        whitened[row] = (error[row] - known) / lower[row][row];
        sum += whitened[row] * whitened[row];
    }
    Some(sum / dimension as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squared_errors_in_closed_form() {
        // P⁻¹ = [[2, −1], [−1, 2]] / 3.
        let planar = squared(&[1.0, 2.0], &[[2.0, 1.0], [1.0, 2.0]]).unwrap();
        assert!((planar - (2.0 - 4.0 + 8.0) / 3.0 / 2.0).abs() < 1e-15);
        let c = [[4.0, 0.0, 2.0], [0.0, 9.0, 0.0], [2.0, 0.0, 2.0]];
        // x and z with P⁻¹ = [[2, −2], [−2, 4]] / 4, y separately.
        let spatial = squared(&[1.0, 3.0, 2.0], &c).unwrap();
        assert!((spatial - ((2.0 - 8.0 + 16.0) / 4.0 + 1.0) / 3.0).abs() < 1e-15);
        for singular in [[[0.0, 0.0], [0.0, 1.0]], [[1.0, 1.0], [1.0, 1.0]], [[f64::NAN, 0.0], [0.0, 1.0]]] {
            assert_eq!(squared(&[1.0, 1.0], &singular), None);
        }
    }

    #[test]
    fn sums_and_means_of_the_known_figures() {
        let mut consistency = Consistency::default();
        assert_eq!((consistency.ln_evidence(1.0), consistency.innovation()), (None, None));
        consistency.scan(Some(-3.0), None, 4, 2);
        consistency.scan(Some(-5.0), Some(0.5), 4, 2);
        consistency.scan(None, Some(4.5), 4, 2);
        assert_eq!((consistency.ln_evidence(2.0), consistency.innovation()), (Some(-14.0), Some(2.5)));
        // The bounds of χ² with 8 degrees of freedom are 2.18 and 17.5.
        assert_eq!(consistency.innovation_within(), Some(0.5));
    }

    #[test]
    fn errors_of_scans() {
        let scan = |x: f64, heading: f64, truth: Option<f64>| ScanRecord {
            pose_covariance: [[4.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.01]],
            true_position: Some([1.0, 2.0]),
            true_heading_rad: truth,
            ..ScanRecord::at(0.0, [x, 2.0, heading])
        };
        let (here, there) = (scan(3.0, 3.1, Some(3.1 - std::f64::consts::TAU)), scan(9.0, 0.0, None));
        let known = |scan: &ScanRecord| (of_position(scan).unwrap(), of_pose(scan));
        assert!((known(&here).0 - 0.5).abs() < 1e-15 && (known(&here).1.unwrap() - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(known(&there), (8.0, None));
        // A truth as uncertain as the estimate halves the squared error along x.
        let uncertain = ScanRecord { truth_sigma_m: 2.0, ..here.clone() };
        assert!((known(&uncertain).0 - 0.25).abs() < 1e-15);
        assert_eq!((here.expected_error_m(), uncertain.expected_error_m()), (5.0_f64.sqrt(), 13.0_f64.sqrt()));
        let scans = [here, there, ScanRecord::at(1.0, [0.0; 3])];
        let positions = SquaredErrors::of_positions(&scans);
        // The upper bound of χ² with two degrees of freedom is 7.38.
        assert_eq!((positions.median(), positions.within(), positions.last()), (Some(4.25), Some(0.5), Some(8.0)));
        assert_eq!(SquaredErrors::of_poses(&scans).within(), Some(1.0));
        assert_eq!(SquaredErrors::of_poses(&scans[1..]).within(), None);
    }
}
