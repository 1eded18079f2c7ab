//! What lies in the user's memory: a tag that says what, the filter or detector itself, and behind it the state that this works on.
//!
//! ```text
//! | tag | handle: a filter, detector or description | state: State or DetectorMemory |
//! ```

use core::mem::MaybeUninit;
use core::sync::atomic::AtomicU32;

/// What lies in the memory.
#[derive(Debug)]
#[repr(C)]
pub(crate) struct Tag {
    pub(crate) magic: u32,
    pub(crate) set: u32,
    pub(crate) version: u32,
    /// The size of all, by which one compiler's layout is told from another's.
    pub(crate) layout: u32,
    pub(crate) address: usize,
    /// 1 while a call works on it.
    pub(crate) busy: AtomicU32,
}

/// What a function needs to know of the memory it is given.
#[derive(Debug)]
#[repr(C, align(8))]
pub(crate) struct Head<F> {
    pub(crate) tag: Tag,
    pub(crate) handle: MaybeUninit<F>,
}

/// All of the memory.
#[derive(Debug)]
#[repr(C, align(8))]
pub(crate) struct Block<F, S> {
    pub(crate) head: Head<F>,
    pub(crate) state: S,
}

/// What every memory is aligned to, bytes.
pub(crate) const ALIGNMENT: usize = 8;

/// What C knows by an opaque pointer.
pub trait Handle {
    /// What is behind it.
    type Inner: 'static;
    /// What kind it is: the number of a set, in hundreds.
    const KIND: u32;
}
