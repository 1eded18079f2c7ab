//! Predeclared memories, in single precision.

use crate::{joint_backing, mixture_backing};

joint_backing! {
    /// 40 features, 32 measurements in a scan.
    pub struct Joint40: PlanarPose<f32> { features: 40, measurements: 32 }
}
joint_backing! {
    /// 100 features, 32 measurements in a scan.
    pub struct Joint100: PlanarPose<f32> { features: 100, measurements: 32 }
}
joint_backing! {
    /// 60 features, 32 measurements in a scan, 16 movers.
    pub struct Joint60Movers: PlanarPose<f32> { features: 60, measurements: 32, movers: 16 }
}
joint_backing! {
    /// 100 features, 32 measurements in a scan, 32 movers.
    pub struct Joint100Movers: PlanarPose<f32> { features: 100, measurements: 32, movers: 32 }
}
joint_backing! {
    /// 40 features in the window and 1000 in the archive, 32 measurements in a scan, 16 movers.
    pub struct Joint40Archive: PlanarPose<f32> { features: 40, measurements: 32, movers: 16, archived: 1000 }
}
joint_backing! {
    /// Eight hypotheses of data association, each with 24 features and 8 movers; 16 measurements in a scan.
    pub struct Joint24Hypotheses: PlanarPose<f32> { features: 24, measurements: 16, movers: 8, hypotheses: 8 }
}
joint_backing! {
    /// 60 features, 32 measurements in a scan, with odometry calibration.
    pub struct Joint60Learning: CalibratedPose<f32> { features: 60, measurements: 32 }
}
mixture_backing! {
    /// 32 particles with two samples; scans of 128 measurements, of range and bearing or of bearings only.
    pub struct Mixture32x2: f32, measurements: 128 with bearings {
        particles: 32, samples: 2, features { pages: 320, pages_per_map: 32, in_view: 256 },
        moving { pages: 128, pages_per_map: 16, in_view: 128 },
    }
}
mixture_backing! {
    /// Four informed particles; scans of 64 measurements.
    pub struct MixtureInformed4: f32, measurements: 64 {
        particles: 4, samples: 1, features { pages: 128, pages_per_map: 32, in_view: 256 },
    }
}
mixture_backing! {
    /// The same with moving features.
    pub struct MixtureInformed4Moving: f32, measurements: 64 {
        particles: 4, samples: 1, features { pages: 128, pages_per_map: 32, in_view: 256 },
        moving { pages: 64, pages_per_map: 16, in_view: 128 },
    }
}
