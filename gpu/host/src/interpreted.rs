//! A device that interprets the module on the host, instruction by instruction, with `scphd-ptx`.

use crate::batch::Batch;
use crate::cuda::Modules;
use crate::device::{DeviceError, Kernels, Launch, Machine};
use scphd_ptx::{Counts, Grid, LaunchError, Memory, Module};

/// The module, and the counts of its launches.
#[derive(Debug, Clone)]
pub struct Interpreted {
    module: Module,
    /// Memory that contains only the variables of the module.
    fresh: Memory,
    memory: Memory,
    block: u32,
    name: String,
    /// The counts of every kernel since the buffers were freed.
    taken: Vec<(String, Counts)>,
}

impl Interpreted {
    /// Reads the module, for blocks of this number of threads; with `watch`, it is an error if two threads of a launch use the same
    /// byte and one of them writes it.
    ///
    /// # Errors
    /// There is no module, or it contains something unknown.
    pub fn open(modules: &Modules, block: u32, watch: bool) -> Result<Self, DeviceError> {
        let (text, path) = modules.text()?;
        let mut fresh = Memory::default();
        if watch {
            fresh.watch();
        }
        let module = Module::read(&text, &mut fresh);
        let module = module.map_err(|error| DeviceError::Module { path: path.clone(), why: error.to_string() })?;
        let name = format!("interpreted, {}, {block} threads a block", path.display());
        Ok(Self { module, memory: fresh.clone(), fresh, block, name, taken: Vec::new() })
    }
}

fn stopped(error: LaunchError) -> DeviceError {
    DeviceError::Refused { doing: "executing the module", why: error.to_string() }
}

impl Machine for Interpreted {
    fn name(&self) -> &str {
        &self.name
    }

    fn bytes(&mut self, kernels: &Kernels) -> Result<[u64; 7], DeviceError> {
        let mut memory = self.fresh.clone();
        let mut numbers = [0_u64; 7];
        let told = memory.allocate(bytemuck::bytes_of(&numbers));
        let grid = Grid { blocks: 1, block: 1 };
        self.module.launch(&kernels.bytes.0, grid, &[told], &mut memory).map_err(stopped)?;
        bytemuck::bytes_of_mut(&mut numbers).copy_from_slice(memory.bytes(told));
        Ok(numbers)
    }

    fn clear(&mut self) {
        self.memory = self.fresh.clone();
        self.taken.clear();
    }

    fn upload(&mut self, bytes: &[u8]) -> Result<u64, DeviceError> {
        Ok(self.memory.allocate(bytes))
    }

    fn zeros(&mut self, bytes: usize) -> Result<u64, DeviceError> {
        Ok(self.memory.allocate_zeros(bytes))
    }

    fn download(&mut self, address: u64, to: &mut [u8]) -> Result<(), DeviceError> {
        to.copy_from_slice(&self.memory.bytes(address)[..to.len()]);
        Ok(())
    }

    fn launch(
        &mut self,
        launch: &Launch,
        batch: &Batch,
        (filters, scan, digest_every): (u64, u32, u32),
    ) -> Result<(), DeviceError> {
        let (threads, block) = launch.threads(batch);
        let block = block.map_or(self.block.min(threads.max(1) as u32), |block| block as u32);
        let grid = Grid { blocks: (threads as u32).div_ceil(block).max(1), block };
        let (kernel, arguments) = (launch.kernel.clone(), [filters, scan.into(), digest_every.into()]);
        let counts = self.module.launch(&kernel, grid, &arguments, &mut self.memory).map_err(stopped)?;
        match self.taken.iter_mut().find(|(known, _)| *known == kernel) {
            Some((_, of_kernel)) => *of_kernel = of_kernel.and(counts),
            None => self.taken.push((kernel, counts)),
        }
        Ok(())
    }

    /// The counts of every kernel.
    fn report(&self) -> Option<String> {
        let line = |(kernel, counts): &(String, Counts)| {
            let Counts { instructions, warp_instructions, longest_warp } = counts;
            format!("{kernel:<24}{instructions:>15}{warp_instructions:>15}{longest_warp:>15}")
        };
        let head = format!("{:<24}{:>15}{:>15}{:>15}", "kernel", "instructions", "of warps", "longest warp");
        Some([head].into_iter().chain(self.taken.iter().map(line)).collect::<Vec<_>>().join("\n"))
    }
}
