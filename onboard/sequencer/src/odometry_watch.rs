//! Detection of an odometry bias.

use scphd::Real;
use scphd::models::{Pose, ScalarOf, TangentOf};
use scphd::numerics::{Vector, Zero};

/// Weight of the newest correction in the mean of the recent ones: the last three scans have half of the weight.
const NEWEST: f64 = 0.2;
/// Variance of that mean for independent corrections with variance 1.
const VARIANCE: f64 = NEWEST / (2.0 - NEWEST);
/// Weight of the newest value in the usual variance: its memory is some hundred scans.
const SLOW: f64 = 0.004;
/// The usual variance is learnt from means below this number of their standard deviations. It is limited to between a quarter of
/// the variance of correct models and nine times that.
const USUAL: f64 = 3.0;
const LEAST_USUAL: f64 = 0.25;
const MOST_USUAL: f64 = 9.0;
/// Limit of a correction in standard deviations: a single jump, for example by a loop closure, is no bias.
const MOST: f64 = 4.0;
/// Subtracted from every correction, in standard deviations, before it is added to the sum: half of the bias that is detected
/// fastest.
const ALLOWED: f64 = 1.0;
/// Threshold of the sums: with independent corrections, a sum exceeds it in one of a hundred thousand scans (Siegmund 1985).
const SUSPECTED: f64 = 5.5;
/// Limit of a sum, so that it decreases soon after the end of the bias.
const MOST_SUMMED: f64 = 10.0;

/// Estimate of the odometry bias, along the vehicle's axes: forward, left and heading for a
/// [`PlanarPose`](scphd::models::PlanarPose).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometryBias<V: Vector> {
    /// Mean of the recent corrections per scan, m, and rad for angles: positive if odometry is too small. A correction above four
    /// of its standard deviations counts as four.
    pub each_scan: V,
    /// The CUSUM sum of the corrections, in their standard deviations: positive if odometry is too small.
    pub evidence: V,
}

impl<V: Vector> OdometryBias<V> {
    /// Whether odometry has a bias in some direction: wheels that slip or stand still, a gyroscope with an offset.
    pub fn is_suspected(&self) -> bool {
        self.evidence.as_slice().iter().any(|x| x.abs() > V::Scalar::from_f64(SUSPECTED))
    }
}

/// Detects an odometry bias from the corrections of a filter.
///
/// With correct models, the corrections of a filter in a known area are independent between scans, and have the variance of the
/// odometry since the previous scan, because a scan restores the information lost since then. Corrections, in standard deviations
/// of the odometry, are therefore summed in each direction as far as they exceed one standard deviation (the cumulative sums of
/// Page 1954). Models are seldom correct: the standard deviation is replaced by the usual one, which is learnt over some hundred
/// scans without suspicion, from means of corrections, so that correlation between corrections is included.
///
/// ```
/// use scphd::models::PlanarPose;
/// use scphd::numerics::nalgebra::Vector3;
/// use scphd_sequencer::OdometryWatch;
///
/// let mut watch = OdometryWatch::<PlanarPose<f32>>::new();
/// // The odometry is good for 0.05 m forward and 0.02 rad from scan to scan, and cannot go sideways.
/// let sigmas = Vector3::new(0.05, 0.0, 0.02);
/// // The wheels slip: every scan puts the vehicle 0.12 m behind where odometry had it.
/// let (predicted, corrected) = (PlanarPose::new(1.0, 0.0, 0.0), PlanarPose::new(0.88, 0.0, 0.0));
/// let bias = (0..10).map(|_| watch.scan(&predicted, &corrected, &sigmas)).last().ok_or("no scan")?;
/// assert!(bias.is_suspected() && bias.evidence.x < 0.0 && bias.evidence.z == 0.0);
/// assert!((bias.each_scan.x + 0.12).abs() < 0.02);
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometryWatch<P: Pose> {
    /// Mean of the recent corrections, in standard deviations of the odometry.
    recent: TangentOf<P>,
    /// The usual variance of that mean, in units of [`VARIANCE`], minus one.
    beyond: TangentOf<P>,
    /// Sums of forward and of backward corrections.
    above: TangentOf<P>,
    below: TangentOf<P>,
}

impl<P: Pose> Default for OdometryWatch<P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<P: Pose> OdometryWatch<P> {
    /// The state before the first scan.
    pub const fn new() -> Self {
        let zero = TangentOf::<P>::ZERO;
        Self { recent: zero, beyond: zero, above: zero, below: zero }
    }

    /// Adds a scan: the poses before and after it, and the standard deviations of the odometry since the previous scan, along the
    /// vehicle's axes, m and rad; for white noise of σ (m/√s) over a time dt, σ √dt. A direction in which it is zero or not
    /// finite is ignored. A correction that is not finite changes nothing.
    pub fn scan(&mut self, predicted: &P, corrected: &P, sigmas: &TangentOf<P>) -> OdometryBias<TangentOf<P>> {
        let moved = own_axes(predicted, &corrected.difference(predicted));
        if moved.as_slice().iter().all(|x| x.is_finite()) {
            for k in 0..TangentOf::<P>::DIMENSION {
                self.take(k, moved.at(k), sigmas.at(k));
            }
        }
        OdometryBias {
            each_scan: TangentOf::<P>::with(|k| {
                let sigma = sigmas.at(k);
                if is_usable(sigma) { self.recent.at(k) * sigma } else { Zero::ZERO }
            }),
            evidence: TangentOf::<P>::with(|k| self.above.at(k) - self.below.at(k)),
        }
    }

    /// Adds the correction in one direction.
    fn take(&mut self, k: usize, moved: ScalarOf<P>, sigma: ScalarOf<P>) {
        if !is_usable(sigma) {
            return;
        }
        let (real, one) = (ScalarOf::<P>::from_f64, ScalarOf::<P>::ONE);
        let Self { recent, beyond, above, below } = self;
        let [recent, beyond, above, below] = [recent, beyond, above, below].map(|all| all.as_mut_slice().get_mut(k));
        let (Some(recent), Some(beyond), Some(above), Some(below)) = (recent, beyond, above, below) else { return };
        let usual = (one + *beyond).sqrt();
        let deviations = (moved / (sigma * usual)).at_most(real(MOST)).at_least(-real(MOST));
        let summed = |sum: ScalarOf<P>, by| (sum + by - real(ALLOWED)).at_least(Zero::ZERO).at_most(real(MOST_SUMMED));
        *above = summed(*above, deviations);
        *below = summed(*below, -deviations);
        *recent += (deviations * usual - *recent) * real(NEWEST);
        let square = *recent * *recent / real(VARIANCE);
        if square <= (one + *beyond) * real(USUAL * USUAL) {
            *beyond += (square - one - *beyond) * real(SLOW);
            *beyond = (*beyond).at_least(real(LEAST_USUAL - 1.0)).at_most(real(MOST_USUAL - 1.0));
        }
    }
}

fn is_usable<T: Real>(sigma: T) -> bool {
    sigma > T::ZERO && sigma.is_finite()
}

/// A difference of poses with its first two coordinates along the axes of the vehicle at this pose, if poses have a heading.
fn own_axes<P: Pose>(pose: &P, moved: &TangentOf<P>) -> TangentOf<P> {
    let Some(heading) = P::HEADING else { return *moved };
    let (sine, cosine) = pose.coordinates().at(heading).sin_cos();
    TangentOf::<P>::with(|k| match k {
        0 => cosine * moved.at(0) + sine * moved.at(1),
        1 => cosine * moved.at(1) - sine * moved.at(0),
        _ => moved.at(k),
    })
}
