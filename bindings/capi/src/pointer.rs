//! Pointers that C gives.
//!
//! What the header asks of a pointer is what these types stand for: it is null, or it points to as many values of its type as are named,
//! which nothing else writes to during the call. Null and misaligned ones are found out; the rest is the caller's word.

use crate::scphd_status;
use core::ffi::c_void;
use core::mem::MaybeUninit;
use nalgebra::SVector;
use scphd::MapEstimate;

/// A type of which any bits are a value, made of 32-bit numbers alone.
///
/// # Safety
/// `repr(C)`, without padding, and every field a number or another such type.
pub unsafe trait Plain: Copy {}

/// A structure that begins with its own size in bytes, by which headers of different versions are told apart.
pub trait Versioned: Plain {
    /// The size that this library knows.
    const STRUCT_SIZE: u32 = size_of::<Self>() as u32;
}

// SAFETY: any bits are a number.
unsafe impl Plain for f32 {}
// SAFETY: as above.
unsafe impl Plain for u8 {}

macro_rules! plain {
    ($($name:ident),* $(,)?) => { $(
        // SAFETY: `repr(C)`, and every field a number, an array of such or another one of these.
        unsafe impl Plain for crate::$name {}
    )* };
}

macro_rules! versioned {
    ($($name:ident),* $(,)?) => { $(
        plain!($name);
        impl Versioned for crate::$name {}
        // Its size comes first.
        const _: () = assert!(core::mem::offset_of!(crate::$name, struct_size) == 0 && align_of::<crate::$name>() == 4);
    )* };
}

plain!(scphd_range_bearing, scphd_sonar, scphd_feature);
versioned!(
    scphd_reason,
    scphd_plane_pose,
    scphd_odometry,
    scphd_water_config,
    scphd_water_control,
    scphd_water_pose,
    scphd_predict_report,
    scphd_scan_report,
    scphd_fix,
    scphd_fix_report,
    scphd_map,
    scphd_sonar_config,
);

/// A pointer that is read from, by C's `const T *`.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct In<T>(*const T);

/// A pointer that is written to, by C's `T *`.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Out<T>(*mut T);

/// A pointer to memory for a filter or a detector, by C's `void *`.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Bytes(pub(crate) *mut c_void);

/// A pointer to a filter or a detector in its memory.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Handed<H>(pub(crate) *mut H);

/// Fails where nothing can lie there.
pub(crate) fn check<T>(pointer: *const T) -> Result<(), scphd_status> {
    if pointer.is_null() {
        Err(scphd_status::NullPointer)
    } else if !pointer.is_aligned() {
        Err(scphd_status::Misaligned)
    } else {
        Ok(())
    }
}

/// Fails where memory cannot hold so many.
fn check_array<T>(pointer: *const T, count: usize) -> Result<(), scphd_status> {
    check(pointer)?;
    let bytes = count.checked_mul(size_of::<T>()).filter(|&bytes| bytes <= isize::MAX.unsigned_abs());
    bytes.map(|_| ()).ok_or(scphd_status::ArrayTooLong)
}

/// Fails where the structure is not of this version.
fn check_size<T: Versioned>(pointer: *const T) -> Result<(), scphd_status> {
    check(pointer)?;
    // SAFETY: the caller's word: a structure lies there, and begins with its size.
    let size = unsafe { pointer.cast::<u32>().read() };
    if size == T::STRUCT_SIZE { Ok(()) } else { Err(scphd_status::WrongStructSize) }
}

impl<T: Plain> In<T> {
    /// An array of so many; where there are none, the pointer may be any.
    pub(crate) fn array(&self, count: usize) -> Result<&[T], scphd_status> {
        if count == 0 {
            return Ok(&[]);
        }
        check_array(self.0, count)?;
        // SAFETY: not null, aligned, not too long, any bits are a value; and the caller's word for as long as `self` lives, the call.
        Ok(unsafe { core::slice::from_raw_parts(self.0, count) })
    }
}

impl<T: Plain> In<T> {
    /// An array of measurements of `N` numbers each.
    pub(crate) fn vectors<const N: usize>(&self, count: usize) -> Result<&[SVector<f32, N>], scphd_status> {
        const { assert!(size_of::<T>() == N * size_of::<f32>() && size_of::<SVector<f32, N>>() == size_of::<T>()) };
        let measurements = self.array(count)?;
        // SAFETY: a measurement is `N` numbers in a row, and a vector, `repr(C)` over one array, is the same; the slice is one already.
        Ok(unsafe { core::slice::from_raw_parts(measurements.as_ptr().cast(), measurements.len()) })
    }
}

impl<T: Versioned> In<T> {
    /// The structure.
    pub(crate) fn get(&self) -> Result<&T, scphd_status> {
        check_size(self.0)?;
        // SAFETY: not null, aligned, any bits are a value; and the caller's word for as long as `self` lives, the call.
        Ok(unsafe { &*self.0 })
    }
}

impl<T: Versioned> Out<T> {
    /// The structure, to be changed.
    pub(crate) fn get(&mut self) -> Result<&mut T, scphd_status> {
        check_size(self.0)?;
        // SAFETY: not null, aligned, any bits are a value; and the caller's word for as long as `self` lives, the call.
        Ok(unsafe { &mut *self.0 })
    }

    /// The structure, or `None` where the caller wants none of it.
    pub(crate) fn wanted(&mut self) -> Result<Option<&mut T>, scphd_status> {
        if self.0.is_null() { Ok(None) } else { self.get().map(Some) }
    }
}

/// Puts what was done to where the caller wants it.
pub(crate) fn tell<R: From<D>, D>(to: Option<&mut R>, done: D) {
    if let Some(place) = to {
        *place = done.into();
    }
}

impl<T> Out<T> {
    /// Room for an array of so many; where there is none, the pointer may be any.
    pub(crate) fn room(&mut self, count: usize) -> Result<&mut [MaybeUninit<T>], scphd_status> {
        if count == 0 {
            return Ok(&mut []);
        }
        check_array(self.0, count)?;
        // SAFETY: not null, aligned, not too long, asked for no value; and the caller's word for as long as `self` lives, the call.
        Ok(unsafe { core::slice::from_raw_parts_mut(self.0.cast(), count) })
    }

    /// The place of one value.
    pub(crate) fn place(&mut self) -> Result<&mut MaybeUninit<T>, scphd_status> {
        self.room(1)?.first_mut().ok_or(scphd_status::NullPointer)
    }
}

impl<F> Out<F> {
    /// Has an array of values of another type, as large, written to the caller's array, and puts each as its own type in its place: the
    /// first `features` of what `write` says.
    pub(crate) fn written_as<C: Copy>(
        &mut self,
        count: usize,
        blank: C,
        write: impl FnOnce(&mut [C]) -> MapEstimate<f32>,
    ) -> Result<MapEstimate<f32>, scphd_status>
    where
        F: From<C>,
    {
        const { assert!(size_of::<F>() == size_of::<C>() && align_of::<F>() == align_of::<C>()) };
        let room = self.room(count)?;
        let first = room.as_mut_ptr();
        for slot in room.iter_mut() {
            // SAFETY: a `C` is as large and as aligned as the slot.
            unsafe { core::ptr::from_mut(slot).cast::<C>().write(blank) };
        }
        // SAFETY: all of the room was written as `C` just now, and is borrowed for as long.
        let values = unsafe { core::slice::from_raw_parts_mut(first.cast::<C>(), count) };
        let estimate = write(values);
        for slot in room.iter_mut().take(estimate.features) {
            let slot = core::ptr::from_mut(slot);
            // SAFETY: each slot holds a `C`, which is read before an `F` takes its place.
            unsafe { slot.cast::<F>().write(slot.cast::<C>().read().into()) };
        }
        Ok(estimate)
    }
}

impl<T> In<T> {
    /// A pointer from C.
    ///
    /// # Safety
    /// It is null, or points to as many values as it will be used for, which nothing writes to during the calls it is given to.
    #[must_use]
    pub const unsafe fn of(pointer: *const T) -> Self {
        Self(pointer)
    }
}

impl<T> Out<T> {
    /// Nowhere.
    pub(crate) const NULL: Self = Self(core::ptr::null_mut());

    /// A pointer from C.
    ///
    /// # Safety
    /// It is null, or points to room for as many values as it will be used for, which nothing else uses during the calls it is given to.
    #[must_use]
    pub const unsafe fn of(pointer: *mut T) -> Self {
        Self(pointer)
    }
}

impl Bytes {
    /// A pointer from C.
    ///
    /// # Safety
    /// It is null, or points to as many bytes as are named with it, which nothing else uses for as long as a filter or a detector is in them.
    #[must_use]
    pub const unsafe fn of(pointer: *mut c_void) -> Self {
        Self(pointer)
    }
}

impl<H> Handed<H> {
    /// A pointer from C.
    ///
    /// # Safety
    /// It is null, or points to memory of the size of a set, which nothing else uses for as long as a filter or a detector is in it.
    #[must_use]
    pub const unsafe fn of(pointer: *mut H) -> Self {
        Self(pointer)
    }
}
