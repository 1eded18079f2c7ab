//! A CUDA device: the driver, the module and the memory, all located at run time.

use crate::batch::Batch;
use crate::device::{Device, DeviceError, Launch, Outcome, buffers, of_scan};
use bytemuck::Pod;
use cudarc::driver::{
    CudaContext, CudaFunction, CudaModule, CudaSlice, CudaStream, DevicePtr, DriverError, LaunchConfig, PushKernelArg,
    sys,
};
use cudarc::nvrtc::Ptx;
use scphd_gpu_kernels::{LargeMemory, Memory, Size};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Least alignment of memory that the driver allocates, bytes.
const ALIGNMENT: u64 = 256;

/// Number of warps that a multiprocessor executes at the same time.
const SCHEDULERS: usize = 4;
/// Least number of threads of a block, if the launch has that many.
const FEWEST: usize = 8;

/// The modules that `cargo xtask gpu` builds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Modules {
    folder: PathBuf,
}

impl Modules {
    /// File name of the module as PTX text, which the driver assembles for its card when it loads it; this takes a while.
    pub const TEXT: &'static str = "scphd.ptx";

    /// The modules in a folder.
    pub fn of(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// File name of the module that is assembled for a compute capability: 8 and 0 for sm_80.
    pub fn assembled(major: i32, minor: i32) -> String {
        format!("scphd-sm_{major}{minor}.cubin")
    }

    /// Reads the module for a compute capability: the assembled one, or the text if there is none.
    fn read(&self, (major, minor): (i32, i32)) -> Result<(Ptx, PathBuf), DeviceError> {
        let own = self.folder.join(Self::assembled(major, minor));
        if own.is_file() {
            return Ok((Ptx::from_binary(read(&own)?), own));
        }
        let (said, path) = self.text()?;
        Ok((Ptx::from_src(said), path))
    }

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

fn refused(doing: &'static str) -> impl Fn(DriverError) -> DeviceError {
    move |DriverError(code)| DeviceError::Driver { doing, why: format!("{code:?}") }
}

/// The kernels for filters of one size.
#[derive(Debug)]
struct Kernels {
    /// The kernels that start the filters, those of a prediction, those of a scan, and that of a digest.
    launches: [Vec<(CudaFunction, Launch)>; 4],
    /// Bytes of one element of each buffer: room, sight, desk, draft, stream, part.
    sizes: [usize; 6],
}

impl Kernels {
    fn load<M: Size>(module: &Arc<CudaModule>, stream: &Arc<CudaStream>) -> Result<Self, DeviceError> {
        let function = |name: &str| module.load_function(name).map_err(refused("looking for a kernel"));
        let load = |launch: Launch| Ok((function(&launch.kernel)?, launch));
        let [starting, predicting, scanning, digest] =
            Launch::all::<M>().map(|launches| launches.into_iter().map(load).collect::<Result<Vec<_>, DeviceError>>());
        let sizes = told_bytes(stream, &function(&Launch::bytes::<M>())?)?;
        Ok(Self { launches: [starting?, predicting?, scanning?, digest?], sizes })
    }
}

/// One card with the module loaded.
#[derive(Debug)]
pub struct Cuda {
    context: Arc<CudaContext>,
    stream: Arc<CudaStream>,
    /// The kernels for many filters, and for one large filter.
    kernels: [Kernels; 2],
    /// Greatest number of threads of a block, and number of blocks that a launch should have at least.
    block: u32,
    blocks: usize,
    name: String,
    /// The wall time of every kernel over all launches of the last batch, s; `None` without a profile.
    times: Option<Vec<(String, f64)>>,
}

impl Cuda {
    /// Opens the card with this index, for at most `block` threads a block. For a profile, the host waits for every launch and
    /// records its time.
    ///
    /// # Errors
    /// There is no driver or no such card, or the module cannot be loaded.
    pub fn open(modules: &Modules, card: usize, block: u32, profile: bool) -> Result<Self, DeviceError> {
        // SAFETY: the call loads the driver's library, whose initialisation is the system's responsibility, and releases it.
        if !unsafe { sys::is_culib_present() } {
            return Err(DeviceError::NoDriver);
        }
        let context = CudaContext::new(card).map_err(|DriverError(code)| DeviceError::NoDevice(format!("{code:?}")))?;
        let kind = context.compute_capability().map_err(refused("asking for the kind of the card"))?;
        let (module, path) = modules.read(kind)?;
        let module = context.load_module(module).map_err(refused("loading the module"))?;
        let stream = context.default_stream();
        let doing = refused("asking for the multiprocessors of the card");
        let count = sys::CUdevice_attribute::CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT;
        let blocks = SCHEDULERS * usize::try_from(context.attribute(count).map_err(doing)?).unwrap_or(1);
        let card = context.name().map_err(refused("asking for the name of the card"))?;
        let name = format!("{card}, sm_{}{}, {}, at most {block} threads a block", kind.0, kind.1, path.display());
        let kernels = [Kernels::load::<Memory>(&module, &stream)?, Kernels::load::<LargeMemory>(&module, &stream)?];
        Ok(Self { context, stream, kernels, block, blocks, name, times: profile.then(Vec::new) })
    }

    /// Number of threads of a block of a launch. Blocks are smaller if there are not enough threads for all schedulers of the
    /// card, because the threads of a block wait for each other where their paths diverge.
    fn block_of(&self, threads: usize) -> u32 {
        let few = (threads / self.blocks).next_power_of_two().max(FEWEST);
        u32::try_from(few).unwrap_or(self.block).min(self.block).min(threads.max(1) as u32)
    }

    fn kernels(&self, batch: &Batch) -> &Kernels {
        let [many, large] = &self.kernels;
        if batch.is_large() { large } else { many }
    }

    /// Allocates a buffer with this content. The driver has no empty buffers.
    fn upload<T: Pod>(&self, things: &[T]) -> Result<CudaSlice<u8>, DeviceError> {
        let bytes: &[u8] = bytemuck::cast_slice(things);
        let bytes = if bytes.is_empty() { &[0; 16] } else { bytes };
        self.stream.clone_htod(bytes).map_err(refused("copying to the card"))
    }

    fn zeros(&self, bytes: usize) -> Result<CudaSlice<u8>, DeviceError> {
        self.stream.alloc_zeros(bytes.max(16)).map_err(refused("allocating memory of the card"))
    }

    /// Copies the start of a buffer back, as many elements as `to` has.
    fn download<T: Pod>(&self, from: &CudaSlice<u8>, to: &mut [T]) -> Result<(), DeviceError> {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(to);
        if bytes.is_empty() {
            return Ok(());
        }
        self.stream.memcpy_dtoh(&from.slice(..bytes.len()), bytes).map_err(refused("copying from the card"))
    }
}

/// Bytes of the elements of the buffers as the module's compiler laid them out, which may differ from the host's layout. A kernel
/// writes them and their common alignment.
fn told_bytes(stream: &Arc<CudaStream>, kernel: &CudaFunction) -> Result<[usize; 6], DeviceError> {
    let doing = "asking the module for the bytes of its buffers";
    let mut said: CudaSlice<u64> = stream.alloc_zeros(7).map_err(refused(doing))?;
    let mut launch = stream.launch_builder(kernel);
    launch.arg(&mut said);
    // SAFETY: the kernel takes a pointer to seven numbers, and the buffer has seven.
    unsafe { launch.launch(grid(1, 1)) }.map_err(refused(doing))?;
    let mut numbers = vec![0_u64; 7];
    stream.memcpy_dtoh(&said, &mut numbers).map_err(refused(doing))?;
    stream.synchronize().map_err(refused(doing))?;
    bytes_of_buffers(&numbers)
}

/// Bytes of the buffers' elements, from the numbers that a kernel wrote: the bytes, and then the greatest alignment.
pub(crate) fn bytes_of_buffers(numbers: &[u64]) -> Result<[usize; 6], DeviceError> {
    let bytes: [usize; 6] = std::array::from_fn(|thing| usize::try_from(numbers[thing]).unwrap_or(0));
    if bytes.contains(&0) || numbers[6] > ALIGNMENT {
        let doing = "asking the module for the bytes of its buffers";
        return Err(DeviceError::Driver { doing, why: format!("{numbers:?}") });
    }
    Ok(bytes)
}

/// A grid of at least `threads` threads.
fn grid(threads: usize, block: u32) -> LaunchConfig {
    let blocks = (threads as u32).div_ceil(block).max(1);
    LaunchConfig { grid_dim: (blocks, 1, 1), block_dim: (block, 1, 1), shared_mem_bytes: 0 }
}

impl Device for Cuda {
    fn name(&self) -> &str {
        &self.name
    }

    fn run_bytes(&self, batch: &Batch) -> usize {
        buffers(batch, self.kernels(batch).sizes).iter().sum::<usize>() / batch.runs.len().max(1)
    }

    /// As many as fit into nine tenths of the free memory. The rest is for the stacks of all threads that the card can hold at
    /// the same time, which are allocated when a kernel is launched.
    fn resident(&self, bytes_a_run: usize) -> Result<usize, DeviceError> {
        let (free, _) = self.context.mem_get_info().map_err(refused("asking for free memory"))?;
        Ok((free / 10 * 9 / bytes_a_run.max(1)).max(1))
    }

    fn run(&mut self, batch: &Batch, digest_every: u32) -> Result<Outcome, DeviceError> {
        let mut outcome = Outcome::untouched(batch);
        let Kernels { launches: [starting, predicting, scanning, digest], sizes } = self.kernels(batch);
        let inputs = [
            self.upload(&batch.runs)?,
            self.upload(&batch.scans)?,
            self.upload(&batch.predictions)?,
            self.upload(&batch.measurements)?,
        ];
        let scratch =
            buffers(batch, *sizes).into_iter().map(|bytes| self.zeros(bytes)).collect::<Result<Vec<_>, _>>()?;
        let outputs = [
            self.zeros(size_of_val(&outcome.statuses[..]))?,
            self.zeros(size_of_val(&outcome.results[..]))?,
            self.zeros(size_of_val(&outcome.features[..]))?,
            self.zeros(size_of_val(&outcome.movers[..]))?,
        ];
        // The addresses of the buffers, and the counts, in the order of the fields of `Filters`.
        let addresses = inputs.iter().chain(&scratch).chain(&outputs).map(|buffer| buffer.device_ptr(&self.stream).0);
        let filters = self.upload(&addresses.chain(batch.counts()).collect::<Vec<u64>>())?;
        let doing = "running the kernels";
        self.stream.synchronize().map_err(refused(doing))?;
        let mut times = self.times.as_ref().map(|_| Vec::new());
        let mut launch = |(kernel, launch): &(CudaFunction, Launch), scan: u32| {
            let threads = launch.threads(batch);
            let block = self.block_of(threads);
            let mut call = self.stream.launch_builder(kernel);
            call.arg(&filters).arg(&scan).arg(&digest_every);
            let begun = Instant::now();
            // SAFETY: these are the arguments of the kernel, in its order. The buffers are those of the batch and its runs, and
            // outlive the launches; rooms and desks are zeros. Launches of one stream run one after the other; threads beyond the
            // last place do nothing.
            unsafe { call.launch(grid(threads, block)) }.map_err(refused(doing))?;
            if let Some(times) = &mut times {
                self.stream.synchronize().map_err(refused(doing))?;
                note(times, &launch.kernel, begun.elapsed().as_secs_f64());
            }
            Ok(())
        };
        starting.iter().try_for_each(|kernel| launch(kernel, 0))?;
        self.stream.synchronize().map_err(refused(doing))?;
        let (started, mut digests_s) = (Instant::now(), 0.0);
        for scan in 0..batch.most_scans() {
            of_scan(batch, scan, [predicting, scanning]).try_for_each(|kernel| launch(kernel, scan))?;
            if batch.asks_for_digest(scan, digest_every) {
                self.stream.synchronize().map_err(refused(doing))?;
                let begun = Instant::now();
                digest.iter().try_for_each(|kernel| launch(kernel, scan))?;
                self.stream.synchronize().map_err(refused(doing))?;
                digests_s += begun.elapsed().as_secs_f64();
            }
        }
        self.stream.synchronize().map_err(refused(doing))?;
        outcome.launched_s = started.elapsed().as_secs_f64() - digests_s;
        self.times = times;
        let [statuses, results, features, movers] = &outputs;
        self.download(statuses, &mut outcome.statuses)?;
        self.download(results, &mut outcome.results)?;
        self.download(features, &mut outcome.features)?;
        self.download(movers, &mut outcome.movers)?;
        self.stream.synchronize().map_err(refused("copying from the card"))?;
        Ok(outcome)
    }

    fn report(&self) -> Option<String> {
        let times = self.times.as_ref()?;
        let all: f64 = times.iter().map(|(_, seconds)| seconds).sum();
        let line = |(kernel, seconds): &(String, f64)| {
            format!("{kernel:<24}{seconds:>10.4} s {:>5.1} %", 100.0 * seconds / all)
        };
        Some(times.iter().map(line).collect::<Vec<_>>().join("\n"))
    }
}

fn note(times: &mut Vec<(String, f64)>, kernel: &str, seconds: f64) {
    match times.iter_mut().find(|(known, _)| known == kernel) {
        Some((_, sum)) => *sum += seconds,
        None => times.push((kernel.to_owned(), seconds)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_module_assembled_for_the_card_is_preferred() {
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
    fn a_missing_driver_is_reported() {
        let error = Cuda::open(&Modules::of("nowhere"), 0, 32, false).map(drop);
        // With a driver, the module is missing.
        let said = error.unwrap_err().to_string();
        assert!(["no CUDA driver", "no CUDA device", "nowhere"].iter().any(|what| said.contains(what)), "{said}");
    }
}
