//! Layout of the user's memory: a tag, the filter or detector (the handle), and the state that it works on.
//!
//! ```text
//! | tag | handle: a filter, detector or description | state: State or DetectorMemory |
//! ```

use core::mem::MaybeUninit;
use core::sync::atomic::AtomicU32;

/// Identifies the contents of the memory.
#[derive(Debug)]
#[repr(C)]
pub(crate) struct Tag {
    pub(crate) magic: u32,
    pub(crate) set: u32,
    pub(crate) version: u32,
    /// Size of the whole block; differs between compilers with different layouts.
    pub(crate) layout: u32,
    pub(crate) address: usize,
    /// 1 while a call uses the handle.
    pub(crate) busy: AtomicU32,
}

/// The part of the block whose layout is known without the type of the state.
#[derive(Debug)]
#[repr(C, align(8))]
pub(crate) struct Head<F> {
    pub(crate) tag: Tag,
    pub(crate) handle: MaybeUninit<F>,
}

/// The whole block.
#[derive(Debug)]
#[repr(C, align(8))]
pub(crate) struct Block<F, S> {
    pub(crate) head: Head<F>,
    pub(crate) state: S,
}

/// Alignment of every memory, bytes.
pub(crate) const ALIGNMENT: usize = 8;

/// A type that C knows only by an opaque pointer.
pub trait Handle {
    /// The Rust type behind it.
    type Inner: 'static;
    /// Number of the kind: that of a set in hundreds.
    const KIND: u32;
}
