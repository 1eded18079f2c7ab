//! The planar joint map that the features of an image select.

#[cfg(feature = "hypotheses")]
pub use scphd_stream::planar::PlanarHypotheses as Joint;
#[cfg(not(any(feature = "forty-features", feature = "movers", feature = "hypotheses")))]
pub use scphd_stream::planar::PlanarJoint as Joint;
#[cfg(all(feature = "forty-features", not(feature = "movers")))]
pub use scphd_stream::planar::PlanarJoint40 as Joint;
#[cfg(all(feature = "forty-features", feature = "movers"))]
pub use scphd_stream::planar::PlanarJoint40Movers as Joint;
#[cfg(all(not(feature = "forty-features"), feature = "movers"))]
pub use scphd_stream::planar::PlanarJointMovers as Joint;
