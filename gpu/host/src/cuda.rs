//! A CUDA device: the driver, the module and the memory, all located at run time.
#![expect(unsafe_code, reason = "the driver starts kernels with pointers")]

use crate::device::{Launch, Machine, module, read};
use crate::failure::Failure;
use cudarc::driver::{
    CudaContext, CudaFunction, CudaModule, CudaSlice, CudaStream, DevicePtr, DriverError, LaunchConfig, PushKernelArg,
    sys,
};
use cudarc::nvrtc::Ptx;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Number of warps that a multiprocessor executes at the same time.
const SCHEDULERS: usize = 4;
/// Least and greatest number of threads of a block, if the launch has that many.
const FEWEST: usize = 8;
const MOST: usize = 32;

fn refused(doing: &'static str) -> impl Fn(DriverError) -> Failure {
    move |DriverError(code)| Failure::of(doing, format!("{code:?}"))
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
    /// Number of blocks that a launch should have at least.
    blocks: usize,
    name: String,
    /// The wall time of every kernel since the buffers were freed, s; `None` without a profile.
    times: Option<BTreeMap<String, f64>>,
}

impl Cuda {
    /// Opens the first card. For a profile, the host waits for every launch and records its time.
    pub fn open(folder: &Path, profile: bool) -> Result<Self, Failure> {
        // SAFETY: the call loads the driver's library, whose initialisation is the system's responsibility, and releases it.
        if !unsafe { sys::is_culib_present() } {
            return Err(Failure::NoDevice("no libcuda on this machine".into()));
        }
        let context = CudaContext::new(0).map_err(|DriverError(code)| Failure::NoDevice(format!("{code:?}")))?;
        let kind = context.compute_capability().map_err(refused("asking for the kind of the card"))?;
        let assembled = folder.join(format!("scphd-sm_{}{}.cubin", kind.0, kind.1));
        let (module, path) = if assembled.is_file() {
            (Ptx::from_binary(read(&assembled)?), assembled)
        } else {
            module(folder).map(|(text, path)| (Ptx::from_src(text), path))?
        };
        let module = context.load_module(module).map_err(refused("loading the module"))?;
        let stream = context.default_stream();
        let doing = refused("asking for the multiprocessors of the card");
        let count = sys::CUdevice_attribute::CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT;
        let blocks = SCHEDULERS * usize::try_from(context.attribute(count).map_err(doing)?).unwrap_or(1);
        let card = context.name().map_err(refused("asking for the name of the card"))?;
        let name = format!("{card}, sm_{}{}, {}", kind.0, kind.1, path.display());
        let (kernels, buffers, times) = (HashMap::new(), Vec::new(), profile.then(BTreeMap::new));
        Ok(Self { context, stream, module, kernels, buffers, blocks, name, times })
    }

    /// Number of threads of a block of a launch. Blocks are smaller if there are not enough threads for all schedulers of the
    /// card, because the threads of a block wait for each other where their paths diverge.
    fn block_of(&self, threads: usize) -> usize {
        let few = (threads / self.blocks).next_power_of_two().max(FEWEST);
        few.min(MOST).min(threads.max(1))
    }

    fn kernel(&mut self, name: &str) -> Result<&CudaFunction, Failure> {
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

impl Machine for Cuda {
    fn name(&self) -> &str {
        &self.name
    }

    fn clear(&mut self) {
        self.buffers.clear();
        self.times.iter_mut().for_each(BTreeMap::clear);
    }

    fn free(&self) -> Result<Option<usize>, Failure> {
        let (free, _) = self.context.mem_get_info().map_err(refused("asking for free memory"))?;
        Ok(Some(free))
    }

    fn upload(&mut self, bytes: &[u8]) -> Result<u64, Failure> {
        // The driver has no empty buffers.
        let bytes = if bytes.is_empty() { &[0; 16] } else { bytes };
        let buffer = self.stream.clone_htod(bytes).map_err(refused("copying to the card"))?;
        Ok(self.keep(buffer))
    }

    fn zeros(&mut self, bytes: usize) -> Result<u64, Failure> {
        let buffer = self.stream.alloc_zeros(bytes.max(16)).map_err(refused("allocating memory of the card"))?;
        Ok(self.keep(buffer))
    }

    fn download(&mut self, address: u64, to: &mut [u8]) -> Result<(), Failure> {
        let buffer = self.buffers.iter().find(|buffer| buffer.device_ptr(&self.stream).0 == address);
        if let Some(from) = buffer.filter(|_| !to.is_empty()) {
            self.stream.memcpy_dtoh(&from.slice(..to.len()), to).map_err(refused("copying from the card"))?;
        }
        self.wait()
    }

    fn launch(&mut self, launch: &Launch, arguments: (u64, u32, u32)) -> Result<(), Failure> {
        let block = launch.block.unwrap_or_else(|| self.block_of(launch.threads));
        let blocks = launch.threads.div_ceil(block) as u32;
        let grid = LaunchConfig { grid_dim: (blocks, 1, 1), block_dim: (block as u32, 1, 1), shared_mem_bytes: 0 };
        let stream = self.stream.clone();
        let mut call = stream.launch_builder(self.kernel(&launch.kernel)?);
        call.arg(&arguments.0).arg(&arguments.1).arg(&arguments.2);
        let begun = Instant::now();
        // SAFETY: these are the arguments of the kernel, in its order. The buffers are those of the batch and its runs, and outlive the
        // launches; rooms and desks are zeros. Launches of one stream run one after the other; threads beyond the last place do
        // nothing.
        unsafe { call.launch(grid) }.map_err(refused("running the kernels"))?;
        if self.times.is_some() {
            self.wait()?;
        }
        if let Some(times) = &mut self.times {
            *times.entry(launch.kernel.clone()).or_default() += begun.elapsed().as_secs_f64();
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<(), Failure> {
        self.stream.synchronize().map_err(refused("running the kernels"))
    }

    fn report(&self) -> Option<String> {
        let times = self.times.as_ref()?;
        let all: f64 = times.values().sum();
        let line = |(kernel, seconds): (&String, &f64)| {
            format!("{kernel:<24}{seconds:>10.4} s {:>5.1} %", 100.0 * seconds / all)
        };
        Some(times.iter().map(line).collect::<Vec<_>>().join("\n"))
    }
}
