//! Line numbers of the records of a text.

/// Line numbers of records, asked for in order: a reader's own leave out ends of lines that it has not come by yet where a record starts
/// (the second half of those of Windows, blank lines), and comments.
#[derive(Debug)]
pub struct Lines<'a> {
    bytes: &'a [u8],
    /// What a line of comment begins with.
    comment: Option<u8>,
    at: usize,
    line: u64,
}

impl<'a> Lines<'a> {
    pub fn of(text: &'a str, comment: Option<u8>) -> Self {
        Self { bytes: text.as_bytes(), comment, at: 0, line: 1 }
    }

    /// The line of the record that is found from this byte on.
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
