//! Links only if no panic is reachable from setup, prediction, scan and estimate: a panic would call a function that nobody
//! defines. In single precision, or in double precision with the feature `double`; for a planar vehicle, for an underwater
//! vehicle with the feature `underwater`; with a joint map with the feature `joint`. With the feature `black-box` the remaining
//! records of a black box are replayed and recorded again. With the feature `sensors` posts are found, and messages of flight
//! stacks are read and written.
#![no_std]
#![no_main]

#[cfg(feature = "planted-heap")]
extern crate alloc;

use core::hint::black_box;
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use scphd_firmware::board;
#[cfg(all(not(feature = "black-box"), not(feature = "underwater"), feature = "joint"))]
use scphd_firmware::joint::Joint as Kind;
#[cfg(all(feature = "black-box", not(any(feature = "underwater", feature = "joint"))))]
use scphd_stream::planar::BlackBox as Kind;
#[cfg(all(feature = "black-box", feature = "joint"))]
use scphd_stream::planar::BlackBoxJoint as Kind;
#[cfg(all(not(feature = "black-box"), not(any(feature = "underwater", feature = "joint"))))]
use scphd_stream::planar::Planar as Kind;
#[cfg(all(feature = "black-box", feature = "underwater"))]
use scphd_stream::underwater::BlackBox as Kind;
#[cfg(all(not(feature = "black-box"), feature = "underwater", not(feature = "joint")))]
use scphd_stream::underwater::Underwater as Kind;
#[cfg(all(not(feature = "black-box"), feature = "underwater", feature = "joint"))]
use scphd_stream::underwater::UnderwaterJoint as Kind;
use scphd_stream::{Aboard, Monitor, ScanCost, Seen, replay};
use static_cell::ConstStaticCell;

#[cfg(not(feature = "double"))]
type Scalar = f32;
#[cfg(feature = "double")]
type Scalar = f64;

static MEMORY: ConstStaticCell<<Kind as Aboard<Scalar>>::Memory> =
    ConstStaticCell::new(<Kind as Aboard<Scalar>>::MEMORY);

/// Prevents the compiler from removing the results.
struct Witness;

impl Monitor for Witness {
    fn scanned(&mut self, cost: &ScanCost, seen: &Seen, digest: u64) {
        black_box((cost, seen, digest));
        #[cfg(feature = "planted-panic")]
        assert_ne!(black_box(digest), 1, "planted");
        #[cfg(feature = "planted-heap")]
        black_box(alloc::vec![digest; black_box(1)]);
    }
}

/// Finds posts in lidar bytes and in ranges, and encodes and decodes messages.
#[cfg(feature = "sensors")]
fn sensors(mut bytes: &[u8]) -> Option<()> {
    use scphd_lidar::{Assembler, LaserScan, PostFinder, PostSettings, Sweep};
    use scphd_mavlink::{Clock, Heartbeat, Incoming, Origin, ResetCounter, Sender, VisionPosition};

    let (mut lidar, mut assembler) = (scphd_lidar::Receiver::new(), Assembler::<512>::new());
    let finder = PostFinder::new(black_box(PostSettings::of_radius(0.1))).ok()?;
    while let Ok(Some(packet)) = lidar.read(&mut bytes) {
        if let Some(revolution) = assembler.push(&packet) {
            black_box(finder.find::<32, _>(revolution));
        }
    }
    let range_max_m = black_box(12.0);
    let sweep = Sweep { start_rad: -3.0, increment_rad: 0.01, range_min_m: 0.1, range_max_m, duration_s: 0.1 };
    let found = finder.find::<32, _>(&LaserScan::new(black_box(sweep), &black_box([1.0; 600])[..], &[]).ok()?);
    black_box(found.posts.first().map(|post| post.at_end(black_box(1.0), 0.1)));

    let mut bytes = board::stream();
    let (mut receiver, mut sender, mut clock) = (scphd_mavlink::Receiver::new(), Sender::new(1, 197), Clock::default());
    let mut resets = ResetCounter::new(0.5, 0.1);
    while let Some(received) = receiver.read(&mut bytes) {
        match received.message {
            Incoming::Odometry(odometry) => {
                let (pose, time_us) = (odometry.pose, odometry.time_us);
                resets.between(pose.position_m, pose.attitude_rad);
                let reset_counter = resets.value();
                let vision = VisionPosition { time_us, frame: odometry.frame, pose, reset_counter };
                black_box((sender.frame(&odometry), sender.frame(&vision), sender.frame(&Heartbeat)));
                black_box(clock.ours_ns(time_us));
            }
            Incoming::TimeSync(answer) => {
                black_box((clock.take(&answer, black_box(7)), answer.answer(9).map(|answer| sender.frame(&answer))));
            }
            Incoming::Satellite(satellite) => {
                black_box(Origin::new(black_box(1), 2).place(&satellite));
            }
            Incoming::Target(target) => {
                black_box(target.in_plane());
            }
            _ => {}
        }
    }
    Some(())
}

#[entry]
fn main() -> ! {
    #[cfg(feature = "sensors")]
    black_box(sensors(board::stream()));
    if let Some(memory) = MEMORY.try_take() {
        let _ = black_box(replay::<Kind, Scalar>(board::stream(), memory, u32::MAX, &mut Witness));
        #[cfg(feature = "black-box")]
        {
            let _ = black_box(scphd_stream::recover::<Kind, Scalar>(board::stream(), memory, &mut Witness));
            let sink = |bytes: &[u8]| black_box(if bytes.is_empty() { Err(()) } else { Ok(()) });
            let _ = black_box(scphd_stream::rerecord::<Kind, Scalar, ()>(board::stream(), memory, 50, sink));
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}

unsafe extern "C" {
    safe fn a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_info: &PanicInfo<'_>) -> ! {
    a_panic_is_reachable()
}

/// An allocator that gives no memory: sufficient to link.
#[cfg(feature = "planted-heap")]
mod planted {
    use core::alloc::{GlobalAlloc, Layout};

    struct Heap;

    // SAFETY: it never returns memory.
    unsafe impl GlobalAlloc for Heap {
        unsafe fn alloc(&self, _layout: Layout) -> *mut u8 {
            core::ptr::null_mut()
        }

        unsafe fn dealloc(&self, _place: *mut u8, _layout: Layout) {}
    }

    #[global_allocator]
    static HEAP: Heap = Heap;
}
