//! Little-endian numbers in the payload of a message.

use heapless::Vec;

/// Number of bytes of the longest payload.
pub(crate) const PAYLOAD: usize = 255;

/// Reads a payload from its beginning. Bytes that the sender has omitted at its end are 0.
pub(crate) struct Reader<'b>(pub &'b [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        bytes.iter_mut().zip(self.0).for_each(|(slot, byte)| *slot = *byte);
        self.skip(N);
        bytes
    }

    pub fn u8(&mut self) -> u8 {
        u8::from_le_bytes(self.take())
    }

    pub fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    pub fn i32(&mut self) -> i32 {
        i32::from_le_bytes(self.take())
    }

    pub fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    pub fn i64(&mut self) -> i64 {
        i64::from_le_bytes(self.take())
    }

    pub fn skip(&mut self, bytes: usize) {
        self.0 = self.0.get(bytes..).unwrap_or(&[]);
    }

    pub fn floats<const N: usize>(&mut self) -> [f32; N] {
        [(); N].map(|()| f32::from_le_bytes(self.take()))
    }
}

/// A payload that is being written.
#[derive(Default)]
pub(crate) struct Writer(Vec<u8, PAYLOAD>);

impl Writer {
    /// The capacity is greater than the longest message.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        let _always = self.0.extend_from_slice(bytes);
        self
    }

    pub fn floats(&mut self, numbers: &[f32]) -> &mut Self {
        for number in numbers {
            self.bytes(&number.to_le_bytes());
        }
        self
    }

    /// The bytes to send: without the zeros at the end, but at least one byte.
    pub fn sent(&self) -> &[u8] {
        let zeros = self.0.iter().rev().take_while(|byte| **byte == 0).count();
        self.0.get(..(self.0.len() - zeros).max(1)).unwrap_or(&[0])
    }
}
