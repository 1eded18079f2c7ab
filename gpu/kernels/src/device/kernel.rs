//! The entry points of the device.

use super::group::{Buffers, Group, layout, whole};
use super::joint::Joint;
use super::room::Kind;
use crate::buffer::Layout;
use crate::launches::{Places, launches};
use crate::memory::{LargeMemory, Memory};
use core::arch::nvptx::{_block_dim_x, _block_idx_x, _thread_idx_x};

/// Runs the body of one thread of a one-dimensional grid, with its place among the threads of its filter. Threads beyond the last
/// place do nothing.
///
/// # Safety
/// Every pointer of the buffers is aligned and leads to as many values as the numbers of filters, runs, particles and samples
/// require. The values live and do not move until the last launch has ended; rooms and desks start as zeros. The launches
/// come in the order of [`LAUNCHES`](crate::LAUNCHES): those of a start, and then for every scan those of a prediction, once for
/// each prediction before it in the run that has most, those of a scan and, if requested, that of a digest.
/// Each launch has one thread for each place, and ends before the next begins.
#[inline(always)]
unsafe fn run<M: Kind>(
    places: Places,
    Filters { first, count, particles, samples }: &Filters<M>,
    body: impl FnOnce(usize, &Group<'_, M>),
    [scan, digest_every]: [u32; 2],
) {
    let [block, size, thread] = [_block_idx_x(), _block_dim_x(), _thread_idx_x()];
    let (filter, place) = if places == Places::Leader {
        (Some(block), Some(thread))
    } else {
        // Both fit into 32 bits, for which a device divides much faster.
        let place = block * size + thread;
        let each = places.count(M::PAGES, *particles as usize, *samples as usize) as u32;
        (place.checked_div(each), place.checked_rem(each))
    };
    if let (Some(filter), Some(place)) = (filter, place)
        && u64::from(filter) < *count
    {
        body(whole(place), &Group { own: &*first.add(whole(filter)), scan, digest_every });
    }
}

/// All filters of a launch.
#[repr(C)]
struct Filters<M: Kind> {
    first: *const Buffers<M>,
    count: u64,
    /// The greatest numbers of particles of a filter, and of samples of each.
    particles: u64,
    samples: u64,
}

/// The entry points for filters of one kind: one for each launch, and one that writes the layout of a filter's memory.
macro_rules! kernels {
    ($module:ident, $kind:ty, $prefix:literal, $({ $($file:ident::$body:ident $places:ident;)* })+) => {
        mod $module {
            use super::*;

            $($(
                #[unsafe(export_name = concat!($prefix, stringify!($body)))]
                unsafe extern "ptx-kernel" fn $body(filters: *const Filters<$kind>, scan: u32, digest_every: u32) {
                    let body = |place, group: &Group<'_, _>| super::super::$file::$body(place, group);
                    run(Places::$places, &*filters, body, [scan, digest_every]);
                }
            )*)+

            #[unsafe(export_name = concat!($prefix, "layout"))]
            unsafe extern "ptx-kernel" fn write_layout(to: *mut Layout, particles: u32, samples: u32) {
                to.write(layout::<$kind>(whole(particles), whole(samples)));
            }
        }
    };
}

launches!(kernels! { many, Memory, "scphd_many_", });
launches!(kernels! { large, LargeMemory, "scphd_large_", });
kernels! { joint, Joint, "scphd_joint_", { joint::start One; } { joint::scan Leader; } { joint::digest One; } }

unsafe extern "C" {
    safe fn scphd_a_panic_is_reachable() -> !;
}

/// No panic is reachable. Otherwise the module would need a function that is not defined anywhere.
#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    scphd_a_panic_is_reachable()
}
