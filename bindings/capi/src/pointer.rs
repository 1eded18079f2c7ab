//! Pointers from C.
//!
//! These types stand for the requirements of the header: a pointer is null, or points to the stated number of values of its type,
//! which nothing else writes to during the call. Null and misaligned pointers are detected; the rest is the caller's
//! responsibility.

use crate::scphd_status;
use core::ffi::c_void;
use core::mem::MaybeUninit;
use nalgebra::SVector;
use scphd::MapEstimate;

/// A type made of 32-bit numbers only, for which all bit patterns are valid.
///
/// # Safety
/// `repr(C)`, without padding, and every field is a number or another such type.
pub unsafe trait Plain: Copy {}

/// A structure that begins with its own size in bytes, which distinguishes versions of the header.
pub trait Versioned: Plain {
    /// The size in this version.
    const STRUCT_SIZE: u32 = size_of::<Self>() as u32;
}

// SAFETY: all bit patterns are valid numbers.
unsafe impl Plain for f32 {}
// SAFETY: as above.
unsafe impl Plain for u8 {}

macro_rules! plain {
    ($($name:ident),* $(,)?) => { $(
        // SAFETY: `repr(C)`, and every field is a number, an array of numbers or another type of this list.
        unsafe impl Plain for crate::$name {}
    )* };
}

macro_rules! versioned {
    ($($name:ident),* $(,)?) => { $(
        plain!($name);
        impl Versioned for crate::$name {}
        // The size is the first field.
        const _: () = assert!(core::mem::offset_of!(crate::$name, struct_size) == 0 && align_of::<crate::$name>() == 4);
    )* };
}

plain!(scphd_range_bearing, scphd_sonar, scphd_feature);
versioned!(
    scphd_reason, scphd_plane_pose, scphd_odometry, scphd_water_config, scphd_water_control, scphd_water_pose,
    scphd_predict_report, scphd_scan_report, scphd_fix, scphd_fix_report, scphd_map, scphd_sonar_config,
);

/// A pointer to read from, `const T *` in C.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct In<T>(*const T);

/// A pointer to write to, `T *` in C.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Out<T>(*mut T);

/// A pointer to memory for a filter or a detector, `void *` in C.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Bytes(pub(crate) *mut c_void);

/// A pointer to a filter or a detector in its memory.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub struct Handed<H>(pub(crate) *mut H);

/// Fails if the pointer is null or misaligned.
pub(crate) fn check<T>(pointer: *const T) -> Result<(), scphd_status> {
    if pointer.is_null() {
        Err(scphd_status::NullPointer)
    } else if !pointer.is_aligned() {
        Err(scphd_status::Misaligned)
    } else {
        Ok(())
    }
}

/// Fails if memory cannot hold this number of values.
fn check_array<T>(pointer: *const T, count: usize) -> Result<(), scphd_status> {
    check(pointer)?;
    let bytes = count.checked_mul(size_of::<T>()).filter(|&bytes| bytes <= isize::MAX.unsigned_abs());
    bytes.map(|_| ()).ok_or(scphd_status::ArrayTooLong)
}

/// Fails if the structure is of another version.
fn check_size<T: Versioned>(pointer: *const T) -> Result<(), scphd_status> {
    check(pointer)?;
    // SAFETY: the caller guarantees that a structure lies there, which begins with its size.
    let size = unsafe { pointer.cast::<u32>().read() };
    if size == T::STRUCT_SIZE { Ok(()) } else { Err(scphd_status::WrongStructSize) }
}

impl<T: Plain> In<T> {
    /// An array of `count` values; if `count` is 0, any pointer is allowed.
    pub(crate) fn array(&self, count: usize) -> Result<&[T], scphd_status> {
        if count == 0 {
            return Ok(&[]);
        }
        check_array(self.0, count)?;
        // SAFETY: not null, aligned, not too long, all bit patterns valid; the caller guarantees the rest during the call, which
        // `self` does not outlive.
        Ok(unsafe { core::slice::from_raw_parts(self.0, count) })
    }
}

impl<T: Plain> In<T> {
    /// An array of measurements with `N` numbers each.
    pub(crate) fn vectors<const N: usize>(&self, count: usize) -> Result<&[SVector<f32, N>], scphd_status> {
        const { assert!(size_of::<T>() == N * size_of::<f32>() && size_of::<SVector<f32, N>>() == size_of::<T>()) };
        let measurements = self.array(count)?;
        // SAFETY: a measurement is `N` consecutive numbers, and so is a vector, which is `repr(C)` with one array; the slice is
        // valid.
        Ok(unsafe { core::slice::from_raw_parts(measurements.as_ptr().cast(), measurements.len()) })
    }
}

impl<T: Versioned> In<T> {
    /// The structure.
    pub(crate) fn get(&self) -> Result<&T, scphd_status> {
        check_size(self.0)?;
        // SAFETY: not null, aligned, all bit patterns valid; the caller guarantees the rest during the call, which `self` does
        // not outlive.
        Ok(unsafe { &*self.0 })
    }
}

impl<T: Versioned> Out<T> {
    /// The structure, mutable.
    pub(crate) fn get(&mut self) -> Result<&mut T, scphd_status> {
        check_size(self.0)?;
        // SAFETY: not null, aligned, all bit patterns valid; the caller guarantees the rest during the call, which `self` does
        // not outlive.
        Ok(unsafe { &mut *self.0 })
    }

    /// The structure, or `None` if the caller's pointer is null.
    pub(crate) fn wanted(&mut self) -> Result<Option<&mut T>, scphd_status> {
        if self.0.is_null() { Ok(None) } else { self.get().map(Some) }
    }
}

/// Writes a result, if the caller asks for it.
pub(crate) fn tell<R: From<D>, D>(to: Option<&mut R>, done: D) {
    if let Some(place) = to {
        *place = done.into();
    }
}

impl<T> Out<T> {
    /// Memory for an array of `count` values; if `count` is 0, any pointer is allowed.
    pub(crate) fn room(&mut self, count: usize) -> Result<&mut [MaybeUninit<T>], scphd_status> {
        if count == 0 {
            return Ok(&mut []);
        }
        check_array(self.0, count)?;
        // SAFETY: not null, aligned, not too long, may be uninitialised; the caller guarantees the rest during the call, which
        // `self` does not outlive.
        Ok(unsafe { core::slice::from_raw_parts_mut(self.0.cast(), count) })
    }

    /// Memory for one value.
    pub(crate) fn place(&mut self) -> Result<&mut MaybeUninit<T>, scphd_status> {
        self.room(1)?.first_mut().ok_or(scphd_status::NullPointer)
    }
}

impl<F> Out<F> {
    /// Has `write` write values of another type of the same size to the caller's array, and converts the first `features` of its
    /// result in place.
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
            // SAFETY: a `C` has the size and the alignment of the slot.
            unsafe { core::ptr::from_mut(slot).cast::<C>().write(blank) };
        }
        // SAFETY: all of the array was just written as `C`; it remains borrowed as long as the slice.
        let values = unsafe { core::slice::from_raw_parts_mut(first.cast::<C>(), count) };
        let estimate = write(values);
        for slot in room.iter_mut().take(estimate.features) {
            let slot = core::ptr::from_mut(slot);
            // SAFETY: each slot contains a `C`, which is read before an `F` is written in its place.
            unsafe { slot.cast::<F>().write(slot.cast::<C>().read().into()) };
        }
        Ok(estimate)
    }
}

impl<T> In<T> {
    /// A pointer from C.
    ///
    /// # Safety
    /// It is null, or points to as many values as it is used for, which nothing writes to during the calls that receive it.
    #[must_use]
    pub const unsafe fn of(pointer: *const T) -> Self {
        Self(pointer)
    }
}

impl<T> Out<T> {
    /// The null pointer.
    pub(crate) const NULL: Self = Self(core::ptr::null_mut());

    /// A pointer from C.
    ///
    /// # Safety
    /// It is null, or points to memory for as many values as it is used for, which nothing else uses during the calls that
    /// receive it.
    #[must_use]
    pub const unsafe fn of(pointer: *mut T) -> Self {
        Self(pointer)
    }
}

impl Bytes {
    /// A pointer from C.
    ///
    /// # Safety
    /// It is null, or points to as many bytes as are stated with it, which nothing else uses while they contain a filter or a
    /// detector.
    #[must_use]
    pub const unsafe fn of(pointer: *mut c_void) -> Self {
        Self(pointer)
    }
}

impl<H> Handed<H> {
    /// A pointer from C.
    ///
    /// # Safety
    /// It is null, or points to memory of the size of a set, which nothing else uses while it contains a filter or a detector.
    #[must_use]
    pub const unsafe fn of(pointer: *mut H) -> Self {
        Self(pointer)
    }
}
