//! Filters on the heap, with the capacities that the simulator has: joint maps, in the variants that vehicles have use for.

use scphd_vehicle::{Backing, Description, Filter, Services, StartError, joint_backing};

joint_backing! {
    /// A map.
    pub struct Still: PlanarPose<f32> { features: 1024, measurements: 256 }
}
joint_backing! {
    /// A map, and features that move.
    pub struct Moving: PlanarPose<f32> { features: 1024, measurements: 256, movers: 256 }
}
joint_backing! {
    /// A map, and what the odometry is off by.
    pub struct Learning: CalibratedPose<f32> { features: 1024, measurements: 256 }
}
joint_backing! {
    /// A map of the surroundings, and an archive of what is far away.
    pub struct Archiving: PlanarPose<f32> { features: 256, measurements: 256, archived: 16384 }
}

/// The filter of a description, over memory of its own, which lasts as long as the program.
///
/// # Errors
/// The description is out of range, or there is no memory with all that it asks for.
pub fn start(description: &Description<f32>) -> Result<Box<dyn Services<f32>>, StartError> {
    fn over<B: Backing<f32, Slam<'static>: Services<f32> + 'static> + 'static>(
        memory: Box<B>,
        description: &Description<f32>,
    ) -> Result<Box<dyn Services<f32>>, StartError> {
        Ok(Box::new(Box::leak(memory).start(description)?))
    }
    let Filter::Joint(joint) = &description.filter else {
        // Which finds no room there.
        return over(Box::new(Still::new()), description);
    };
    // One of them; a description with more finds no room for the other part, which the error names.
    match (joint.movers.is_some(), joint.odometry.is_some(), joint.archive_reach_m.is_some()) {
        (_, true, _) => over(Box::new(Learning::new()), description),
        (_, _, true) => over(Box::new(Archiving::new()), description),
        (true, ..) => over(Box::new(Moving::new()), description),
        _ => over(Box::new(Still::new()), description),
    }
}
