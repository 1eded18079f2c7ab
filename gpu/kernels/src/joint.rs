//! Joint maps on a device: one for each block of threads. The leader, which is the last thread of the block, does the scan, and
//! the others help it with the loops over features and rows of the covariance.

use crate::buffer::{ScanResult, Status, halves};
use crate::group::{asks, goes_on, inputs, outputs, whole};
use crate::kind::Kind;
use crate::room::{Group, Many};
use crate::run::{before, of_estimate};
use crate::setup::{Sighting, control_of, describe};
use crate::slot::MEASUREMENTS;
use core::mem::MaybeUninit;
use nalgebra::Vector2;
use scphd::models::{PlanarMotion, PlanarPose};
use scphd::storage::{
    FeaturePass, FeatureRows, FeatureTask, JointMovers, Landmark, NoArchive, Pending, RowExecutor, Tracked,
    joint_numbers,
};
use scphd::{JointSlam, JointState};
use scphd_vehicle::{Description, Filter};

/// Capacity for features of a joint map.
pub const JOINT_FEATURES: usize = 512;
/// Capacity for moving-object tracks.
const TRACKS: usize = 256;
/// Number of threads that help the leader of a block.
pub const HELPERS: usize = 32;

type Pose = PlanarPose<f32>;
type Position = Vector2<f32>;
type State = JointState<Pose, Position, JOINT_FEATURES, { joint_numbers(3, 2, JOINT_FEATURES) }, MEASUREMENTS>;
type Slam<'s> = JointSlam<'s, PlanarMotion<f32>, Position, NoArchive, Option<Tracked<'s, Pose>>>;

/// Joint maps, one for each block of threads.
#[derive(Debug)]
pub struct Joint;

impl Kind for Joint {
    const NAME: &'static str = "scphd_joint";
    const PAGES: usize = 0;
    const MOVING_PAGES: usize = 0;
    type Room = JointRoom;
    type Desk = u32;
}

/// A joint map, and the loop in which the threads of its block help. It starts as zeros.
#[derive(Debug)]
pub struct JointRoom {
    state: State,
    movers: JointMovers<Pose, TRACKS>,
    slam: MaybeUninit<Slam<'static>>,
    sensor: MaybeUninit<Sighting>,
    shared: MaybeUninit<Shared>,
}

/// A loop whose passes the threads of a block share.
#[derive(Debug, Clone, Copy)]
enum Shared {
    Features {
        task: FeatureTask<Pose, Position>,
        numbers: Many<f32>,
        rows: Many<FeatureRows<Pose, Position>>,
        landmarks: Many<Landmark<Position>>,
    },
    Parts {
        pending: *const Pending<'static, Pose, Position>,
        numbers: Many<f32>,
        features: usize,
    },
    /// The scan is done.
    Nothing,
}

/// The leader of a block, with the place of the loop that is shared.
struct Leader(*mut MaybeUninit<Shared>);

impl Leader {
    fn share(&self, shared: Shared) {
        // SAFETY: the place is that of this block, and the helpers use it between the barriers, in which the leader waits. A host
        // does what each of them would.
        unsafe {
            self.0.write(MaybeUninit::new(shared));
            wait();
            if cfg!(not(target_arch = "nvptx64")) {
                (0..HELPERS).for_each(|helper| (*self.0).assume_init_ref().help(helper));
            }
            wait();
        }
    }
}

impl RowExecutor<Pose, Position> for Leader {
    fn each_feature(
        &self,
        pass: &impl FeaturePass<Pose, Position>,
        numbers: &[f32],
        rows: &mut [FeatureRows<Pose, Position>],
        landmarks: &mut [Landmark<Position>],
    ) {
        let numbers = Many::read(numbers);
        let (rows, landmarks) = (Many::lent(rows), Many::lent(landmarks));
        self.share(Shared::Features { task: pass.to_task(), numbers, rows, landmarks });
    }

    fn each_part(&self, pending: &Pending<'_, Pose, Position>, numbers: &mut [f32], features: usize) {
        let pending = core::ptr::from_ref(pending).cast();
        self.share(Shared::Parts { pending, numbers: Many::lent(numbers), features });
    }
}

/// Waits until all threads of the block are here. On a host there is only the leader.
unsafe fn wait() {
    #[cfg(target_arch = "nvptx64")]
    // SAFETY: leader and helpers wait equally often.
    unsafe {
        core::arch::nvptx::_syncthreads();
    }
}

impl Shared {
    /// The passes of one helper.
    unsafe fn help(&self, helper: usize) {
        // SAFETY: each pass is done by one helper, and what all of them read is written by none.
        unsafe {
            match self {
                Self::Features { task, numbers, rows, landmarks } => {
                    let mut feature = helper;
                    while let Some(rows) = rows.one(feature)
                        && let Some(landmark) = landmarks.one(feature)
                    {
                        task.run(numbers.all(), feature, rows, landmark);
                        feature += HELPERS;
                    }
                }
                Self::Parts { pending, numbers, features } => {
                    let mut part = helper;
                    while let Some(range) = Pending::<Pose, Position>::part(*features, part) {
                        (**pending).add_to(*features, part, numbers.some(range.start, range.len()));
                        part += HELPERS;
                    }
                }
                Self::Nothing => {}
            }
        }
    }
}

/// What a helper of a block does in a launch.
///
/// # Safety
/// The leader of the block calls [`scan`] in the same launch.
#[cfg(target_arch = "nvptx64")]
pub(crate) unsafe fn help(helper: usize, group: &Group<Joint>) {
    // SAFETY: the leader has written the loop before the first barrier, and waits at the second.
    unsafe {
        loop {
            wait();
            match (*group.rooms).shared.assume_init_ref() {
                Shared::Nothing => return,
                shared => shared.help(helper),
            }
            wait();
        }
    }
}

/// Starts the filter.
pub(crate) unsafe fn start(place: usize, group: &Group<Joint>, _scan: u32, _digest_every: u32) {
    if place == 0 {
        // SAFETY: no other thread runs.
        unsafe {
            let code = if begin(group).is_some() { Status::DONE } else { Status::SETUP };
            *group.statuses = Status { code, scans: 0 };
        }
    }
}

unsafe fn begin(group: &Group<Joint>) -> Option<()> {
    // SAFETY: a room starts as zeros, which are a valid value, and does not move, so that it can hold pointers to its own parts.
    let (room, run) = unsafe { (&mut *group.rooms, &*group.runs) };
    let mut description = Description::robot();
    let (motion, sensor) = describe(&mut description, &run.setup)?;
    let Filter::Joint(joint) = description.filter else { return None };
    let movers = joint.movers.map(|moving| (&mut room.movers, moving));
    let mut slam = JointSlam::new(motion, joint.config, &mut room.state).ok()?.with_movers_if(movers).ok()?;
    slam.reset(description.start.pose).ok()?;
    (room.slam, room.sensor) = (MaybeUninit::new(slam), MaybeUninit::new(sensor));
    Some(())
}

/// Does the predictions before a scan, and the scan.
pub(crate) unsafe fn scan(_place: usize, group: &Group<Joint>, scan: u32, _digest_every: u32) {
    // SAFETY: only the leader of the block runs this, and `start` has initialised filter and sensor.
    unsafe {
        if goes_on(group, scan) {
            let (slam, sensor) = ((*group.rooms).slam.assume_init_mut(), (*group.rooms).sensor.assume_init_ref());
            let rows = Leader(&raw mut (*group.rooms).shared);
            *group.statuses = match step(slam, sensor, &rows, group, whole(scan)) {
                Ok(()) => Status { code: Status::DONE, scans: scan + 1 },
                Err(code) => Status { code, scans: scan },
            };
        }
        (*group.rooms).shared = MaybeUninit::new(Shared::Nothing);
        wait();
    }
}

unsafe fn step(
    slam: &mut Slam<'static>,
    sensor: &Sighting,
    rows: &Leader,
    group: &Group<Joint>,
    scan: usize,
) -> Result<(), u32> {
    // SAFETY: the inputs and outputs are where the run says.
    let (inputs, mut outputs) = unsafe { (inputs(group), outputs(group)) };
    let (predictions, measurements) = before(inputs, scan)?;
    for prediction in predictions {
        let control = control_of(slam.motion(), prediction.control);
        slam.predict(&control, prediction.dt_s).map_err(|_| Status::PREDICTION)?;
    }
    let report = slam.scan_on(sensor, measurements, rows).map_err(|_| Status::SCAN)?;
    let estimate = slam.estimate_pose().ok_or(Status::SCAN)?;
    let result = ScanResult {
        n_eff: 1.0,
        ln_evidence: report.ln_evidence,
        innovation: report.innovation,
        expected_features: slam.expected_features(),
        in_view: report.in_view as u32,
        no_birth: report.no_birth as u32,
        peak_pages: report.features as u32,
        peak_moving_pages: report.movers as u32,
        ..of_estimate(&estimate, report.health)
    };
    outputs.write(scan, result, slam.features(), slam.moving())
}

/// Computes the digest of the state after a scan, if it is requested.
pub(crate) unsafe fn digest(place: usize, group: &Group<Joint>, scan: u32, digest_every: u32) {
    // SAFETY: no other thread runs; there is a result for every scan.
    unsafe {
        if place == 0 && asks(group, scan, digest_every) {
            (*group.results.add(whole(scan))).digest = halves((*group.rooms).slam.assume_init_ref().digest());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{JointMovers, State, TRACKS};
    use scphd::models::PlanarPose;

    /// What zeros are as a value, shown.
    fn zeros<T: std::fmt::Debug>() -> String {
        let mut zeros = Box::<T>::new_uninit();
        // SAFETY: the value is compared with a new one; numbers and arrays of numbers may be zero.
        let zeros = unsafe {
            zeros.as_mut_ptr().write_bytes(0, 1);
            zeros.assume_init_ref()
        };
        format!("{zeros:?}")
    }

    #[test]
    fn zeros_are_a_new_joint_map() {
        static NEW: State = State::new();
        assert!(zeros::<State>() == format!("{NEW:?}"));
        assert_eq!(
            zeros::<JointMovers<PlanarPose<f32>, TRACKS>>(),
            format!("{:?}", JointMovers::<PlanarPose<f32>, TRACKS>::new())
        );
    }
}
