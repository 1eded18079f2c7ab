//! Filters on the heap with the capacities of the simulator: joint maps in several variants.

use scphd_vehicle::{Backing, Description, Filter, Services, StartError, joint_backing};

joint_backing! {
    /// A joint map.
    pub struct Still: PlanarPose<f32> { features: 1024, measurements: 256 }
}
joint_backing! {
    /// A joint map with moving features.
    pub struct Moving: PlanarPose<f32> { features: 1024, measurements: 256, movers: 256 }
}
joint_backing! {
    /// A joint map that estimates the odometry error.
    pub struct Learning: CalibratedPose<f32> { features: 1024, measurements: 256 }
}
joint_backing! {
    /// A joint map of the surroundings, with an archive of distant features.
    pub struct Archiving: PlanarPose<f32> { features: 256, measurements: 256, archived: 16384 }
}

joint_backing! {
    /// A joint map with several hypotheses of data association.
    pub struct Several: PlanarPose<f32> { features: 512, measurements: 256, hypotheses: 16 }
}
joint_backing! {
    /// The same with moving features.
    pub struct SeveralMoving: PlanarPose<f32> { features: 512, measurements: 256, movers: 256, hypotheses: 16 }
}

/// Starts the described filter, in memory that lasts as long as the program.
pub fn start(description: &Description<f32>) -> Result<Box<dyn Services<f32>>, StartError> {
    fn over<B: Backing<f32, Slam<'static>: Services<f32> + 'static> + 'static>(
        memory: Box<B>,
        description: &Description<f32>,
    ) -> Result<Box<dyn Services<f32>>, StartError> {
        Ok(Box::new(Box::leak(memory).start(description)?))
    }
    let Filter::Joint(joint) = &description.filter else {
        // A joint map's memory; starting a mixture in it fails.
        return over(Box::new(Still::new()), description);
    };
    // A description with more than one of these parts fails: the error names the part without memory.
    let (moves, calibrates) = (joint.movers.is_some(), joint.odometry.is_some());
    match (joint.hypotheses.is_some(), joint.archive_reach_m.is_some()) {
        (_, true) => over(Box::new(Archiving::new()), description),
        _ if calibrates => over(Box::new(Learning::new()), description),
        (true, _) if moves => over(Box::new(SeveralMoving::new()), description),
        (true, _) => over(Box::new(Several::new()), description),
        _ if moves => over(Box::new(Moving::new()), description),
        _ => over(Box::new(Still::new()), description),
    }
}
