//! The lower triangle of a symmetric matrix in packed storage, row after row, for one to six rows.
//!
//! What depends on every element is written out for each size. The compiler would not unroll the two nested loops, and what is
//! written out for six rows alone is compiled for six rows in every matrix.

use crate::Real;

/// Position of element (`row`, `column`), `row` ≥ `column`.
pub(crate) const fn at(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// The element at a position, which the caller keeps inside the numbers: the compiler cannot always see that.
#[inline]
pub(crate) fn element<T: Real>(numbers: &[T], place: usize) -> T {
    numbers.get(place).copied().unwrap_or(T::ZERO)
}

/// A lower triangle.
pub trait Triangle<T>: Sized {
    /// The triangle with the elements `element(row, column)`, which is called row by row, with `row` ≥ `column`.
    fn with(element: impl FnMut(usize, usize) -> T) -> Self;

    /// Replaces S = L diag(d) Lᵀ by the elements of L below its diagonal of ones, and sets the pivots d; `false` if a pivot is not
    /// positive.
    fn factor(&mut self, pivots: &mut [T]) -> bool;
}

/// Computes the pivot of a column and the elements below it, from the columns before; `false` if the pivot is not positive.
#[inline(always)]
fn eliminate<T: Real, const COLUMN: usize, const ROWS: usize>(l: &mut [T], pivots: &mut [T]) -> bool {
    let mut pivot = element(l, at(COLUMN, COLUMN));
    let mut scaled = [T::ZERO; COLUMN];
    for (k, (scaled, &earlier)) in scaled.iter_mut().zip(pivots.iter()).enumerate() {
        *scaled = element(l, at(COLUMN, k)) * earlier;
        pivot -= element(l, at(COLUMN, k)) * *scaled;
    }
    // Below the least normal number the reciprocal would overflow.
    if !pivot.is_normal_positive() {
        return false;
    }
    if let Some(slot) = pivots.get_mut(COLUMN) {
        *slot = pivot;
    }
    let per_pivot = T::ONE / pivot;
    for row in COLUMN + 1..ROWS {
        let start = element(l, at(row, COLUMN));
        let product = (0..COLUMN).zip(scaled).fold(start, |sum, (k, scaled)| sum - element(l, at(row, k)) * scaled);
        if let Some(slot) = l.get_mut(at(row, COLUMN)) {
            *slot = product * per_pivot;
        }
    }
    true
}

macro_rules! implement_triangle {
    ($($rows:literal, $len:literal, [$($column:literal)*]: $(($row:literal $of:literal))*;)*) => {$(
        impl<T: Real> Triangle<T> for [T; $len] {
            #[inline]
            fn with(mut element: impl FnMut(usize, usize) -> T) -> Self {
                [$(element($row, $of)),*]
            }

            #[inline]
            fn factor(&mut self, pivots: &mut [T]) -> bool {
                $(eliminate::<T, $column, $rows>(self, pivots))&&*
            }
        }
    )*};
}
implement_triangle! {
    1, 1, [0]: (0 0);
    2, 3, [0 1]: (0 0) (1 0) (1 1);
    3, 6, [0 1 2]: (0 0) (1 0) (1 1) (2 0) (2 1) (2 2);
    4, 10, [0 1 2 3]: (0 0) (1 0) (1 1) (2 0) (2 1) (2 2) (3 0) (3 1) (3 2) (3 3);
    5, 15, [0 1 2 3 4]: (0 0) (1 0) (1 1) (2 0) (2 1) (2 2) (3 0) (3 1) (3 2) (3 3) (4 0) (4 1) (4 2) (4 3) (4 4);
    6, 21, [0 1 2 3 4 5]: (0 0) (1 0) (1 1) (2 0) (2 1) (2 2) (3 0) (3 1) (3 2) (3 3) (4 0) (4 1) (4 2) (4 3) (4 4)
        (5 0) (5 1) (5 2) (5 3) (5 4) (5 5);
}
