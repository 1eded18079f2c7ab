//! The module itself on the host: every instruction of its text, one after the other, by `scphd-ptx`.

use crate::batch::Batch;
use crate::cuda::{Modules, bytes_of_buffers};
use crate::device::{Device, DeviceError, Launches, Outcome, of_scan, spans};
use bytemuck::Pod;
use scphd_gpu_kernels::{PREDICT, Places, STAGES, START};
use scphd_ptx::{AccessError, Counts, Grid, LaunchError, Memory, Module};
use std::fmt::Write as _;
use std::time::Instant;

/// Runs at once: a host has no other limit than what it takes to hold them.
const RESIDENT: usize = 64;

/// How the module is executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Execution {
    /// Threads of a block.
    pub block: u32,
    /// Threads that go together.
    pub warp: u32,
    /// Whether two threads of a launch at one place, one of them to write, are an error.
    pub watch: bool,
}

/// The module, and what its launches have taken.
#[derive(Debug, Clone)]
pub struct Interpreted {
    module: Module,
    /// Memory with the variables of the module, and nothing else yet.
    fresh: Memory,
    execution: Execution,
    slot_bytes: usize,
    /// Bytes of what the buffers of a large filter are made of: room, sight, desk, draft.
    large_bytes: [usize; 4],
    name: String,
    /// Of every kernel, over all launches of the last run.
    taken: Vec<(&'static str, Counts)>,
}

impl Interpreted {
    /// Reads the module.
    ///
    /// # Errors
    /// There is none, or it has something in it that is not known.
    pub fn open(modules: &Modules, execution: Execution) -> Result<Self, DeviceError> {
        let (text, path) = modules.text()?;
        let mut fresh = Memory::new();
        if execution.watch {
            fresh.watch();
        }
        let module = Module::read(&text, &mut fresh);
        let module = module.map_err(|error| DeviceError::Module { path: path.clone(), why: error.to_string() })?;
        let Execution { block, warp, .. } = execution;
        let name = format!("interpreted, {}, {block} threads a block, {warp} a warp", path.display());
        let mut new = Self { module, fresh, execution, slot_bytes: 0, large_bytes: [0; 4], name, taken: Vec::new() };
        [new.slot_bytes] = new.told_bytes("scphd_slot")?;
        new.large_bytes = new.told_bytes("scphd_large_bytes")?;
        Ok(new)
    }

    /// What a kernel writes of the bytes of its buffers.
    fn told_bytes<const THINGS: usize>(&self, kernel: &str) -> Result<[usize; THINGS], DeviceError> {
        let mut memory = self.fresh.clone();
        let said = memory.allocate_zeros(8 * (THINGS + 1));
        self.module.launch(kernel, Grid { blocks: 1, block: 1, warp: 1 }, &[said], &mut memory).map_err(stopped)?;
        let bytes = memory.bytes(said).map_err(no_buffer)?;
        let numbers: Vec<u64> = bytemuck::pod_collect_to_vec(bytes);
        bytes_of_buffers(&numbers)
    }

    /// Launches a kernel, and counts what it takes.
    fn launch(
        &mut self,
        kernel: &'static str,
        threads: usize,
        arguments: &[u64],
        memory: &mut Memory,
    ) -> Result<(), DeviceError> {
        let Execution { block, warp, .. } = self.execution;
        let block = if threads == 1 { 1 } else { block };
        let grid = Grid { blocks: (threads as u32).div_ceil(block).max(1), block, warp };
        let counts = self.module.launch(kernel, grid, arguments, memory).map_err(stopped)?;
        match self.taken.iter_mut().find(|(known, _)| *known == kernel) {
            Some((_, of_kernel)) => *of_kernel = of_kernel.and(counts),
            None => self.taken.push((kernel, counts)),
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

fn upload<T: Pod>(memory: &mut Memory, things: &[T]) -> u64 {
    memory.allocate(bytemuck::cast_slice(things))
}

fn download<T: Pod>(memory: &Memory, from: u64, to: &mut [T]) -> Result<(), DeviceError> {
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(to);
    bytes.copy_from_slice(memory.bytes(from).map_err(no_buffer)?);
    Ok(())
}

/// Where the results of a run lie: statuses, results, features, movers.
fn outputs(memory: &mut Memory, outcome: &Outcome) -> [u64; 4] {
    let Outcome { statuses, results, features, movers, .. } = outcome;
    let bytes =
        [size_of_val(&statuses[..]), size_of_val(&results[..]), size_of_val(&features[..]), size_of_val(&movers[..])];
    bytes.map(|bytes| memory.allocate_zeros(bytes))
}

fn collect(
    memory: &Memory,
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

    fn slot_bytes(&self) -> usize {
        self.slot_bytes
    }

    fn resident(&self, _bytes_a_run: usize) -> Result<usize, DeviceError> {
        Ok(RESIDENT)
    }

    fn run(&mut self, batch: &Batch, launches: Launches) -> Result<Outcome, DeviceError> {
        let mut outcome = Outcome::untouched(batch);
        let mut memory = self.fresh.clone();
        self.taken.clear();
        let inputs = [
            upload(&mut memory, &batch.runs),
            upload(&mut memory, &batch.scans),
            upload(&mut memory, &batch.predictions),
            upload(&mut memory, &batch.measurements),
        ];
        let slots = memory.allocate_zeros(batch.runs.len() * self.slot_bytes);
        let outputs = outputs(&mut memory, &outcome);
        let started = Instant::now();
        for (first_scan, take_scans) in spans(batch.most_scans(), launches) {
            let numbers = [batch.runs.len() as u32, first_scan, take_scans, launches.digest_every].map(u64::from);
            let arguments = [&inputs[..], &[slots], &outputs, &numbers].concat();
            self.launch("scphd_runs", batch.runs.len(), &arguments, &mut memory)?;
        }
        outcome.launched_s = started.elapsed().as_secs_f64();
        collect(&memory, outputs, &mut outcome)?;
        Ok(outcome)
    }

    fn run_large(&mut self, batch: &Batch, digest_every: u32) -> Result<Outcome, DeviceError> {
        let mut outcome = Outcome::untouched(batch);
        let Some(run) = batch.runs.first() else { return Ok(outcome) };
        let mut memory = self.fresh.clone();
        self.taken.clear();
        let [particles, samples] = [run.setup.particles, run.setup.samples].map(|count| count as usize);
        let [room, sight, desk, draft] = self.large_bytes;
        let outputs = outputs(&mut memory, &outcome);
        // The addresses of the buffers, in the order of `Large`.
        let addresses = [
            upload(&mut memory, &batch.runs),
            upload(&mut memory, &batch.scans),
            upload(&mut memory, &batch.predictions),
            upload(&mut memory, &batch.measurements),
            memory.allocate_zeros(room),
            memory.allocate_zeros(sight * particles * samples),
            memory.allocate_zeros(desk * particles),
            memory.allocate_zeros(draft * particles),
        ];
        let large = upload(&mut memory, &[&addresses[..], &outputs].concat());
        let mut launch = |device: &mut Self, kernel, places: Places, scan| {
            let arguments = [large, u64::from(scan), u64::from(digest_every)];
            device.launch(kernel, places.count(particles, samples), &arguments, &mut memory)
        };
        for (kernel, places, _) in START {
            launch(self, kernel, places, 0)?;
        }
        self.taken.clear();
        let started = Instant::now();
        for scan in 0..run.scans {
            for &(kernel, places, _) in of_scan(batch, scan, [&PREDICT, &STAGES]) {
                launch(self, kernel, places, scan)?;
            }
        }
        outcome.launched_s = started.elapsed().as_secs_f64();
        collect(&memory, outputs, &mut outcome)?;
        Ok(outcome)
    }

    /// Counts of every kernel.
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
