//! Links only if no panic can be reached from setting up, predicting, scanning and estimating: whoever panics calls a function that
//! does not exist. In single precision or, with the feature `double`, in double; for a planar vehicle or, with the feature
//! `underwater`, for an underwater one; with the feature `joint`, for a planar vehicle with a joint map. With the feature `black-box` what is
//! left of a black box is replayed, and recorded once more.
#![no_std]
#![no_main]

#[cfg(feature = "planted-heap")]
extern crate alloc;

use core::hint::black_box;
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use scphd_firmware::board;
#[cfg(all(feature = "black-box", not(any(feature = "underwater", feature = "joint"))))]
use scphd_stream::planar::BlackBox as Kind;
#[cfg(all(feature = "black-box", feature = "joint"))]
use scphd_stream::planar::BlackBoxJoint as Kind;
#[cfg(all(not(feature = "black-box"), not(any(feature = "underwater", feature = "joint"))))]
use scphd_stream::planar::Planar as Kind;
#[cfg(all(not(feature = "black-box"), feature = "joint"))]
use scphd_stream::planar::PlanarJoint as Kind;
#[cfg(all(feature = "black-box", feature = "underwater"))]
use scphd_stream::underwater::BlackBox as Kind;
#[cfg(all(not(feature = "black-box"), feature = "underwater"))]
use scphd_stream::underwater::Underwater as Kind;
use scphd_stream::{Aboard, Monitor, ScanCost, Seen, replay};
use static_cell::ConstStaticCell;

#[cfg(not(feature = "double"))]
type Scalar = f32;
#[cfg(feature = "double")]
type Scalar = f64;

static MEMORY: ConstStaticCell<<Kind as Aboard<Scalar>>::Memory> =
    ConstStaticCell::new(<Kind as Aboard<Scalar>>::MEMORY);

/// Makes the compiler keep what it is told.
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

#[entry]
fn main() -> ! {
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

/// Hands out memory and never takes it back: enough to link.
#[cfg(feature = "planted-heap")]
mod planted {
    use core::alloc::{GlobalAlloc, Layout};

    struct Heap;

    // SAFETY: it never hands out anything.
    unsafe impl GlobalAlloc for Heap {
        unsafe fn alloc(&self, _layout: Layout) -> *mut u8 {
            core::ptr::null_mut()
        }

        unsafe fn dealloc(&self, _place: *mut u8, _layout: Layout) {}
    }

    #[global_allocator]
    static HEAP: Heap = Heap;
}
