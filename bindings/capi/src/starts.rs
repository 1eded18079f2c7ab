//! Functions of each set that start a filter in its memory and give its services: separate ones for each set, so that a program
//! links only the filters and services that it uses.

use crate::memory::{Asked, Entry, Seated, Zeroed};
use crate::pointer::{Bytes, Handed, Out};
use crate::running::{Filter, provide};
use crate::sets::{self, Set, memories};

use crate::{scphd_description, scphd_reason, scphd_slam, scphd_status};
use scphd_vehicle::Backing;

/// Starts the described filter in the caller's memory.
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
            /// Starts the described filter in this memory, which is zero or was released.
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

            /// Resumes the filter that the same build of this library has left in this memory.
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

            /// Makes the services of a filter in this memory available.
            #[unsafe(no_mangle)]
            pub extern "C" fn $services(slam: Handed<scphd_slam>) -> scphd_status {
                provide::<<memories::$memory as Backing<f32>>::Slam<'static>>(slam)
            }
    )+ };
}
sets::table!(starts);
