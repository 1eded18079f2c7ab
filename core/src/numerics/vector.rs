//! Vectors and matrices with dimensions as types, for generic code with nalgebra.

use super::triangle::Triangle;
use crate::{Real, Zero};
use core::ops::{Add, AddAssign, Mul, Sub};
use nalgebra::{ArrayStorage, SMatrix, SVector};

mod sealed {
    pub trait Sealed {}
}

/// A vector of nalgebra with one to six coordinates, for example `Vector2<f32>`, for generic code.
///
/// Code that is generic over a dimension is generic over the vector with that dimension: a
/// [`Symmetric`](crate::Symmetric)`<Vector2<f32>>` is the covariance of a `Vector2<f32>`.
pub trait Vector:
    sealed::Sealed + Zero + Add<Output = Self> + Sub<Output = Self> + AddAssign + Mul<Self::Scalar, Output = Self>
{
    /// Type of its coordinates.
    type Scalar: Real;
    /// An array with one element for each coordinate.
    type Array<X: Zero>: Array<X>;
    /// The lower triangle of a symmetric matrix, row after row.
    type Lower: Array<Self::Scalar> + Triangle<Self::Scalar>;
    /// A matrix that maps a `C` to this vector: one row for each coordinate of this vector, one column for each of `C`.
    type Rows<C: Vector>: Matrix<Scalar = C::Scalar>;
    /// A matrix with `R` rows of the length of this vector.
    type Stacked<const R: usize>: Matrix<Scalar = Self::Scalar>;

    /// Number of coordinates.
    const DIMENSION: usize;
    /// All coordinates +∞.
    const INFINITY: Self;
    /// All coordinates −∞.
    const NEG_INFINITY: Self;

    /// The vector with these coordinates.
    fn with(coordinate: impl FnMut(usize) -> Self::Scalar) -> Self;
    /// Coordinate `k`; zero if there is none.
    fn at(&self, k: usize) -> Self::Scalar;
    /// The coordinates.
    fn as_slice(&self) -> &[Self::Scalar];
    /// The coordinates, mutable.
    fn as_mut_slice(&mut self) -> &mut [Self::Scalar];
    /// The inner product.
    fn dot(&self, other: &Self) -> Self::Scalar;
}

/// A position vector of a feature, with one to three coordinates.
pub trait Place: Vector {
    /// A vector of the position followed by the velocity.
    type Moving: Vector<Scalar = Self::Scalar>;
}

/// A matrix of nalgebra, for generic code: a [`Linear`] map.
pub trait Matrix: sealed::Sealed + Zero + Add<Output = Self> + Mul<Self::Scalar, Output = Self> {
    /// Type of its elements.
    type Scalar: Real;

    /// The matrix with the elements `element(row, column)`.
    fn with(element: impl FnMut(usize, usize) -> Self::Scalar) -> Self;
    /// An element; zero if there is none.
    fn at(&self, row: usize, column: usize) -> Self::Scalar;
    /// The elements, column after column.
    fn as_slice(&self) -> &[Self::Scalar];
}

/// An array of fixed length.
pub trait Array<X>: sealed::Sealed + Zero + AsRef<[X]> + AsMut<[X]> {}

/// The matrix that maps a `C` to an `R`: an `SMatrix` of nalgebra with the rows of `R` and the columns of `C`. If `R` is
/// `Vector2<f32>` and `C` is `Vector3<f32>`, it is a `Matrix2x3<f32>`.
pub type Linear<R, C> = <R as Vector>::Rows<C>;

/// A times x.
#[inline]
pub(crate) fn applied<R: Vector, C: Vector<Scalar = R::Scalar>>(a: &Linear<R, C>, x: &C) -> R {
    // Starts with the first product, as nalgebra does.
    R::with(|row| (1..C::DIMENSION).fold(a.at(row, 0) * x.at(0), |sum, k| sum + a.at(row, k) * x.at(k)))
}

/// A times B.
#[inline]
pub(crate) fn product<R: Vector, C: Vector<Scalar = X::Scalar>, X: Vector>(
    a: &Linear<R, C>,
    b: &Linear<C, X>,
) -> Linear<R, X> {
    Matrix::with(|row, column| {
        (1..C::DIMENSION).fold(a.at(row, 0) * b.at(0, column), |sum, k| sum + a.at(row, k) * b.at(k, column))
    })
}

/// Aᵀ.
#[inline]
pub(crate) fn transposed<R: Vector, C: Vector<Scalar = R::Scalar>>(a: &Linear<R, C>) -> Linear<C, R> {
    Matrix::with(|row, column| a.at(column, row))
}

impl<X, const N: usize> sealed::Sealed for [X; N] {}
impl<X: Zero, const N: usize> Array<X> for [X; N] {}

impl<T, const R: usize, const C: usize> sealed::Sealed for SMatrix<T, R, C> {}
impl<T: Real, const R: usize, const C: usize> Zero for SMatrix<T, R, C> {
    const ZERO: Self = filled(T::ZERO);
}
impl<T: Real, const R: usize, const C: usize> Matrix for SMatrix<T, R, C> {
    type Scalar = T;

    #[inline]
    fn with(mut element: impl FnMut(usize, usize) -> T) -> Self {
        let mut columns = [[T::ZERO; R]; C];
        for (column, elements) in columns.iter_mut().enumerate() {
            for (row, slot) in elements.iter_mut().enumerate() {
                *slot = element(row, column);
            }
        }
        SMatrix::from_array_storage(ArrayStorage(columns))
    }

    #[inline]
    fn at(&self, row: usize, column: usize) -> T {
        self.get((row, column)).copied().unwrap_or(T::ZERO)
    }

    #[inline]
    fn as_slice(&self) -> &[T] {
        self.data.as_slice()
    }
}

const fn filled<T: Real, const R: usize, const C: usize>(with: T) -> SMatrix<T, R, C> {
    SMatrix::from_array_storage(ArrayStorage([[with; R]; C]))
}

macro_rules! implement_vector {
    ($($n:literal: $triangle:literal),*) => {$(
        impl<T: Real> Vector for SVector<T, $n> {
            type Scalar = T;
            type Array<X: Zero> = [X; $n];
            type Lower = [T; $triangle];
            type Rows<C: Vector> = C::Stacked<$n>;
            type Stacked<const R: usize> = SMatrix<T, R, $n>;

            const DIMENSION: usize = $n;
            const INFINITY: Self = filled(T::INFINITY);
            const NEG_INFINITY: Self = filled(T::NEG_INFINITY);

            #[inline]
            fn with(mut coordinate: impl FnMut(usize) -> T) -> Self {
                let mut coordinates = [T::ZERO; $n];
                for (k, slot) in coordinates.iter_mut().enumerate() {
                    *slot = coordinate(k);
                }
                SVector::from_array_storage(ArrayStorage([coordinates]))
            }

            #[inline]
            fn at(&self, k: usize) -> T {
                self.get(k).copied().unwrap_or(T::ZERO)
            }

            #[inline]
            fn as_slice(&self) -> &[T] {
                self.data.as_slice()
            }

            #[inline]
            fn as_mut_slice(&mut self) -> &mut [T] {
                self.data.as_mut_slice()
            }

            #[inline]
            fn dot(&self, other: &Self) -> T {
                SVector::dot(self, other)
            }
        }
    )*};
}
implement_vector!(1: 1, 2: 3, 3: 6, 4: 10, 5: 15, 6: 21);

impl<T: Real> Place for SVector<T, 1> {
    type Moving = SVector<T, 2>;
}
impl<T: Real> Place for SVector<T, 2> {
    type Moving = SVector<T, 4>;
}
impl<T: Real> Place for SVector<T, 3> {
    type Moving = SVector<T, 6>;
}
