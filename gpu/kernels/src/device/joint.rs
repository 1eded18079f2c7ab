//! Joint maps on a device: one for each block of threads. The leader, which is the last thread of the block, does the scan, and
//! the others help it with the loops over features and rows of the covariance.

use super::group::{Group, whole};
use super::room::{Kind, Many};
use super::tell::{Outputs, of_estimate};
use crate::buffer::{ScanResult, Status};
use crate::launches::HELPERS;
use crate::memory::{JointMemory, JointTracks};
use crate::setup::{Sighting, control_of, describe};
use core::arch::nvptx::_syncthreads as wait;
use core::mem::MaybeUninit;
use nalgebra::Vector2;
use scphd::JointSlam;
use scphd::models::{PlanarMotion, PlanarPose};
use scphd::storage::{FeaturePass, FeatureRows, FeatureTask, Landmark, NoArchive, Pending, RowExecutor, Tracked};
use scphd_vehicle::{Description, Filter};

type Pose = PlanarPose<f32>;
type Position = Vector2<f32>;
type Slam<'s> = JointSlam<'s, PlanarMotion<f32>, Position, NoArchive, Option<Tracked<'s, Pose>>>;

/// Joint maps, one for each block of threads.
pub(super) struct Joint;

impl Kind for Joint {
    const PAGES: [usize; 2] = [0; 2];
    type Room = JointRoom;
    type Desk = u32;
}

/// A joint map, and the loop in which the threads of its block help. It starts as zeros.
pub(super) struct JointRoom {
    state: JointMemory,
    movers: JointTracks,
    slam: MaybeUninit<Slam<'static>>,
    sensor: MaybeUninit<Sighting>,
    shared: MaybeUninit<Shared>,
}

/// A loop whose passes the threads of a block share.
#[derive(Clone, Copy)]
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
        // SAFETY: the place is that of this block, and the helpers use it between the barriers, in which the leader waits. Leader and
        // helpers wait equally often.
        unsafe {
            self.0.write(MaybeUninit::new(shared));
            wait();
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
        let numbers = Many::lent(numbers);
        let (rows, landmarks) = (Many::lent(rows), Many::lent(landmarks));
        self.share(Shared::Features { task: pass.to_task(), numbers, rows, landmarks });
    }

    fn each_part(&self, pending: &Pending<'_, Pose, Position>, numbers: &mut [f32], features: usize) {
        let pending = core::ptr::from_ref(pending).cast();
        self.share(Shared::Parts { pending, numbers: Many::lent(numbers), features });
    }
}

impl Shared {
    /// The passes of one helper. Safety: each pass is done by one helper, and what all of them read is written by none.
    unsafe fn help(&self, helper: usize) {
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
                    (**pending).add_to(*features, part, numbers.some(range));
                    part += HELPERS;
                }
            }
            Self::Nothing => {}
        }
    }
}

/// What a helper of a block does in a launch, in which the leader scans. Safety: the leader has written the loop before the first
/// barrier, and waits at the second.
unsafe fn help(helper: usize, group: &Group<'_, Joint>) {
    loop {
        wait();
        match (*group.room).shared.assume_init_ref() {
            Shared::Nothing => return,
            shared => shared.help(helper),
        }
        wait();
    }
}

/// Starts the filter. Safety: no other thread runs.
pub(super) unsafe fn start(_place: usize, group: &Group<'_, Joint>) {
    let code = if begin(group).is_some() { Status::DONE } else { Status::SETUP };
    *group.status = Status { code, scans: 0 };
}

/// Safety: a room starts as zeros, which are a valid value, and does not move, so that it can hold pointers to its own parts.
unsafe fn begin(group: &Group<'_, Joint>) -> Option<()> {
    let (room, run) = (&mut *group.room, &*group.run);
    let mut description = Description::robot();
    let (motion, sensor) = describe(&mut description, &run.setup)?;
    let Filter::Joint(joint) = description.filter else { return None };
    let movers = joint.movers.map(|moving| (&mut room.movers, moving));
    let mut slam = JointSlam::new(motion, joint.config, &mut room.state).ok()?.with_movers_if(movers).ok()?;
    slam.reset(description.start.pose).ok()?;
    (room.slam, room.sensor) = (MaybeUninit::new(slam), MaybeUninit::new(sensor));
    Some(())
}

/// Does the predictions before a scan, and the scan. Safety: only the leader of the block uses filter and sensor, which `start` has
/// initialised.
pub(super) unsafe fn scan(thread: usize, group: &Group<'_, Joint>) {
    if thread < HELPERS {
        return help(thread, group);
    }
    if group.goes_on() {
        let (slam, sensor) = ((*group.room).slam.assume_init_mut(), (*group.room).sensor.assume_init_ref());
        let rows = Leader(&raw mut (*group.room).shared);
        *group.status = match step(slam, sensor, &rows, group) {
            Ok(()) => Status { code: Status::DONE, scans: group.scan + 1 },
            Err(code) => Status { code, scans: group.scan },
        };
    }
    (*group.room).shared = MaybeUninit::new(Shared::Nothing);
    wait();
}

/// Safety: no other thread runs; there is a result for every scan.
unsafe fn step(
    slam: &mut Slam<'static>,
    sensor: &Sighting,
    rows: &Leader,
    group: &Group<'_, Joint>,
) -> Result<(), u32> {
    for prediction in group.predictions() {
        let control = control_of(slam.motion(), prediction.control);
        slam.predict(&control, prediction.dt_s).map_err(|_| Status::PREDICTION)?;
    }
    let mean = slam.estimate_pose().ok_or(Status::SCAN)?.mean;
    (*group.results.add(whole(group.scan))).predicted = [mean.x_m, mean.y_m, mean.heading_rad];
    let report = slam.scan_on(sensor, group.measurements(), rows).map_err(|_| Status::SCAN)?;
    let estimate = slam.estimate_pose().ok_or(Status::SCAN)?;
    let result = ScanResult {
        n_eff: 1.0,
        ln_evidence: report.ln_evidence,
        innovation: report.innovation,
        expected_features: slam.expected_features(),
        in_view: report.in_view as u32,
        no_birth: report.no_birth as u32,
        ..of_estimate(&estimate, report.health)
    };
    Outputs::of(group).write(whole(group.scan), result, slam.features(), slam.moving())
}

/// Computes the digest of the state after a scan, if it is requested.
pub(super) unsafe fn digest(_place: usize, group: &Group<'_, Joint>) {
    if group.asks_for_digest() {
        (*group.results.add(whole(group.scan))).digest = bytemuck::cast((*group.room).slam.assume_init_ref().digest());
    }
}
