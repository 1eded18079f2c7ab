//! The common interface of the filters with joint maps.

use super::archive::Archive;
use super::config::JointConfig;
use super::filter::JointSlam;
use super::hypotheses::MultiHypothesisSlam;
use super::movers::Movers;
use super::report::JointReport;
use crate::{
    Component, ConfigError, CovarianceOf, Detector, Fix, FixReport, Flaw, LoadMapError, MeasurementModel, ModelError,
    Motion, MovingOf, ObserveError, Pose, PoseEstimate, PositionOf, PredictError, PredictReport, Real, ResetError,
    RestoreError, SaveError, ScalarOf, ScanError, Vector,
};

/// The pose of a filter.
type PoseOf<F> = <<F as JointFilter>::Motion as Motion>::Pose;
/// The scalar of a filter.
type Number<F> = ScalarOf<PoseOf<F>>;

/// The operations that [`JointSlam`] and [`MultiHypothesisSlam`] have in common, for code that works with either. They are
/// documented there. With several hypotheses, map and tracks are those of the likeliest.
#[expect(missing_docs, reason = "both filters have methods of the same names with documentation")]
#[expect(clippy::missing_errors_doc, reason = "the same")]
pub trait JointFilter {
    /// The motion model.
    type Motion: Motion;

    fn motion(&self) -> &Self::Motion;
    fn retune(&mut self, motion: Self::Motion) -> Result<(), ModelError>;
    fn configure(&mut self, config: JointConfig<Number<Self>>) -> Result<(), ConfigError>;
    fn reset(&mut self, pose: PoseOf<Self>) -> Result<(), ResetError>;
    fn reset_within(&mut self, pose: PoseOf<Self>, covariance: &CovarianceOf<PoseOf<Self>>) -> Result<(), ResetError>;
    fn relocate(&mut self, pose: PoseOf<Self>, covariance: &CovarianceOf<PoseOf<Self>>) -> Result<(), ResetError>;
    fn scatter(&mut self, covariance: &CovarianceOf<PoseOf<Self>>) -> Result<(), ResetError>;
    fn load_map(&mut self, features: &[Component<PositionOf<PoseOf<Self>>>]) -> Result<(), LoadMapError>;
    fn predict(
        &mut self,
        control: &<Self::Motion as Motion>::Control,
        dt: Number<Self>,
    ) -> Result<PredictReport, PredictError>;
    fn scan<X: MeasurementModel<Pose = PoseOf<Self>>, R>(
        &mut self,
        detector: &Detector<X, R>,
        measurements: &[X::Measurement],
    ) -> Result<JointReport<Number<Self>>, ScanError>;
    fn localise<X: MeasurementModel<Pose = PoseOf<Self>>, R>(
        &mut self,
        detector: &Detector<X, R>,
        measurements: &[X::Measurement],
    ) -> Result<JointReport<Number<Self>>, ScanError>;
    fn observe<F: Fix<Pose = PoseOf<Self>>>(
        &mut self,
        fix: &F,
        measured: &F::Measurement,
    ) -> Result<FixReport<Number<Self>>, ObserveError>;
    fn estimate_pose(&self) -> Option<PoseEstimate<PoseOf<Self>>>;
    fn features(&self) -> impl Iterator<Item = Component<PositionOf<PoseOf<Self>>>> + '_;
    fn moving(&self) -> impl Iterator<Item = Component<MovingOf<PoseOf<Self>>>> + '_;
    fn expected_features(&self) -> Number<Self>;
    fn held(&self) -> usize;
    fn save<E>(&self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>>;
    fn restore<E>(
        &mut self,
        kind: u32,
        source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
    ) -> Result<usize, RestoreError<E>>;
    fn digest(&self) -> u64;
    fn audit(&self) -> Result<(), Flaw>;
}

/// The operations by the methods of the same names; the likeliest hypothesis has the map.
macro_rules! by_methods {
    ($likeliest:expr) => {
        type Motion = M;

        fn motion(&self) -> &M {
            $likeliest(self).motion()
        }

        fn retune(&mut self, motion: M) -> Result<(), ModelError> {
            self.retune(motion)
        }

        fn configure(&mut self, config: JointConfig<T>) -> Result<(), ConfigError> {
            self.configure(config)
        }

        fn reset(&mut self, pose: M::Pose) -> Result<(), ResetError> {
            self.reset(pose)
        }

        fn reset_within(&mut self, pose: M::Pose, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
            self.reset_within(pose, covariance)
        }

        fn relocate(&mut self, pose: M::Pose, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
            self.relocate(pose, covariance)
        }

        fn scatter(&mut self, covariance: &CovarianceOf<M::Pose>) -> Result<(), ResetError> {
            self.scatter(covariance)
        }

        fn load_map(&mut self, features: &[Component<PositionOf<M::Pose>>]) -> Result<(), LoadMapError> {
            self.load_map(features)
        }

        fn predict(&mut self, control: &M::Control, dt: T) -> Result<PredictReport, PredictError> {
            self.predict(control, dt)
        }

        fn scan<X: MeasurementModel<Pose = M::Pose>, R>(
            &mut self,
            detector: &Detector<X, R>,
            measurements: &[X::Measurement],
        ) -> Result<JointReport<T>, ScanError> {
            self.scan(detector, measurements)
        }

        fn localise<X: MeasurementModel<Pose = M::Pose>, R>(
            &mut self,
            detector: &Detector<X, R>,
            measurements: &[X::Measurement],
        ) -> Result<JointReport<T>, ScanError> {
            self.localise(detector, measurements)
        }

        fn observe<F: Fix<Pose = M::Pose>>(
            &mut self,
            fix: &F,
            measured: &F::Measurement,
        ) -> Result<FixReport<T>, ObserveError> {
            self.observe(fix, measured)
        }

        fn estimate_pose(&self) -> Option<PoseEstimate<M::Pose>> {
            self.estimate_pose()
        }

        fn features(&self) -> impl Iterator<Item = Component<PositionOf<M::Pose>>> + '_ {
            $likeliest(self).features()
        }

        fn moving(&self) -> impl Iterator<Item = Component<MovingOf<M::Pose>>> + '_ {
            $likeliest(self).moving()
        }

        fn expected_features(&self) -> T {
            $likeliest(self).expected_features()
        }

        fn held(&self) -> usize {
            $likeliest(self).held()
        }

        fn save<E>(&self, kind: u32, sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<usize, SaveError<E>> {
            self.save(kind, sink)
        }

        fn restore<E>(
            &mut self,
            kind: u32,
            source: impl FnMut(usize, &mut [u8]) -> Result<(), E>,
        ) -> Result<usize, RestoreError<E>> {
            self.restore(kind, source)
        }

        fn digest(&self) -> u64 {
            self.digest()
        }

        fn audit(&self) -> Result<(), Flaw> {
            self.audit()
        }
    };
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, A: Archive<M::Pose>, V: Movers<M::Pose>>
    JointFilter for JointSlam<'_, M, Z, A, V>
{
    by_methods!(core::convert::identity);
}

impl<T: Real, M: Motion<Pose: Pose<Scalar = T>>, Z: Vector<Scalar = T>, V: Movers<M::Pose>, const OTHERS: usize>
    JointFilter for MultiHypothesisSlam<'_, M, Z, V, OTHERS>
{
    by_methods!(Self::likeliest);
}
