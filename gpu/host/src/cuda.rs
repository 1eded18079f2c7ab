//! A device of CUDA: driver, module and memory, all looked for at run time.

use crate::batch::Batch;
use crate::device::{Device, DeviceError, Launches, Outcome, of_scan, spans};
use bytemuck::Pod;
use cudarc::driver::{
    CudaContext, CudaFunction, CudaSlice, CudaStream, DevicePtr, DriverError, LaunchConfig, PushKernelArg, sys,
};
use cudarc::nvrtc::Ptx;
use scphd_gpu_kernels::{PREDICT, Places, STAGES, START, Stage};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// What the driver aligns its memory to at least, bytes.
const ALIGNMENT: u64 = 256;

/// The modules that `cargo xtask gpu` makes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Modules {
    folder: PathBuf,
}

impl Modules {
    /// The module as text, which the driver assembles for its card when it loads it; that takes it a while.
    pub const TEXT: &'static str = "scphd.ptx";

    /// Those of a folder.
    #[must_use]
    pub fn of(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// The name of the module that is assembled for cards of this kind: 8 and 0 for sm_80.
    #[must_use]
    pub fn assembled(major: i32, minor: i32) -> String {
        format!("scphd-sm_{major}{minor}.cubin")
    }

    /// The one for such a card: assembled for it, or otherwise as text.
    fn read(&self, (major, minor): (i32, i32)) -> Result<(Ptx, PathBuf), DeviceError> {
        let own = self.folder.join(Self::assembled(major, minor));
        if own.is_file() {
            return Ok((Ptx::from_binary(read(&own)?), own));
        }
        let (said, path) = self.text()?;
        Ok((Ptx::from_src(said), path))
    }

    /// The module as text, and its path.
    pub(crate) fn text(&self) -> Result<(String, PathBuf), DeviceError> {
        let path = self.folder.join(Self::TEXT);
        let said = String::from_utf8(read(&path)?).ok().filter(|said| !said.contains('\0'));
        let said = said.ok_or_else(|| DeviceError::Module { path: path.clone(), why: "is no text".into() })?;
        Ok((said, path))
    }
}

fn read(path: &Path) -> Result<Vec<u8>, DeviceError> {
    std::fs::read(path).map_err(|error| DeviceError::Module { path: path.into(), why: error.to_string() })
}

/// What was asked of the driver when it said no.
fn refused(doing: &'static str) -> impl Fn(DriverError) -> DeviceError {
    move |DriverError(code)| DeviceError::Driver { doing, why: format!("{code:?}") }
}

/// A kernel of a large filter, and how many threads it is launched with.
type Kernel = (CudaFunction, Places);

/// One card with the module in it.
#[derive(Debug)]
pub struct Cuda {
    context: Arc<CudaContext>,
    stream: Arc<CudaStream>,
    runs: CudaFunction,
    slot_bytes: usize,
    /// The launches that start a large filter, those of its predictions, and those of its scans.
    large: [Vec<Kernel>; 3],
    /// Bytes of what its buffers are made of: room, sight, desk, draft.
    large_bytes: [usize; 4],
    /// Threads of a block, where it is said.
    block: Option<u32>,
    /// Warps of `runs` that the card holds at once.
    warps: u32,
    name: String,
}

/// Threads of a block of a large filter, unless said otherwise: a warp.
const BLOCK: u32 = 32;

/// Threads of a block so that every run is in the card at once in as many blocks as it has room for. A warp of fewer threads, whose ways
/// part less, is done earlier, and a launch lasts as long as its longest warp.
fn threads_a_block(runs: usize, warps: u32) -> u32 {
    (runs as u32).div_ceil(warps.max(1)).clamp(1, BLOCK)
}

impl Cuda {
    /// The card of that number, with so many threads a block, or as many as suit it.
    ///
    /// # Errors
    /// There is no driver or no such card, or the module cannot be loaded.
    pub fn open(modules: &Modules, card: usize, block: Option<u32>) -> Result<Self, DeviceError> {
        // SAFETY: it loads the driver's library, whose initialisation is the system's business, and lets go of it.
        if !unsafe { sys::is_culib_present() } {
            return Err(DeviceError::NoDriver);
        }
        let context = CudaContext::new(card).map_err(|DriverError(code)| DeviceError::NoDevice(format!("{code:?}")))?;
        let kind = context.compute_capability().map_err(refused("asking for the kind of the card"))?;
        let (module, path) = modules.read(kind)?;
        let loaded = context.load_module(module).map_err(refused("loading the module"))?;
        let function = |name| loaded.load_function(name).map_err(refused("looking for a kernel"));
        let (runs, slot, large) = (function("scphd_runs")?, function("scphd_slot")?, function("scphd_large_bytes")?);
        let kernel = |&(name, places, _): &Stage| Ok::<Kernel, DeviceError>((function(name)?, places));
        let kernels = |stages: &[Stage]| stages.iter().map(kernel).collect::<Result<_, _>>();
        let kernels = [kernels(&START)?, kernels(&PREDICT)?, kernels(&STAGES)?];
        let stream = context.default_stream();
        let card = context.name().map_err(refused("asking for the name of the card"))?;
        let multiprocessors = context
            .attribute(sys::CUdevice_attribute::CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT)
            .map_err(refused("asking for the card's multiprocessors"))?;
        let warps = runs.occupancy_max_active_blocks_per_multiprocessor(BLOCK, 0, None);
        let warps = warps.map_err(refused("asking how many warps a multiprocessor holds"))?;
        let warps = warps * multiprocessors.unsigned_abs();
        let block = block.map(|block| block.max(1));
        let threads = block.map_or_else(|| "as many as suit".to_owned(), |block| block.to_string());
        let name =
            format!("{card}, sm_{}{}, {warps} warps, {}, {threads} threads a block", kind.0, kind.1, path.display());
        let [slot_bytes] = told_bytes(&stream, &slot)?;
        let large_bytes = told_bytes(&stream, &large)?;
        Ok(Self { context, stream, runs, slot_bytes, large: kernels, large_bytes, block, warps, name })
    }

    /// A buffer with these things in it; the driver has no empty ones.
    fn upload<T: Pod>(&self, things: &[T]) -> Result<CudaSlice<u8>, DeviceError> {
        let bytes: &[u8] = bytemuck::cast_slice(things);
        let bytes = if bytes.is_empty() { &[0; 16] } else { bytes };
        self.stream.clone_htod(bytes).map_err(refused("copying to the card"))
    }

    fn zeros(&self, bytes: usize) -> Result<CudaSlice<u8>, DeviceError> {
        self.stream.alloc_zeros(bytes.max(16)).map_err(refused("allocating memory of the card"))
    }

    /// Copies a buffer back into as many things as there are.
    fn download<T: Pod>(&self, from: &CudaSlice<u8>, to: &mut [T]) -> Result<(), DeviceError> {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(to);
        if bytes.is_empty() {
            return Ok(());
        }
        self.stream.memcpy_dtoh(&from.slice(..bytes.len()), bytes).map_err(refused("copying from the card"))
    }
}

/// Bytes of what buffers are made of, as the module's compiler has laid it out, which need not be what the host's has made of it. A
/// kernel writes them, and what all of it must be aligned to.
fn told_bytes<const THINGS: usize>(
    stream: &Arc<CudaStream>,
    kernel: &CudaFunction,
) -> Result<[usize; THINGS], DeviceError> {
    let doing = "asking the module for the bytes of its buffers";
    let mut said: CudaSlice<u64> = stream.alloc_zeros(THINGS + 1).map_err(refused(doing))?;
    let mut launch = stream.launch_builder(kernel);
    launch.arg(&mut said);
    // SAFETY: the kernel takes a pointer to so many numbers, and there they are.
    unsafe { launch.launch(grid(1, 1)) }.map_err(refused(doing))?;
    let mut numbers = vec![0_u64; THINGS + 1];
    stream.memcpy_dtoh(&said, &mut numbers).map_err(refused(doing))?;
    stream.synchronize().map_err(refused(doing))?;
    bytes_of_buffers(&numbers)
}

/// Bytes of things, from what a kernel has said of them and of their alignment.
pub(crate) fn bytes_of_buffers<const THINGS: usize>(numbers: &[u64]) -> Result<[usize; THINGS], DeviceError> {
    let bytes: [usize; THINGS] = std::array::from_fn(|thing| usize::try_from(numbers[thing]).unwrap_or(0));
    if bytes.contains(&0) || numbers[THINGS] > ALIGNMENT {
        let doing = "asking the module for the bytes of its buffers";
        return Err(DeviceError::Driver { doing, why: format!("{numbers:?}") });
    }
    Ok(bytes)
}

/// A grid with so many threads at least.
fn grid(threads: usize, block: u32) -> LaunchConfig {
    let blocks = (threads as u32).div_ceil(block).max(1);
    LaunchConfig { grid_dim: (blocks, 1, 1), block_dim: (block, 1, 1), shared_mem_bytes: 0 }
}

impl Device for Cuda {
    fn name(&self) -> &str {
        &self.name
    }

    fn slot_bytes(&self) -> usize {
        self.slot_bytes
    }

    /// As many as fit into three quarters of the memory that is free: the stacks of all threads that the card can hold at once take
    /// theirs when the kernel is launched.
    fn resident(&self, bytes_a_run: usize) -> Result<usize, DeviceError> {
        let (free, _) = self.context.mem_get_info().map_err(refused("asking for free memory"))?;
        Ok((free / 4 * 3 / (self.slot_bytes + bytes_a_run)).max(1))
    }

    fn run(&mut self, batch: &Batch, launches: Launches) -> Result<Outcome, DeviceError> {
        let mut outcome = Outcome::untouched(batch);
        let runs = self.upload(&batch.runs)?;
        let scans = self.upload(&batch.scans)?;
        let predictions = self.upload(&batch.predictions)?;
        let measurements = self.upload(&batch.measurements)?;
        let mut slots = self.zeros(batch.runs.len() * self.slot_bytes)?;
        let mut statuses = self.zeros(size_of_val(&outcome.statuses[..]))?;
        let mut results = self.zeros(size_of_val(&outcome.results[..]))?;
        let mut features = self.zeros(size_of_val(&outcome.features[..]))?;
        let mut movers = self.zeros(size_of_val(&outcome.movers[..]))?;
        let doing = "running the kernel";
        self.stream.synchronize().map_err(refused(doing))?;
        let threads = batch.runs.len() as u32;
        let block = self.block.unwrap_or_else(|| threads_a_block(batch.runs.len(), self.warps));
        let grid = grid(batch.runs.len(), block);
        let started = Instant::now();
        for (first_scan, take_scans) in spans(batch.most_scans(), launches) {
            let mut launch = self.stream.launch_builder(&self.runs);
            launch.arg(&runs).arg(&scans).arg(&predictions).arg(&measurements);
            launch.arg(&mut slots).arg(&mut statuses).arg(&mut results).arg(&mut features).arg(&mut movers);
            launch.arg(&threads).arg(&first_scan).arg(&take_scans).arg(&launches.digest_every);
            // SAFETY: these are the arguments of the kernel, in its order; the buffers are those of a batch, and have room for what its
            // runs say; threads beyond the last run do nothing.
            unsafe { launch.launch(grid) }.map_err(refused(doing))?;
            self.stream.synchronize().map_err(refused(doing))?;
        }
        outcome.launched_s = started.elapsed().as_secs_f64();
        self.download(&statuses, &mut outcome.statuses)?;
        self.download(&results, &mut outcome.results)?;
        self.download(&features, &mut outcome.features)?;
        self.download(&movers, &mut outcome.movers)?;
        self.stream.synchronize().map_err(refused("copying from the card"))?;
        Ok(outcome)
    }

    fn run_large(&mut self, batch: &Batch, digest_every: u32) -> Result<Outcome, DeviceError> {
        let mut outcome = Outcome::untouched(batch);
        let Some(run) = batch.runs.first() else { return Ok(outcome) };
        let [particles, samples] = [run.setup.particles, run.setup.samples].map(|count| count as usize);
        let [room, sight, desk, draft] = self.large_bytes;
        let inputs = [
            self.upload(&batch.runs)?,
            self.upload(&batch.scans)?,
            self.upload(&batch.predictions)?,
            self.upload(&batch.measurements)?,
        ];
        let scratch = [
            self.zeros(room)?,
            self.zeros(sight * particles * samples)?,
            self.zeros(desk * particles)?,
            self.zeros(draft * particles)?,
        ];
        let outputs = [
            self.zeros(size_of_val(&outcome.statuses[..]))?,
            self.zeros(size_of_val(&outcome.results[..]))?,
            self.zeros(size_of_val(&outcome.features[..]))?,
            self.zeros(size_of_val(&outcome.movers[..]))?,
        ];
        // The addresses of the buffers, in the order of `Large`.
        let buffers = inputs.iter().chain(&scratch).chain(&outputs);
        let addresses: Vec<u64> = buffers.map(|buffer| buffer.device_ptr(&self.stream).0).collect();
        let large = self.upload(&addresses)?;
        let doing = "running the kernels of a large filter";
        self.stream.synchronize().map_err(refused(doing))?;
        let launch = |(kernel, places): &Kernel, scan: u32| {
            let block = if *places == Places::One { 1 } else { self.block.unwrap_or(BLOCK) };
            let mut launch = self.stream.launch_builder(kernel);
            launch.arg(&large).arg(&scan).arg(&digest_every);
            // SAFETY: these are the arguments of the kernel, in its order, and the buffers, which outlive the launches, are those of a batch
            // with this run; room and desks are zeros. Launches of one stream come one after the other; threads beyond the last place do
            // nothing.
            unsafe { launch.launch(grid(places.count(particles, samples), block)) }.map_err(refused(doing))
        };
        let [start, predict, stages] = &self.large;
        for kernel in start {
            launch(kernel, 0)?;
        }
        self.stream.synchronize().map_err(refused(doing))?;
        let started = Instant::now();
        for scan in 0..run.scans {
            for kernel in of_scan(batch, scan, [predict, stages]) {
                launch(kernel, scan)?;
            }
        }
        self.stream.synchronize().map_err(refused(doing))?;
        outcome.launched_s = started.elapsed().as_secs_f64();
        let [statuses, results, features, movers] = &outputs;
        self.download(statuses, &mut outcome.statuses)?;
        self.download(results, &mut outcome.results)?;
        self.download(features, &mut outcome.features)?;
        self.download(movers, &mut outcome.movers)?;
        self.stream.synchronize().map_err(refused("copying from the card"))?;
        Ok(outcome)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_module_that_is_assembled_for_the_card_goes_first() {
        let folder = std::env::temp_dir().join(format!("scphd-gpu-modules-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let modules = Modules::of(&folder);
        assert!(matches!(modules.read((9, 0)), Err(DeviceError::Module { .. })));
        std::fs::write(folder.join(Modules::TEXT), ".version 7.0\n").unwrap();
        std::fs::write(folder.join("scphd-sm_90.cubin"), [0x7f, 0x45]).unwrap();
        assert!(modules.read((9, 0)).unwrap().1.ends_with("scphd-sm_90.cubin"));
        assert!(modules.read((8, 6)).unwrap().1.ends_with(Modules::TEXT));
        std::fs::write(folder.join(Modules::TEXT), [0_u8, 1]).unwrap();
        assert!(matches!(modules.read((8, 6)), Err(DeviceError::Module { .. })));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn runs_are_spread_over_the_warps_of_the_card() {
        let of = |runs| threads_a_block(runs, 1056);
        assert_eq!([1, 1056, 1057, 10_000, 33_792, 1_000_000].map(of), [1, 1, 2, 10, 32, 32]);
        assert_eq!(threads_a_block(5, 0), 5);
    }

    #[test]
    fn without_a_driver_it_says_so() {
        let error = Cuda::open(&Modules::of("nowhere"), 0, None).map(drop);
        // With one, there is no module.
        let said = error.unwrap_err().to_string();
        assert!(["no CUDA driver", "no CUDA device", "nowhere"].iter().any(|what| said.contains(what)), "{said}");
    }
}
