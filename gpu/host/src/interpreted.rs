//! A device that interprets the module on the host, instruction by instruction, with `scphd-ptx`.

use crate::device::{Launch, Machine, module};
use crate::failure::Failure;
use scphd_ptx::{Counts, Grid, Memory, Module};
use std::collections::BTreeMap;
use std::path::Path;

/// The module, and the counts of its launches.
#[derive(Debug)]
pub struct Interpreted {
    module: Module,
    /// Memory that contains only the variables of the module.
    fresh: Memory,
    memory: Memory,
    name: String,
    /// The counts of every kernel since the buffers were freed.
    taken: BTreeMap<String, Counts>,
}

/// Greatest number of threads of a block.
const BLOCK: usize = 32;

impl Interpreted {
    /// Reads the module; with `watch`, it is an error if two threads of a launch use the same byte and one of them writes it.
    pub fn open(folder: &Path, watch: bool) -> Result<Self, Failure> {
        let (text, path) = module(folder)?;
        let mut fresh = Memory::default();
        if watch {
            fresh.watch();
        }
        let module = Module::read(&text, &mut fresh).map_err(|error| Failure::of(path.display(), error))?;
        let name = format!("interpreted, {}", path.display());
        Ok(Self { module, memory: fresh.clone(), fresh, name, taken: BTreeMap::new() })
    }
}

impl Machine for Interpreted {
    fn name(&self) -> &str {
        &self.name
    }

    fn clear(&mut self) {
        self.memory = self.fresh.clone();
        self.taken.clear();
    }

    fn upload(&mut self, bytes: &[u8]) -> Result<u64, Failure> {
        Ok(self.memory.allocate(bytes.to_vec()))
    }

    fn zeros(&mut self, bytes: usize) -> Result<u64, Failure> {
        Ok(self.memory.allocate(vec![0; bytes]))
    }

    fn download(&mut self, address: u64, to: &mut [u8]) -> Result<(), Failure> {
        to.copy_from_slice(&self.memory.bytes(address)[..to.len()]);
        Ok(())
    }

    fn launch(&mut self, launch: &Launch, (address, scan, digest_every): (u64, u32, u32)) -> Result<(), Failure> {
        let block = launch.block.unwrap_or(BLOCK.min(launch.threads));
        let grid = Grid { blocks: launch.threads.div_ceil(block) as u32, block: block as u32 };
        let arguments = [address, scan.into(), digest_every.into()];
        let counts = self.module.launch(&launch.kernel, grid, &arguments, &mut self.memory);
        let counts = counts.map_err(|error| Failure::of(&launch.kernel, error))?;
        let taken = self.taken.entry(launch.kernel.clone()).or_default();
        *taken = taken.and(counts);
        Ok(())
    }

    fn report(&self) -> Option<String> {
        let mut table = format!("{:<24}{:>15}{:>15}", "instructions of", "all warps", "longest warp");
        for (kernel, Counts { warp_instructions, longest_warp }) in &self.taken {
            table += &format!("\n{kernel:<24}{warp_instructions:>15}{longest_warp:>15}");
        }
        Some(table)
    }
}
