//! The numbers in a `PointCloud2`.

use crate::messages::{Header, PointCloud2, PointField};

/// Types of numbers, with the values of `PointField`.
const FLOAT32: u8 = 7;
const FLOAT64: u8 = 8;

/// Why a cloud cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CloudError {
    /// Rows or points need more bytes than there are.
    #[error("{height} rows of {width} points of {point_step} bytes do not fit {bytes} bytes with rows of {row_step}")]
    Size {
        height: u32,
        /// Number of points in a row.
        width: u32,
        point_step: u32,
        row_step: u32,
        /// Size of the data, bytes.
        bytes: usize,
    },
    #[error("field '{0}' lies beyond its point")]
    Beyond(String),
    #[error("field '{0}' is of the unknown type {1}")]
    Type(String, u8),
}

/// A cloud of points with S numbers in single precision, which most viewers need for x, y and z, and D numbers in double
/// precision.
pub fn cloud<const S: usize, const D: usize>(
    header: Header,
    single: [&str; S],
    double: [&str; D],
    points: impl IntoIterator<Item = ([f64; S], [f64; D])>,
) -> PointCloud2 {
    // There are few fields; doubles are aligned to their size.
    let begin = (4 * S).next_multiple_of(8);
    let step = begin + 8 * D;
    let field = |name: &str, offset: usize, datatype| PointField {
        name: name.to_owned(),
        offset: offset as u32,
        datatype,
        count: 1,
    };
    let fields = (single.iter().enumerate().map(|(k, name)| field(name, 4 * k, FLOAT32)))
        .chain(double.iter().enumerate().map(|(k, name)| field(name, begin + 8 * k, FLOAT64)));
    let fields = fields.collect();
    let mut data = Vec::new();
    for (single, double) in points {
        let start = data.len();
        single.iter().for_each(|number| data.extend((*number as f32).to_le_bytes()));
        data.resize(start + begin, 0);
        double.iter().for_each(|number| data.extend(number.to_le_bytes()));
    }
    let width = data.len() / step.max(1);
    PointCloud2 {
        header,
        height: 1,
        width: width as u32,
        fields,
        is_bigendian: false,
        point_step: step as u32,
        row_step: data.len() as u32,
        data,
        is_dense: true,
    }
}

/// A cloud with valid sizes.
#[derive(Debug)]
pub struct Cloud<'c>(&'c PointCloud2);

/// Position of a number in a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    offset: usize,
    datatype: u8,
}

impl<'c> Cloud<'c> {
    /// Checks the sizes of a cloud.
    pub fn of(cloud: &'c PointCloud2) -> Result<Self, CloudError> {
        let PointCloud2 { height, width, point_step, row_step, .. } = *cloud;
        let bytes = cloud.data.len();
        let points = u64::from(height) * u64::from(width);
        let row = u64::from(width) * u64::from(point_step);
        // The last row may have no padding.
        let all = u64::from(row_step) * u64::from(height.saturating_sub(1)) + row;
        let fits = point_step > 0 && (height <= 1 || row <= u64::from(row_step)) && all <= bytes as u64;
        if points > 0 && !fits {
            return Err(CloudError::Size { height, width, point_step, row_step, bytes });
        }
        Ok(Self(cloud))
    }

    pub fn points(&self) -> usize {
        // The product is at most the number of bytes of the data.
        self.0.height as usize * self.0.width as usize
    }

    /// The field with this name, if the points have it.
    pub fn column(&self, name: &str) -> Result<Option<Column>, CloudError> {
        let Some(field) = self.0.fields.iter().find(|field| field.name == name) else { return Ok(None) };
        let size = match field.datatype {
            1 | 2 => 1,
            3 | 4 => 2,
            5..=FLOAT32 => 4,
            FLOAT64 => 8,
            other => return Err(CloudError::Type(name.to_owned(), other)),
        };
        if u64::from(field.offset) + size > u64::from(self.0.point_step) {
            return Err(CloudError::Beyond(name.to_owned()));
        }
        Ok(Some(Column { offset: field.offset as usize, datatype: field.datatype }))
    }

    /// A number of a point; NaN beyond the last one.
    pub fn number(&self, point: usize, column: Column) -> f64 {
        let width = (self.0.width as usize).max(1);
        let (row, place) = (point / width, point % width);
        let at = row * self.0.row_step as usize + place * self.0.point_step as usize + column.offset;
        let big = self.0.is_bigendian;
        let bytes = self.0.data.get(at..).unwrap_or_default();
        macro_rules! read {
            ($type:ty) => {
                bytes.first_chunk().map_or(f64::NAN, |bytes| {
                    f64::from(if big { <$type>::from_be_bytes(*bytes) } else { <$type>::from_le_bytes(*bytes) })
                })
            };
        }
        match column.datatype {
            1 => read!(i8),
            2 => read!(u8),
            3 => read!(i16),
            4 => read!(u16),
            5 => read!(i32),
            6 => read!(u32),
            FLOAT32 => read!(f32),
            _ => read!(f64),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_restored() {
        let made = cloud(Header::default(), ["x", "y", "z"], ["range"], [([1.0, 2.0, 3.0], [0.1]), ([4.0; 3], [0.2])]);
        let read = Cloud::of(&made).unwrap();
        assert_eq!((read.points(), made.point_step, made.data.len()), (2, 24, 48));
        let at = |name: &str, point| read.number(point, read.column(name).unwrap().unwrap());
        assert_eq!([at("y", 0), at("range", 0), at("z", 1), at("range", 1)], [2.0, 0.1, 4.0, 0.2]);
        assert!(read.number(2, read.column("x").unwrap().unwrap()).is_nan());
        assert_eq!(read.column("bearing"), Ok(None));
    }

    #[test]
    fn rows_with_padding_and_the_other_byte_order_are_read() {
        let field = PointField { name: "i".into(), offset: 1, datatype: 3, count: 1 };
        let made = PointCloud2 {
            height: 2,
            width: 1,
            fields: vec![field],
            is_bigendian: true,
            point_step: 3,
            row_step: 4,
            data: vec![9, 1, 2, 9, 9, 0xff, 0xfe],
            ..PointCloud2::default()
        };
        let read = Cloud::of(&made).unwrap();
        let column = read.column("i").unwrap().unwrap();
        assert_eq!([read.number(0, column), read.number(1, column)], [258.0, -2.0]);
    }

    #[test]
    fn sizes_that_do_not_fit_are_errors() {
        let good = cloud(Header::default(), ["x"], [], [([1.0], [])]);
        let wrong = [
            PointCloud2 { width: u32::MAX, height: u32::MAX, ..good.clone() },
            PointCloud2 { width: u32::MAX, height: u32::MAX, point_step: 0, row_step: 0, ..good.clone() },
            PointCloud2 { data: vec![0; 3], ..good.clone() },
            PointCloud2 { height: 2, row_step: 0, ..good.clone() },
        ];
        for cloud in &wrong {
            assert!(matches!(Cloud::of(cloud), Err(CloudError::Size { .. })), "{cloud:?}");
        }
        let field = |offset, datatype| PointField { name: "x".into(), offset, datatype, count: 1 };
        for (field, error) in [
            (field(1, FLOAT64), CloudError::Beyond("x".into())),
            (field(u32::MAX, 1), CloudError::Beyond("x".into())),
            (field(0, 9), CloudError::Type("x".into(), 9)),
        ] {
            let made = PointCloud2 { fields: vec![field], ..good.clone() };
            assert_eq!(Cloud::of(&made).unwrap().column("x"), Err(error));
        }
    }
}
