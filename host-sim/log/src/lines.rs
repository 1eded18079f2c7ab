//! Line numbers of the records of a text.

/// Line numbers of records, requested in order. Those of a reader do not include line ends before a record that it has not yet
/// read (the second half of Windows line ends, blank lines), nor comments.
#[derive(Debug)]
pub struct Lines<'a> {
    bytes: &'a [u8],
    /// First byte of a comment line.
    comment: Option<u8>,
    at: usize,
    line: u64,
}

impl<'a> Lines<'a> {
    pub fn of(text: &'a str, comment: Option<u8>) -> Self {
        Self { bytes: text.as_bytes(), comment, at: 0, line: 1 }
    }

    /// The line of the record after this byte.
    pub fn at(&mut self, byte: u64) -> u64 {
        let mut start = byte as usize;
        while let Some(&next) = self.bytes.get(start) {
            match next {
                b'\r' | b'\n' => start += 1,
                _ if self.comment == Some(next) => {
                    start += self.bytes[start..].iter().take_while(|byte| **byte != b'\n').count();
                }
                _ => break,
            }
        }
        let passed = self.bytes.get(self.at..start).unwrap_or_default();
        self.line += passed.iter().filter(|byte| **byte == b'\n').count() as u64;
        self.at = start;
        self.line
    }
}
