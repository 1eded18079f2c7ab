//! The functions that start a filter in the memory of a set and those that give its services: some to each, so that a program links the
//! filters, and the services, of the sets that it names.

use crate::memory::{Asked, Entry, Seated, Zeroed};
use crate::pointer::{Bytes, Handed, Out};
use crate::running::{Filter, provide};
use crate::sets::{self, Set, memories};

use crate::{scphd_description, scphd_reason, scphd_slam, scphd_status};
use scphd_vehicle::Backing;

/// Makes the filter that is described in a caller's memory.
fn make<B: Backing<f32> + 'static>(
    set: &Set,
    entry: Entry,
    asked: Asked<scphd_slam>,
    mut description: Handed<scphd_description>,
) -> scphd_status
where
    Seated<B>: Zeroed,
{
    asked.make(set, entry, |seated: &'static mut Seated<B>, reason| {
        let Seated { slam, memory } = seated;
        let started = memory.start(&*description.enter()?).map_err(|error| reason.start(error))?;
        Ok(Filter::new(slam.write(started)))
    })
}

macro_rules! starts {
    ($($(#[doc = $about:literal])+ $name:ident = $number:literal, $bytes:literal bytes of $memory:ident: $start:ident, $resume:ident, $services:ident;)+) => { $(
            /// Starts the filter that is described in this memory, which is zero or was released.
            #[unsafe(no_mangle)]
            pub extern "C" fn $start(
                abi_version: u32,
                memory: Bytes,
                size_bytes: usize,
                description: Handed<scphd_description>,
                reason: Out<scphd_reason>,
                slam: Out<*mut scphd_slam>,
            ) -> scphd_status {
                let asked = Asked { abi_version, memory, size_bytes, reason, handle: slam };
                make::<memories::$memory>(&sets::$name, Entry::Start, asked, description)
            }

            /// Goes on with what the same build of this library has left in this memory.
            #[unsafe(no_mangle)]
            pub extern "C" fn $resume(
                abi_version: u32,
                memory: Bytes,
                size_bytes: usize,
                description: Handed<scphd_description>,
                reason: Out<scphd_reason>,
                slam: Out<*mut scphd_slam>,
            ) -> scphd_status {
                let asked = Asked { abi_version, memory, size_bytes, reason, handle: slam };
                make::<memories::$memory>(&sets::$name, Entry::Resume, asked, description)
            }

            /// Has the services of a filter in such memory at hand.
            #[unsafe(no_mangle)]
            pub extern "C" fn $services(slam: Handed<scphd_slam>) -> scphd_status {
                provide::<<memories::$memory as Backing<f32>>::Slam<'static>>(slam)
            }
    )+ };
}
sets::table!(starts);
