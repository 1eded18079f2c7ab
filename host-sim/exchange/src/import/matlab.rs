//! Matrices of MAT-files: level 4, and level 5, compressed or not (MathWorks, *MAT-File Format*). Little-endian, real numbers
//! only.

use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;
use std::collections::BTreeMap;

/// Greatest size of a decompressed matrix, bytes.
const LIMIT: usize = 1 << 30;
/// Types of data elements of level 5.
const MATRIX: u32 = 14;
const PACKED: u32 = 15;

/// A matrix, by columns.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Matrix {
    pub(super) rows: usize,
    pub(super) numbers: Vec<f64>,
}

/// Bytes that are read from the front.
struct Bytes<'b>(&'b [u8]);

impl<'b> Bytes<'b> {
    fn take(&mut self, count: usize) -> Result<&'b [u8], String> {
        let (head, rest) = self.0.split_at_checked(count).ok_or("it ends in the middle of a matrix")?;
        self.0 = rest;
        Ok(head)
    }

    fn word(&mut self) -> Result<u32, String> {
        let bytes = self.take(4)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    /// The type and the bytes of a data element; skips the padding behind it.
    fn element(&mut self) -> Result<(u32, &'b [u8]), String> {
        let first = self.word()?;
        if first >> 16 != 0 {
            // A small element has its data in the word of the length.
            let bytes = self.take(4)?;
            let small = bytes.get(..(first >> 16) as usize).ok_or("a small element is too long")?;
            return Ok((first & 0xffff, small));
        }
        let length = self.word()? as usize;
        let bytes = self.take(length)?;
        if first != PACKED {
            // The last element may have no padding.
            let padding = (length.next_multiple_of(8) - length).min(self.0.len());
            self.take(padding)?;
        }
        Ok((first, bytes))
    }
}

/// The matrices in a file, by name.
pub(super) fn matrices(file: &[u8]) -> Result<BTreeMap<String, Matrix>, String> {
    let mut all = BTreeMap::new();
    // Level 5 begins with a text.
    if file.len() < 4 || file[..4].contains(&0) {
        let mut bytes = Bytes(file);
        while !bytes.0.is_empty() {
            let (name, matrix) = of_level_4(&mut bytes)?;
            all.insert(name, matrix);
        }
        return Ok(all);
    }
    let mut bytes = Bytes(file);
    let head = bytes.take(128)?;
    if !head.ends_with(b"IM") {
        return Err("no MAT-file of level 4 or 5, little-endian".into());
    }
    while !bytes.0.is_empty() {
        match bytes.element()? {
            (PACKED, packed) => {
                let inside = decompress_to_vec_zlib_with_limit(packed, LIMIT)
                    .map_err(|error| format!("a packed matrix: {error}"))?;
                let (kind, body) = Bytes(&inside).element()?;
                if kind == MATRIX {
                    all.extend(of_level_5(body)?);
                }
            }
            (MATRIX, body) => all.extend(of_level_5(body)?),
            _ => {}
        }
    }
    Ok(all)
}

fn of_level_4(bytes: &mut Bytes<'_>) -> Result<(String, Matrix), String> {
    let (kind, rows, columns) = (bytes.word()?, bytes.word()? as usize, bytes.word()? as usize);
    let (imaginary, name) = (bytes.word()?, bytes.word()? as usize);
    let (kind, size) = match kind {
        0 => (9, 8),
        10 => (7, 4),
        20 => (5, 4),
        30 => (3, 2),
        40 => (4, 2),
        50 => (2, 1),
        other => return Err(format!("a matrix of the unknown type {other}")),
    };
    let name = text(bytes.take(name)?);
    let count = rows.checked_mul(columns).and_then(|count| count.checked_mul(size)).ok_or("a matrix is too large")?;
    let real = bytes.take(count)?;
    if imaginary != 0 {
        bytes.take(count)?;
    }
    Ok((name, Matrix { rows, numbers: numbers(kind, real)? }))
}

/// `None` for an element that is not a numeric matrix.
fn of_level_5(body: &[u8]) -> Result<Option<(String, Matrix)>, String> {
    let mut bytes = Bytes(body);
    let (_, flags) = bytes.element()?;
    // Classes 6 to 13 are numeric matrices.
    if !flags.first().is_some_and(|class| (6..=13).contains(class)) {
        return Ok(None);
    }
    let (_, dimensions) = bytes.element()?;
    let rows = dimensions.first_chunk().map_or(0, |rows| u32::from_le_bytes(*rows)) as usize;
    let name = text(bytes.element()?.1);
    let (kind, real) = bytes.element()?;
    Ok(Some((name, Matrix { rows, numbers: numbers(kind, real)? })))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim_end_matches('\0').to_owned()
}

/// Numbers of a data type of level 5.
fn numbers(kind: u32, bytes: &[u8]) -> Result<Vec<f64>, String> {
    macro_rules! read {
        ($type:ty) => {
            bytes
                .chunks_exact(size_of::<$type>())
                .filter_map(|number| number.try_into().ok())
                .map(<$type>::from_le_bytes)
        };
    }
    Ok(match kind {
        1 => read!(i8).map(f64::from).collect(),
        2 => read!(u8).map(f64::from).collect(),
        3 => read!(i16).map(f64::from).collect(),
        4 => read!(u16).map(f64::from).collect(),
        5 => read!(i32).map(f64::from).collect(),
        6 => read!(u32).map(f64::from).collect(),
        7 => read!(f32).map(f64::from).collect(),
        9 => read!(f64).collect(),
        other => return Err(format!("numbers of the unknown type {other}")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(kind: u32, bytes: &[u8]) -> Vec<u8> {
        let mut all = [&kind.to_le_bytes()[..], &(bytes.len() as u32).to_le_bytes(), bytes].concat();
        if kind != PACKED {
            all.resize(all.len().next_multiple_of(8), 0);
        }
        all
    }

    fn words(words: &[u32]) -> Vec<u8> {
        words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    /// A matrix whose name is a small element and whose numbers have two bytes.
    fn matrix() -> Vec<u8> {
        let body = [
            element(6, &words(&[11, 0])),
            element(5, &words(&[2, 3])),
            [&words(&[3 << 16 | 1])[..], b"abc\0"].concat(),
            element(4, &[1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 1]),
        ];
        element(MATRIX, &body.concat())
    }

    fn head() -> Vec<u8> {
        let mut head = b"MATLAB 5.0 MAT-file".to_vec();
        head.resize(124, b' ');
        [&head[..], &[0, 1], b"IM"].concat()
    }

    #[test]
    fn all_levels_are_read_and_damage_is_an_error() {
        let expected = Matrix { rows: 2, numbers: vec![1.0, 2.0, 3.0, 4.0, 5.0, 262.0] };
        let plain = [head(), matrix()].concat();
        let packed = miniz_oxide::deflate::compress_to_vec_zlib(&matrix(), 6);
        let packed = [head(), element(PACKED, &packed)].concat();
        let numbers: Vec<u8> = expected.numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let old = [&words(&[0, 2, 3, 0, 4])[..], b"abc\0", &numbers].concat();
        for (k, file) in [plain, packed, old].into_iter().enumerate() {
            assert_eq!(matrices(&file).unwrap().get("abc"), Some(&expected), "{k}");
            for length in 129..file.len() {
                // Only the padding may be missing.
                assert!(matrices(&file[..length]).is_err() || length + 8 > file.len(), "{k}: {length}");
            }
            for place in 0..file.len() {
                let mut other = file.clone();
                other[place] ^= 0xff;
                let _ = matrices(&other);
            }
        }
    }
}
