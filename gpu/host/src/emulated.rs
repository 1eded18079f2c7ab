//! An emulated device: runs the threads of a batch on the host one after the other, with the same functions, places and buffers.

use crate::batch::Batch;
use crate::device::{DeviceError, Kernels, Launch, Machine, Outcome};
use scphd_gpu_kernels::{Inputs, LargeMemory, Outputs, Slot, follow};
use std::time::Instant;

/// Element of the memory of all buffers, with an alignment that suffices for all of them.
type Word = u64;

/// The host in place of a device.
#[derive(Debug, Clone, Default)]
pub struct Emulated {
    buffers: Vec<Vec<Word>>,
}

/// Memory of at least `bytes` bytes, all zero, as on a device.
fn zeros(bytes: usize) -> Vec<Word> {
    vec![0; bytes.div_ceil(size_of::<Word>())]
}

impl Machine for Emulated {
    fn name(&self) -> &str {
        "emulated"
    }

    fn bytes(&mut self, kernels: &Kernels) -> Result<[u64; 7], DeviceError> {
        Ok(kernels.bytes.1)
    }

    fn clear(&mut self) {
        self.buffers.clear();
    }

    fn upload(&mut self, bytes: &[u8]) -> Result<u64, DeviceError> {
        let mut buffer = zeros(bytes.len());
        bytemuck::cast_slice_mut(&mut buffer)[..bytes.len()].copy_from_slice(bytes);
        self.buffers.push(buffer);
        Ok(self.buffers.last().map_or(0, |buffer| buffer.as_ptr() as u64))
    }

    fn zeros(&mut self, bytes: usize) -> Result<u64, DeviceError> {
        self.buffers.push(zeros(bytes));
        Ok(self.buffers.last_mut().map_or(0, |buffer| buffer.as_mut_ptr() as u64))
    }

    fn download(&mut self, address: u64, to: &mut [u8]) -> Result<(), DeviceError> {
        let buffer = self.buffers.iter().find(|buffer| buffer.as_ptr() as u64 == address);
        if let Some(from) = buffer.and_then(|buffer| bytemuck::cast_slice(buffer).get(..to.len())) {
            to.copy_from_slice(from);
        }
        Ok(())
    }

    fn launch(
        &mut self,
        launch: &Launch,
        batch: &Batch,
        (filters, scan, digest_every): (u64, u32, u32),
    ) -> Result<(), DeviceError> {
        let (threads, block) = launch.threads(batch);
        // One place more, as a grid may have.
        for place in 0..=threads / block.unwrap_or(1) {
            // SAFETY: the buffers are those of the batch, and the memory that its runs need, as zeros; they do not move. The launches
            // come in order, each with every place once.
            unsafe { launch.run(place, filters, scan, digest_every) };
        }
        Ok(())
    }
}

/// Processes the batch's first run by the library's own scan, over the state of a large filter.
pub(crate) fn alone(batch: &Batch, digest_every: u32) -> Outcome {
    let mut outcome = Outcome::untouched(batch);
    let Some(run) = batch.runs.first() else { return outcome };
    let mut memory = zeros(size_of::<Slot<LargeMemory>>());
    // SAFETY: the memory is large and aligned enough, and zeros are a valid slot, which `slot.rs` of the kernels checks.
    let slot = unsafe { &mut *memory.as_mut_ptr().cast::<Slot<LargeMemory>>() };
    let measurements: Vec<_> = batch.measurements.iter().map(|&z| z.into()).collect();
    let inputs = Inputs { run, scans: &batch.scans, predictions: &batch.predictions, measurements: &measurements };
    let Outcome { statuses, results, features, .. } = &mut outcome;
    let mut outputs = Outputs { results, features };
    let started = Instant::now();
    let status = follow(inputs, slot, &mut outputs, digest_every as usize);
    statuses.fill(status);
    outcome.launched_s = started.elapsed().as_secs_f64();
    outcome
}
