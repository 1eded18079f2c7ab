//! Creation of a handle in the user's memory, and exclusive access to it during a call.
//!
//! The handle has references to the state behind it, so that the block must not be moved. The tag has its address, so that a copy
//! is recognised. The state is initialised in place, as zeros, and never moved or copied.

use crate::block::{ALIGNMENT, Block, Handle, Head, Tag};
use crate::pointer::{self, Bytes, Handed, Out};
use crate::reason::Reason;
use crate::sets::{self, Set};
use crate::{SCPHD_ABI_VERSION, scphd_reason, scphd_status, version};
use core::mem::MaybeUninit;
use core::ops::{Deref, DerefMut};
use core::ptr::{addr_of, addr_of_mut};
use core::sync::atomic::{AtomicU32, Ordering};
use scphd::models::Pose;
use scphd::numerics::Vector;
use scphd::storage::MapStorage;
use scphd::{DetectorMemory, State};
use scphd_vehicle::Backing;

/// Magic number of memory with a state and a handle.
const STARTED: u32 = 0x5c9b_d001;
/// Magic number of memory with a state, but without a handle.
const HELD: u32 = 0x5c9b_d002;

/// A state whose initial value is all zeros.
///
/// # Safety
/// All bytes zero are a valid value: the one that its `new` returns.
pub unsafe trait Zeroed: 'static {}

// SAFETY: numbers, and an `Option` whose `None` is zero; checked by `tests::states_begin_as_zeros`.
unsafe impl<P: Pose + 'static, const N: usize, const C: usize, S: 'static, V: 'static> Zeroed for State<P, N, C, S, V>
where
    S: MapStorage<scphd::storage::Static<P::Position>>,
    V: MapStorage<scphd::storage::Dynamic<P::Position>>,
{
}
// SAFETY: as above.
unsafe impl<Z: Vector + 'static, const N: usize> Zeroed for DetectorMemory<Z, N> {}

/// The empty state of a type whose data are all in the handle.
#[derive(Debug)]
pub(crate) struct NoState;

// SAFETY: it has no bytes.
unsafe impl Zeroed for NoState {}

/// The memory of a filter, and the place of the filter that uses it.
pub(crate) struct Seated<B: Backing<f32> + 'static> {
    pub(crate) slam: MaybeUninit<B::Slam<'static>>,
    pub(crate) memory: B,
}

macro_rules! zeroed {
    ($($(#[doc = $about:literal])+ $name:ident = $number:literal, $bytes:literal bytes of $memory:ident: $start:ident, $resume:ident, $services:ident;)+) => { $(
        // SAFETY: an uninitialised filter, and states, movers and archives, which are numbers; checked by
        // `tests::states_begin_as_zeros`.
        unsafe impl Zeroed for Seated<sets::memories::$memory> {}
    )+ };
}
sets::table!(zeroed);

/// Origin of the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Entry {
    /// The state is initialised with zeros.
    Start,
    /// The state was left by an earlier handle.
    Resume,
}

/// The user's memory before there is a handle.
#[derive(Debug, Clone, Copy)]
struct Memory<'a> {
    bytes: Bytes,
    set: &'a Set,
    entry: Entry,
}

/// The arguments of a function that creates a handle.
pub(crate) struct Asked<H> {
    pub(crate) abi_version: u32,
    pub(crate) memory: Bytes,
    pub(crate) size_bytes: usize,
    pub(crate) reason: Out<scphd_reason>,
    pub(crate) handle: Out<*mut H>,
}

impl<H: Handle> Asked<H> {
    /// Creates a handle over the state in the memory.
    pub(crate) fn make<S: Zeroed>(
        mut self,
        set: &Set,
        entry: Entry,
        make: impl FnOnce(&'static mut S, &mut Reason<'_>) -> Result<H::Inner, scphd_status>,
    ) -> scphd_status {
        scphd_status::of(hand_out(self.handle, || {
            version::check(self.abi_version)?;
            let mut reason = Reason::of(&mut self.reason)?;
            let memory = Memory::of(self.memory, self.size_bytes, set, entry)?;
            memory.make::<H, S>(|state| make(state, &mut reason))
        }))
    }
}

impl<'a> Memory<'a> {
    /// The caller's memory for a set; checks the pointer and the size.
    fn of(bytes: Bytes, size: usize, set: &'a Set, entry: Entry) -> Result<Self, scphd_status> {
        check_bytes(bytes)?;
        if size < set.bytes { Err(scphd_status::MemoryTooSmall) } else { Ok(Self { bytes, set, entry }) }
    }

    /// Creates a handle over the state in this memory.
    fn make<H: Handle, S: Zeroed>(
        self,
        make: impl FnOnce(&'static mut S) -> Result<H::Inner, scphd_status>,
    ) -> Result<*mut H, scphd_status> {
        let block = self.bytes.0.cast::<Block<H::Inner, S>>();
        let tag = block.cast::<Tag>();
        let layout = size_of::<Block<H::Inner, S>>() as u32;
        let fresh = Tag {
            magic: HELD,
            set: self.set.number,
            version: SCPHD_ABI_VERSION,
            layout,
            address: 0,
            busy: AtomicU32::new(0),
        };
        // SAFETY: `of` has checked that the pointer is valid and aligned, and that the size is at least that of the set, which
        // `sizes.rs` ensures is at least that of a `Block`. The caller guarantees that the memory is initialised, and that
        // nothing else uses it. Any bytes are a valid tag. A reference to the state is created only if nothing else has one; its
        // bytes are a valid value by `Zeroed`, or because the tag shows that such a state was left there.
        unsafe {
            let found = &mut *tag;
            let known = found.magic == STARTED || found.magic == HELD;
            match self.entry {
                Entry::Start if known => return Err(scphd_status::AlreadyStarted),
                Entry::Start => block.cast::<u8>().write_bytes(0, size_of::<Block<H::Inner, S>>()),
                Entry::Resume if !known => return Err(scphd_status::NotStarted),
                Entry::Resume if found.set != self.set.number || found.layout != layout => {
                    return Err(scphd_status::WrongMemory);
                }
                Entry::Resume if found.version != SCPHD_ABI_VERSION => return Err(scphd_status::WrongVersion),
                Entry::Resume if *found.busy.get_mut() != 0 => return Err(scphd_status::Interrupted),
                Entry::Resume => {}
            }
            // Invalidates the previous handle, even if the new one cannot be created.
            if self.entry == Entry::Resume {
                tag.write(fresh);
            }
            let inner = make(&mut *addr_of_mut!((*block).state))?;
            addr_of_mut!((*block).head.handle).write(MaybeUninit::new(inner));
            let busy = AtomicU32::new(0);
            let address = self.bytes.0.addr();
            let (set, version) = (self.set.number, SCPHD_ABI_VERSION);
            tag.write(Tag { magic: STARTED, set, version, layout, address, busy });
        }
        Ok(block.cast())
    }
}

fn check_bytes(bytes: Bytes) -> Result<(), scphd_status> {
    pointer::check(bytes.0.cast::<Head<()>>())
}

/// Exclusive access to a handle during a call.
#[derive(Debug)]
pub(crate) struct Entered<'h, F> {
    busy: &'h AtomicU32,
    handle: &'h mut F,
}

impl<H: Handle> Handed<H> {
    /// Gives exclusive access to the value behind the pointer, until the result is dropped.
    // One copy in an image, not one in every function.
    #[inline(never)]
    pub(crate) fn enter(&mut self) -> Result<Entered<'_, H::Inner>, scphd_status> {
        let head = self.0.cast::<Head<H::Inner>>();
        pointer::check(head)?;
        // SAFETY: not null and aligned; the caller guarantees that the memory of a set lies there, initialised, and therefore no
        // smaller than a `Head`. The tag shows whether there is a handle of this type, and `busy` that nothing else has a
        // reference to it.
        unsafe {
            let tag = &*addr_of!((*head).tag);
            if tag.magic != STARTED || tag.address != head.addr() {
                return Err(scphd_status::NotStarted);
            }
            if tag.set / 100 != H::KIND {
                return Err(scphd_status::WrongMemory);
            }
            if tag.busy.swap(1, Ordering::Acquire) != 0 {
                return Err(scphd_status::Busy);
            }
            Ok(Entered { busy: &tag.busy, handle: (*addr_of_mut!((*head).handle)).assume_init_mut() })
        }
    }
}

impl<F> Drop for Entered<'_, F> {
    fn drop(&mut self) {
        self.busy.store(0, Ordering::Release);
    }
}

impl<F> Deref for Entered<'_, F> {
    type Target = F;

    fn deref(&self) -> &F {
        self.handle
    }
}

impl<F> DerefMut for Entered<'_, F> {
    fn deref_mut(&mut self) -> &mut F {
        self.handle
    }
}

/// Writes the pointer of a new handle to the caller, after checking the caller's pointer.
fn hand_out<H>(mut to: Out<*mut H>, make: impl FnOnce() -> Result<*mut H, scphd_status>) -> Result<(), scphd_status> {
    let place = to.place()?;
    place.write(core::ptr::null_mut());
    place.write(make()?);
    Ok(())
}

/// Required alignment of the memory of every set, bytes: `SCPHD_ALIGNMENT`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_memory_alignment() -> usize {
    ALIGNMENT
}

/// Releases this memory, whatever it contains; it can then be started again. Earlier handles to it are refused from then on.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_release(memory: Bytes, size_bytes: usize) -> scphd_status {
    if let Err(status) = check_bytes(memory) {
        return status;
    }
    if size_bytes < size_of::<Tag>() {
        return scphd_status::MemoryTooSmall;
    }
    // SAFETY: not null, aligned, large enough for a tag; the caller guarantees that no call uses it.
    unsafe { memory.0.cast::<u8>().write_bytes(0, size_of::<Tag>()) };
    scphd_status::Ok
}

#[cfg(test)]
mod tests {
    use super::{MaybeUninit, scphd_release};
    use crate::pointer::{Bytes, Handed, Out};
    use crate::sets::{self, memories};
    use crate::{
        SCPHD_ABI_VERSION, scphd_description_start, scphd_resume_joint_40, scphd_start_joint_40, scphd_status,
    };

    /// Whether all bytes of a state in a `static` are zero, including the padding.
    fn is_zero<S>(state: &MaybeUninit<S>) -> bool {
        let bytes = state.as_ptr().cast::<u8>();
        // SAFETY: the statics below are initialised by the loader, byte by byte.
        (0..size_of::<S>()).all(|at| unsafe { bytes.add(at).read_volatile() } == 0)
    }

    #[test]
    fn a_nested_call_is_refused_and_an_interrupted_call_is_reported() {
        const BYTES: usize = 32_768;
        let (mut memory, mut about) = (vec![0_u64; BYTES / 8], vec![0_u64; BYTES / 8]);
        // SAFETY: the memories exist until the end of the test, and nothing else uses them.
        let [bytes, about] = [&mut memory, &mut about].map(|memory| unsafe { Bytes::of(memory.as_mut_ptr().cast()) });
        let mut description = core::ptr::null_mut();
        // SAFETY: as above.
        let place = unsafe { Out::of(&raw mut description) };
        assert_eq!(scphd_description_start(SCPHD_ABI_VERSION, about, BYTES, place), scphd_status::Ok);
        // SAFETY: as above.
        let asked = || unsafe { Handed::of(description) };
        let mut handle = core::ptr::null_mut();
        // SAFETY: as above.
        let place = unsafe { Out::of(&raw mut handle) };
        let start = || scphd_start_joint_40(SCPHD_ABI_VERSION, bytes, BYTES, asked(), Out::NULL, place);
        let resume = || scphd_resume_joint_40(SCPHD_ABI_VERSION, bytes, BYTES, asked(), Out::NULL, place);
        assert_eq!(start(), scphd_status::Ok);
        // SAFETY: as above.
        let (mut first, mut second) = unsafe { (Handed::of(handle), Handed::of(handle)) };
        let entered = first.enter().unwrap();
        assert_eq!(second.enter().err(), Some(scphd_status::Busy));
        drop(entered);
        assert!(second.enter().is_ok());
        core::mem::forget(second.enter());
        assert_eq!(resume(), scphd_status::Interrupted);
        assert_eq!(scphd_release(bytes, BYTES), scphd_status::Ok);
        assert_eq!([start(), resume()], [scphd_status::Ok; 2]);
    }

    #[test]
    fn states_begin_as_zeros() {
        macro_rules! check {
            ($($(#[doc = $about:literal])+ $name:ident = $number:literal, $bytes:literal bytes of $memory:ident: $start:ident, $resume:ident, $services:ident;)+) => {
                check!($($memory),+)
            };
            ($($memory:ident),+) => { $({
                static NEW: MaybeUninit<memories::$memory> = MaybeUninit::new(memories::$memory::new());
                assert!(is_zero(&NEW), stringify!($memory));
            })+ };
        }
        sets::table!(check);
        check!(WaterInformed16, Sonar64);
    }
}
