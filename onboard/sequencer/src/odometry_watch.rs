//! Whether odometry is wrong in one direction, scan after scan.

use scphd::Real;
use scphd::models::{Pose, ScalarOf, TangentOf};
use scphd::numerics::{Vector, Zero};

/// The weight of the newest correction in the mean of the recent ones: half of that mean is of the last three scans.
const NEWEST: f64 = 0.2;
/// The variance of that mean where corrections are independent and have the variance 1.
const VARIANCE: f64 = NEWEST / (2.0 - NEWEST);
/// The weight of the newest in what is usual of that variance: some hundred scans count.
const SLOW: f64 = 0.004;
/// What is usual is learnt from means below this many of their standard deviations, and lies between a quarter and nine times what it
/// would be if all models were right.
const USUAL: f64 = 3.0;
const LEAST_USUAL: f64 = 0.25;
const MOST_USUAL: f64 = 9.0;
/// A correction counts for no more standard deviations than this: one jump, as where a round is closed, is no bias.
const MOST: f64 = 4.0;
/// Of every correction, in standard deviations, so much is taken away before it is summed: half of the bias that is found soonest.
const ALLOWED: f64 = 1.0;
/// A sum beyond this is a bias: with independent corrections one in a hundred thousand scans comes to it in some direction (Siegmund 1985).
const SUSPECTED: f64 = 5.5;
/// What a sum is at most, so that it is soon over when the bias is.
const MOST_SUMMED: f64 = 10.0;

/// What the corrections of late say of the odometry, along the vehicle's own axes: for a [`PlanarPose`](scphd::models::PlanarPose) forward, left and
/// heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometryBias<V: Vector> {
    /// By how much odometry has fallen short of late, a scan, in the mean: m, and rad of angles. A correction of more than four of its
    /// standard deviations counts as one of four.
    pub each_scan: V,
    /// The sum of what corrections have in common, in their standard deviations: positive where odometry falls short.
    pub evidence: V,
}

impl<V: Vector> OdometryBias<V> {
    /// Whether odometry is wrong beyond chance in some direction: wheels slip or stand, a gyroscope has a bias.
    #[must_use]
    pub fn is_suspected(&self) -> bool {
        self.evidence.as_slice().iter().any(|x| x.abs() > V::Scalar::from_f64(SUSPECTED))
    }
}

/// Tells from the corrections of a filter that its odometry is wrong in one direction, scan after scan.
///
/// Where all models are right, the corrections of a filter that knows its surroundings are independent from scan to scan, and have the
/// variance that the odometry since the scan before has brought: what is learnt in a scan is what was lost before it. So corrections, in
/// standard deviations of the odometry, are summed in each direction as long as they are beyond one (the cumulative sums of
/// Page 1954). Models are seldom right: a standard deviation is taken for what it usually is, which is learnt over some hundred scans,
/// while nothing is suspected, from means of corrections, so that it counts too if corrections are not independent.
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
    /// The mean of the recent corrections, in standard deviations of odometry.
    recent: TangentOf<P>,
    /// Its variance, as it usually is, in units of [`VARIANCE`], less one.
    beyond: TangentOf<P>,
    /// Sums of corrections forward, and of those backward.
    above: TangentOf<P>,
    below: TangentOf<P>,
}

impl<P: Pose> Default for OdometryWatch<P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<P: Pose> OdometryWatch<P> {
    /// Nothing has been seen yet.
    #[must_use]
    pub const fn new() -> Self {
        let zero = TangentOf::<P>::ZERO;
        Self { recent: zero, beyond: zero, above: zero, below: zero }
    }

    /// Takes in one scan: the pose before it and behind it, and the standard deviations of the odometry since the scan before, along the
    /// vehicle's own axes, m and rad: of white noise of σ (m/√s) over a time of dt it is σ √dt. Of a direction in which that is zero or
    /// not a number nothing is said. A correction that is not finite changes nothing.
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

    /// Takes in what a scan says of one direction.
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

/// A difference of poses with its first two coordinates along the axes of a vehicle with this pose, if poses have a heading.
fn own_axes<P: Pose>(pose: &P, moved: &TangentOf<P>) -> TangentOf<P> {
    let Some(heading) = P::HEADING else { return *moved };
    let (sine, cosine) = pose.coordinates().at(heading).sin_cos();
    TangentOf::<P>::with(|k| match k {
        0 => cosine * moved.at(0) + sine * moved.at(1),
        1 => cosine * moved.at(1) - sine * moved.at(0),
        _ => moved.at(k),
    })
}
