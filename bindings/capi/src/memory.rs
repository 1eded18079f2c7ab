//! How a handle is made in the user's memory, and entered by a call.
//!
//! The handle holds references into the state behind it, so that neither may move; the tag has the address, and a copy is not taken for
//! the original. The state is never moved nor copied: it begins as zeros where it lies.

use crate::block::{ALIGNMENT, Block, Handle, Head, Tag};
use crate::pointer::{self, Bytes, Handed, Out};
use crate::sets::{self, Set};
use crate::{SCPHD_ABI_VERSION, scphd_status};
use core::mem::MaybeUninit;
use core::ops::{Deref, DerefMut};
use core::ptr::{addr_of, addr_of_mut};
use core::sync::atomic::{AtomicU32, Ordering};
use scphd::models::Pose;
use scphd::numerics::Vector;
use scphd::storage::MapStorage;
use scphd::{DetectorMemory, JointState, State};

/// A handle works here.
const STARTED: u32 = 0x5c9b_d001;
/// There is a state, but no handle.
const HELD: u32 = 0x5c9b_d002;

/// A state that begins as zeros.
///
/// # Safety
/// All bytes zero are a value of it: the one that its `new` makes.
pub unsafe trait Zeroed: 'static {}

// SAFETY: numbers, and an `Option` whose `None` is zero; `tests::states_begin_as_zeros` holds them to it.
unsafe impl<P: Pose + 'static, const N: usize, const C: usize, S: 'static, V: 'static> Zeroed for State<P, N, C, S, V>
where
    S: MapStorage<scphd::storage::Static<P::Position>>,
    V: MapStorage<scphd::storage::Dynamic<P::Position>>,
{
}
// SAFETY: as above.
unsafe impl<P: Pose + 'static, Z: Vector + 'static, const F: usize, const N: usize, const M: usize> Zeroed
    for JointState<P, Z, F, N, M>
{
}
// SAFETY: as above.
unsafe impl<Z: Vector + 'static, const N: usize> Zeroed for DetectorMemory<Z, N> {}

/// How a state is come by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Entry {
    /// It begins as zeros.
    Start,
    /// An earlier handle has left it.
    Resume,
}

/// The user's memory on its way to become a handle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Memory<'a> {
    pub(crate) bytes: Bytes,
    pub(crate) set: &'a Set,
    pub(crate) entry: Entry,
}

impl<'a> Memory<'a> {
    /// The caller's memory for a set of this kind.
    pub(crate) fn of<H: Handle>(bytes: Bytes, size: usize, set: u32, entry: Entry) -> Result<Self, scphd_status> {
        let set = sets::find(set).filter(|set| set.number / 100 == H::KIND).ok_or(scphd_status::UnknownSet)?;
        check_bytes(bytes)?;
        if size < set.bytes { Err(scphd_status::MemoryTooSmall) } else { Ok(Self { bytes, set, entry }) }
    }

    /// Makes a handle over the state in it.
    pub(crate) fn make<H: Handle, S: Zeroed>(
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
        // SAFETY: `of` has found the memory to be there, aligned, and as large as its set, which `sizes.rs` holds to be at least a `Block`;
        // it is the caller's word that it is initialised, and that nothing else uses it. What lies there is a tag, or bytes of which any
        // are one. Only where nothing else has one is a reference made to the state, and its bytes are a value by `Zeroed`, or because
        // the tag says that such a state was left there.
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
            // The handle that was there is no more, whatever comes of this one.
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

/// A handle while a call works on it.
#[derive(Debug)]
pub(crate) struct Entered<'h, F> {
    busy: &'h AtomicU32,
    handle: &'h mut F,
}

impl<H: Handle> Handed<H> {
    /// What is behind the pointer, and nobody else's until it is dropped.
    pub(crate) fn enter(&mut self) -> Result<Entered<'_, H::Inner>, scphd_status> {
        let head = self.0.cast::<Head<H::Inner>>();
        pointer::check(head)?;
        // SAFETY: not null and aligned; the caller's word that the memory of a set lies there, initialised, and by that no smaller than a
        // `Head`. The tag says whether there is a handle of this type; `busy`, that nothing else has a reference to it.
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

/// Hands the pointer of a new handle to the caller, whose place for it is looked at first.
pub(crate) fn hand_out<H>(
    mut to: Out<*mut H>,
    make: impl FnOnce() -> Result<*mut H, scphd_status>,
) -> Result<(), scphd_status> {
    let place = to.place()?;
    place.write(core::ptr::null_mut());
    place.write(make()?);
    Ok(())
}

/// What the memory of every set must be aligned to, bytes: `SCPHD_ALIGNMENT`.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_memory_alignment() -> usize {
    ALIGNMENT
}

/// Ends what runs in this memory, whatever it is, and if nothing does: it can be started anew. Handles to it are refused from then on.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_release(memory: Bytes, size_bytes: usize) -> scphd_status {
    if let Err(status) = check_bytes(memory) {
        return status;
    }
    if size_bytes < size_of::<Tag>() {
        return scphd_status::MemoryTooSmall;
    }
    // SAFETY: not null, aligned, large enough for a tag; and the caller's word that no call works on it.
    unsafe { memory.0.cast::<u8>().write_bytes(0, size_of::<Tag>()) };
    scphd_status::Ok
}

#[cfg(test)]
mod tests {
    use super::{Entry, Memory, scphd_release};
    use crate::pointer::{Bytes, Handed};
    use crate::sets::memories;
    use crate::{scphd_joint, scphd_status};
    use core::mem::MaybeUninit;
    use scphd::models::{ControlNoise, PlanarMotion, Step, Unicycle};
    use scphd::{JointConfig, JointSlam};

    /// The bytes of a state in a `static`, with what is between its fields.
    fn is_zero<S>(state: &MaybeUninit<S>) -> bool {
        let bytes = state.as_ptr().cast::<u8>();
        // SAFETY: the statics below are initialised by the loader, byte for byte.
        (0..size_of::<S>()).all(|at| unsafe { bytes.add(at).read_volatile() } == 0)
    }

    #[test]
    fn a_call_within_a_call_is_refused_and_one_that_did_not_end_is_known() {
        let mut memory = vec![0_u64; 20_480 / 8];
        // SAFETY: the memory is there until the end, and used by nothing else.
        let bytes = unsafe { Bytes::of(memory.as_mut_ptr().cast()) };
        let set = 201;
        let begin = |entry| {
            let memory = Memory::of::<scphd_joint>(bytes, 20_480, set, entry)?;
            let motion = PlanarMotion::Unicycle(Unicycle::new(Step::Arc, ControlNoise::NONE).unwrap());
            memory.make::<scphd_joint, memories::Joint40>(|state| {
                JointSlam::new(motion, JointConfig::default(), state).map_err(scphd_status::from)
            })
        };
        let handle = begin(Entry::Start).unwrap();
        // SAFETY: as above.
        let (mut first, mut second) = unsafe { (Handed::of(handle), Handed::of(handle)) };
        let entered = first.enter().unwrap();
        assert_eq!(second.enter().unwrap_err(), scphd_status::Busy);
        drop(entered);
        assert!(second.enter().is_ok());
        core::mem::forget(second.enter().unwrap());
        assert_eq!(begin(Entry::Resume).unwrap_err(), scphd_status::Interrupted);
        assert_eq!(scphd_release(bytes, 20_480), scphd_status::Ok);
        assert!(begin(Entry::Start).is_ok() && begin(Entry::Resume).is_ok());
    }

    #[test]
    fn states_begin_as_zeros() {
        macro_rules! check {
            ($($memory:ty),* $(,)?) => { $({
                static NEW: MaybeUninit<$memory> = MaybeUninit::new(<$memory>::new());
                assert!(is_zero(&NEW), stringify!($memory));
            })* };
        }
        check!(
            memories::Plane32x2,
            memories::PlaneInformed4,
            memories::PlaneInformed4Moving,
            memories::Joint40,
            memories::Joint100,
            memories::WaterInformed16,
            memories::RangeBearing32,
            memories::RangeBearing128,
            memories::Bearing64,
            memories::Sonar64,
        );
    }
}
