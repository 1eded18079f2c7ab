//! A CUDA device: the driver, the module and the memory, all located at run time.

use crate::batch::Batch;
use crate::device::{DeviceError, Kernels, Launch, Machine};
use cudarc::driver::{
    CudaContext, CudaFunction, CudaModule, CudaSlice, CudaStream, DevicePtr, DriverError, LaunchConfig, PushKernelArg,
    sys,
};
use cudarc::nvrtc::Ptx;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

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
    move |DriverError(code)| DeviceError::Refused { doing, why: format!("{code:?}") }
}

/// One card with the module loaded.
#[derive(Debug)]
pub struct Cuda {
    context: Arc<CudaContext>,
    stream: Arc<CudaStream>,
    module: Arc<CudaModule>,
    /// The kernels that were launched.
    kernels: HashMap<String, CudaFunction>,
    buffers: Vec<CudaSlice<u8>>,
    /// Greatest number of threads of a block, and number of blocks that a launch should have at least.
    block: u32,
    blocks: usize,
    name: String,
    /// The wall time of every kernel since the buffers were freed, s; `None` without a profile.
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
        let (kernels, buffers, times) = (HashMap::new(), Vec::new(), profile.then(Vec::new));
        Ok(Self { context, stream, module, kernels, buffers, block, blocks, name, times })
    }

    /// Number of threads of a block of a launch. Blocks are smaller if there are not enough threads for all schedulers of the
    /// card, because the threads of a block wait for each other where their paths diverge.
    fn block_of(&self, threads: usize) -> usize {
        let few = (threads / self.blocks).next_power_of_two().max(FEWEST);
        few.min(self.block as usize).min(threads.max(1))
    }

    fn kernel(&mut self, name: &str) -> Result<&CudaFunction, DeviceError> {
        if !self.kernels.contains_key(name) {
            let function = self.module.load_function(name).map_err(refused("looking for a kernel"))?;
            self.kernels.insert(name.to_owned(), function);
        }
        Ok(&self.kernels[name])
    }

    fn keep(&mut self, buffer: CudaSlice<u8>) -> u64 {
        let address = buffer.device_ptr(&self.stream).0;
        self.buffers.push(buffer);
        address
    }
}

/// A grid of at least `threads` threads.
fn grid(threads: usize, block: usize) -> LaunchConfig {
    let blocks = threads.div_ceil(block).max(1);
    LaunchConfig { grid_dim: (blocks as u32, 1, 1), block_dim: (block as u32, 1, 1), shared_mem_bytes: 0 }
}

impl Machine for Cuda {
    fn name(&self) -> &str {
        &self.name
    }

    fn bytes(&mut self, kernels: &Kernels) -> Result<[u64; 7], DeviceError> {
        let doing = "asking the module for the bytes of its buffers";
        let stream = self.stream.clone();
        let mut told: CudaSlice<u64> = stream.alloc_zeros(7).map_err(refused(doing))?;
        let mut launch = stream.launch_builder(self.kernel(&kernels.bytes.0)?);
        launch.arg(&mut told);
        // SAFETY: the kernel takes a pointer to seven numbers, and the buffer has seven.
        unsafe { launch.launch(grid(1, 1)) }.map_err(refused(doing))?;
        let mut numbers = [0; 7];
        stream.memcpy_dtoh(&told, &mut numbers).map_err(refused(doing))?;
        stream.synchronize().map_err(refused(doing))?;
        Ok(numbers)
    }

    fn clear(&mut self) {
        self.buffers.clear();
        self.times.iter_mut().for_each(Vec::clear);
    }

    fn free(&self) -> Result<Option<usize>, DeviceError> {
        let (free, _) = self.context.mem_get_info().map_err(refused("asking for free memory"))?;
        Ok(Some(free))
    }

    fn upload(&mut self, bytes: &[u8]) -> Result<u64, DeviceError> {
        // The driver has no empty buffers.
        let bytes = if bytes.is_empty() { &[0; 16] } else { bytes };
        let buffer = self.stream.clone_htod(bytes).map_err(refused("copying to the card"))?;
        Ok(self.keep(buffer))
    }

    fn zeros(&mut self, bytes: usize) -> Result<u64, DeviceError> {
        let buffer = self.stream.alloc_zeros(bytes.max(16)).map_err(refused("allocating memory of the card"))?;
        Ok(self.keep(buffer))
    }

    fn download(&mut self, address: u64, to: &mut [u8]) -> Result<(), DeviceError> {
        let buffer = self.buffers.iter().find(|buffer| buffer.device_ptr(&self.stream).0 == address);
        if let Some(from) = buffer.filter(|_| !to.is_empty()) {
            self.stream.memcpy_dtoh(&from.slice(..to.len()), to).map_err(refused("copying from the card"))?;
        }
        self.wait()
    }

    fn launch(&mut self, launch: &Launch, batch: &Batch, arguments: (u64, u32, u32)) -> Result<(), DeviceError> {
        let (threads, block) = launch.threads(batch);
        let block = block.unwrap_or_else(|| self.block_of(threads));
        let (kernel, stream) = (launch.kernel.clone(), self.stream.clone());
        let mut call = stream.launch_builder(self.kernel(&kernel)?);
        call.arg(&arguments.0).arg(&arguments.1).arg(&arguments.2);
        let begun = Instant::now();
        // SAFETY: these are the arguments of the kernel, in its order. The buffers are those of the batch and its runs, and outlive the
        // launches; rooms and desks are zeros. Launches of one stream run one after the other; threads beyond the last place do
        // nothing.
        unsafe { call.launch(grid(threads, block)) }.map_err(refused("running the kernels"))?;
        if self.times.is_some() {
            self.wait()?;
        }
        let seconds = begun.elapsed().as_secs_f64();
        if let Some(times) = &mut self.times {
            match times.iter_mut().find(|(known, _)| *known == kernel) {
                Some((_, sum)) => *sum += seconds,
                None => times.push((kernel, seconds)),
            }
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<(), DeviceError> {
        self.stream.synchronize().map_err(refused("running the kernels"))
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
