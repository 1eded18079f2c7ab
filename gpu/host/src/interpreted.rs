//! A device that interprets the module on the host, instruction by instruction, with `scphd-ptx`.

use crate::batch::Batch;
use crate::cuda::{Modules, bytes_of_buffers};
use crate::device::{Device, DeviceError, Launch, Outcome, buffers, of_scan};
use bytemuck::Pod;
use scphd_gpu_kernels::{LargeMemory, Memory};
use scphd_ptx::{AccessError, Counts, Grid, LaunchError, Module};
use std::fmt::Write as _;
use std::time::Instant;

/// Number of runs at a time. The host needs no other limit than the memory for them.
const RESIDENT: usize = 64;

/// How the module is executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Execution {
    /// Threads of a block.
    pub block: u32,
    /// Threads of a warp.
    pub warp: u32,
    /// Whether it is an error if two threads of a launch use the same byte and one of them writes it.
    pub watch: bool,
}

/// The module, and the counts of its launches.
#[derive(Debug, Clone)]
pub struct Interpreted {
    module: Module,
    /// Memory that contains only the variables of the module.
    fresh: scphd_ptx::Memory,
    execution: Execution,
    /// Bytes of one element of each buffer, for many filters and for a large one: room, sight, desk, draft, stream, part.
    sizes: [[usize; 6]; 2],
    name: String,
    /// The counts of every kernel, over all launches of the last run.
    taken: Vec<(String, Counts)>,
}

impl Interpreted {
    /// Reads the module.
    ///
    /// # Errors
    /// There is no module, or it contains something unknown.
    pub fn open(modules: &Modules, execution: Execution) -> Result<Self, DeviceError> {
        let (text, path) = modules.text()?;
        let mut fresh = scphd_ptx::Memory::new();
        if execution.watch {
            fresh.watch();
        }
        let module = Module::read(&text, &mut fresh);
        let module = module.map_err(|error| DeviceError::Module { path: path.clone(), why: error.to_string() })?;
        let Execution { block, warp, .. } = execution;
        let name = format!("interpreted, {}, {block} threads a block, {warp} a warp", path.display());
        let mut new = Self { module, fresh, execution, sizes: [[0; 6]; 2], name, taken: Vec::new() };
        new.sizes = [new.told_bytes(&Launch::bytes::<Memory>())?, new.told_bytes(&Launch::bytes::<LargeMemory>())?];
        Ok(new)
    }

    /// Bytes of one element of each buffer, which the kernel writes.
    fn told_bytes(&self, kernel: &str) -> Result<[usize; 6], DeviceError> {
        let mut memory = self.fresh.clone();
        let said = memory.allocate_zeros(8 * 7);
        self.module.launch(kernel, Grid { blocks: 1, block: 1, warp: 1 }, &[said], &mut memory).map_err(stopped)?;
        let bytes = memory.bytes(said).map_err(no_buffer)?;
        let numbers: Vec<u64> = bytemuck::pod_collect_to_vec(bytes);
        bytes_of_buffers(&numbers)
    }

    /// Launches a kernel, and adds its counts.
    fn launch(
        &mut self,
        launch: &Launch,
        batch: &Batch,
        arguments: &[u64],
        memory: &mut scphd_ptx::Memory,
    ) -> Result<(), DeviceError> {
        let Execution { block, warp, .. } = self.execution;
        let threads = launch.threads(batch);
        let block = if threads == 1 { 1 } else { block };
        let grid = Grid { blocks: (threads as u32).div_ceil(block).max(1), block, warp };
        let counts = self.module.launch(&launch.kernel, grid, arguments, memory).map_err(stopped)?;
        match self.taken.iter_mut().find(|(known, _)| *known == launch.kernel) {
            Some((_, of_kernel)) => *of_kernel = of_kernel.and(counts),
            None => self.taken.push((launch.kernel.clone(), counts)),
        }
        Ok(())
    }
}

fn stopped(error: LaunchError) -> DeviceError {
    DeviceError::Driver { doing: "executing the module", why: error.to_string() }
}

fn no_buffer(error: AccessError) -> DeviceError {
    DeviceError::Driver { doing: "looking at a buffer", why: error.to_string() }
}

fn upload<T: Pod>(memory: &mut scphd_ptx::Memory, things: &[T]) -> u64 {
    memory.allocate(bytemuck::cast_slice(things))
}

fn download<T: Pod>(memory: &scphd_ptx::Memory, from: u64, to: &mut [T]) -> Result<(), DeviceError> {
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(to);
    bytes.copy_from_slice(memory.bytes(from).map_err(no_buffer)?);
    Ok(())
}

/// Addresses of the outputs: statuses, results, features, movers.
fn outputs(memory: &mut scphd_ptx::Memory, outcome: &Outcome) -> [u64; 4] {
    let Outcome { statuses, results, features, movers, .. } = outcome;
    let bytes =
        [size_of_val(&statuses[..]), size_of_val(&results[..]), size_of_val(&features[..]), size_of_val(&movers[..])];
    bytes.map(|bytes| memory.allocate_zeros(bytes))
}

fn collect(
    memory: &scphd_ptx::Memory,
    [statuses, results, features, movers]: [u64; 4],
    outcome: &mut Outcome,
) -> Result<(), DeviceError> {
    download(memory, statuses, &mut outcome.statuses)?;
    download(memory, results, &mut outcome.results)?;
    download(memory, features, &mut outcome.features)?;
    download(memory, movers, &mut outcome.movers)
}

impl Device for Interpreted {
    fn name(&self) -> &str {
        &self.name
    }

    fn run_bytes(&self, batch: &Batch) -> usize {
        buffers(batch, self.sizes[usize::from(batch.is_large())]).iter().sum::<usize>() / batch.runs.len().max(1)
    }

    fn resident(&self, _bytes_a_run: usize) -> Result<usize, DeviceError> {
        Ok(RESIDENT)
    }

    fn run(&mut self, batch: &Batch, digest_every: u32) -> Result<Outcome, DeviceError> {
        let mut outcome = Outcome::untouched(batch);
        let mut memory = self.fresh.clone();
        self.taken.clear();
        let inputs = [
            upload(&mut memory, &batch.runs),
            upload(&mut memory, &batch.scans),
            upload(&mut memory, &batch.predictions),
            upload(&mut memory, &batch.measurements),
        ];
        let scratch =
            buffers(batch, self.sizes[usize::from(batch.is_large())]).map(|bytes| memory.allocate_zeros(bytes));
        let outputs = outputs(&mut memory, &outcome);
        // In the order of the fields of `Filters`.
        let filters = upload(&mut memory, &[&inputs[..], &scratch, &outputs, &batch.counts()].concat());
        let [starting, predicting, scanning, digest] =
            if batch.is_large() { Launch::all::<LargeMemory>() } else { Launch::all::<Memory>() };
        let mut launch = |device: &mut Self, launch: &Launch, scan: u32| {
            device.launch(launch, batch, &[filters, u64::from(scan), u64::from(digest_every)], &mut memory)
        };
        for of_start in &starting {
            launch(self, of_start, 0)?;
        }
        self.taken.clear();
        let started = Instant::now();
        for scan in 0..batch.most_scans() {
            for of_scan in of_scan(batch, scan, [&predicting[..], &scanning]) {
                launch(self, of_scan, scan)?;
            }
            if batch.asks_for_digest(scan, digest_every) {
                digest.iter().try_for_each(|digest| launch(self, digest, scan))?;
            }
        }
        outcome.launched_s = started.elapsed().as_secs_f64();
        collect(&memory, outputs, &mut outcome)?;
        Ok(outcome)
    }

    /// The counts of every kernel.
    fn report(&self) -> Option<String> {
        let mut table = format!(
            "{:<20}{:>15}{:>15}{:>10}{:>15}{:>13}{:>13}{:>13}{:>8}\n",
            "kernel", "instructions", "of warps", "together", "longest warp", "accesses", "sectors", "local", "stack"
        );
        for (kernel, counts) in &self.taken {
            let Counts {
                instructions,
                warp_instructions,
                longest_warp,
                accesses,
                sectors,
                local_accesses,
                deepest_stack,
                ..
            } = counts;
            let together = counts.threads_together();
            writeln!(
                table,
                "{kernel:<20}{instructions:>15}{warp_instructions:>15}{together:>10.2}{longest_warp:>15}{accesses:>13}{sectors:>13}{local_accesses:>13}{deepest_stack:>8}"
            )
            .ok()?;
        }
        Some(table)
    }
}
