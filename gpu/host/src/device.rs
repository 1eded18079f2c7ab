//! Devices that run the threads of a batch: what each of them can do, and the launches of a batch in their order.

use crate::batch::{Batch, Sort};
use bytemuck::{Pod, Zeroable};
use scphd_gpu_kernels::{
    Feature, Filters, HELPERS, Joint, LargeMemory, Launches, Memory, Places, ScanResult, Stage, Status, bytes, parts,
    streams, words,
};
use std::path::PathBuf;
use std::time::Instant;

/// The outputs of a batch.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// How each run ended.
    pub statuses: Vec<Status>,
    /// The results of all scans.
    pub results: Vec<ScanResult>,
    /// The estimated features of all runs.
    pub features: Vec<Feature>,
    /// Wall time of all launches except those of digests, without copies, s.
    pub launched_s: f64,
}

impl Outcome {
    /// The outputs before the first launch: zeros.
    pub(crate) fn untouched(batch: &Batch) -> Self {
        Self {
            statuses: vec![Status::zeroed(); batch.runs.len()],
            results: vec![ScanResult::zeroed(); batch.scans.len()],
            features: vec![Feature::zeroed(); batch.features()],
            launched_s: 0.0,
        }
    }
}

/// Why a device does not work.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// There is no device, because there is no driver.
    #[error("no CUDA driver (no libcuda on this machine)")]
    NoDriver,
    /// The driver has found no device.
    #[error("no CUDA device: {0}")]
    NoDevice(String),
    /// The module cannot be read.
    #[error("{path}: {why}", path = .path.display())]
    Module {
        /// The file or folder of the module.
        path: PathBuf,
        /// The reason.
        why: String,
    },
    /// The driver, or the interpreter, has refused a request.
    #[error("{doing}: {why}")]
    Refused {
        /// The request.
        doing: &'static str,
        /// The reason.
        why: String,
    },
}

/// A kernel: its name, its threads and its function.
#[derive(Debug, Clone)]
pub struct Launch {
    pub(crate) kernel: String,
    places: Places,
    count: fn(Places, usize, usize) -> usize,
    /// Where it is among the launches of its kind, and the function that runs one of them.
    at: [usize; 2],
    run: unsafe fn([usize; 2], usize, u64, u32, u32),
}

/// Runs the function of one thread of a launch on the host.
///
/// # Safety
/// As of [`Stage::run`], with the address of the buffers of the host.
unsafe fn run<K: Launches>([list, at]: [usize; 2], place: usize, filters: u64, scan: u32, digest_every: u32) {
    // SAFETY: the caller guarantees it.
    unsafe { K::LAUNCHES[list][at].run(place, &*(filters as *const Filters<K>), scan, digest_every) }
}

impl Launch {
    fn of<K: Launches>(at: [usize; 2]) -> Self {
        let Stage { name, places, .. } = K::LAUNCHES[at[0]][at[1]];
        Self { kernel: format!("{}_{name}", K::NAME), places, count: Places::count::<K>, at, run: run::<K> }
    }

    /// Number of threads for a batch, and that of a block if it is fixed.
    pub(crate) fn threads(&self, batch: &Batch) -> (usize, Option<usize>) {
        let [particles, samples] = batch.most();
        let places = batch.runs.len() * (self.count)(self.places, particles, samples);
        if self.places == Places::Leader { (places * (HELPERS + 1), Some(HELPERS + 1)) } else { (places, None) }
    }

    /// Runs the function of one thread on the host.
    ///
    /// # Safety
    /// As of [`Stage::run`], with the address of the buffers of the host.
    pub(crate) unsafe fn run(&self, place: usize, filters: u64, scan: u32, digest_every: u32) {
        // SAFETY: the caller guarantees it.
        unsafe { (self.run)(self.at, place, filters, scan, digest_every) }
    }
}

/// The kernels of a sort of filters.
#[derive(Debug)]
pub struct Kernels {
    /// The one that writes the bytes of the buffers' elements, and what it would write on the host.
    pub(crate) bytes: (String, [u64; 7]),
    words: fn(usize, usize) -> usize,
    /// Those that start the filters, those of a prediction, those of a scan, and that of a digest.
    launches: [Vec<Launch>; 4],
}

impl Kernels {
    fn of<K: Launches>() -> Self {
        let bytes = (format!("{}_bytes", K::NAME), bytes::<K>());
        let list = |list: usize| (0..K::LAUNCHES[list].len()).map(|at| Launch::of::<K>([list, at])).collect();
        Self { bytes, words: words::<K>, launches: std::array::from_fn(list) }
    }

    fn of_sort(sort: Sort) -> Self {
        match sort {
            Sort::Many => Self::of::<Memory>(),
            Sort::Large => Self::of::<LargeMemory>(),
            Sort::Joint => Self::of::<Joint>(),
        }
    }
}

/// The memory and the launches of a device. Addresses are those of the device.
pub trait Machine {
    /// Name of the device.
    fn name(&self) -> &str;

    /// Bytes of one room, sight, desk, draft, stream and part, and the greatest alignment, in the layout of the device.
    fn bytes(&mut self, kernels: &Kernels) -> Result<[u64; 7], DeviceError>;

    /// Frees all buffers.
    fn clear(&mut self);

    /// Bytes that are free, if there is a limit.
    fn free(&self) -> Result<Option<usize>, DeviceError> {
        Ok(None)
    }

    /// Makes a buffer with these bytes.
    fn upload(&mut self, bytes: &[u8]) -> Result<u64, DeviceError>;

    /// Makes a buffer of zeros.
    fn zeros(&mut self, bytes: usize) -> Result<u64, DeviceError>;

    /// Copies the start of a buffer back.
    fn download(&mut self, address: u64, to: &mut [u8]) -> Result<(), DeviceError>;

    /// Starts a kernel, with the address of the filters, the scan and the number of scans between two digests as arguments.
    fn launch(&mut self, launch: &Launch, batch: &Batch, arguments: (u64, u32, u32)) -> Result<(), DeviceError>;

    /// Waits for all launches, if they do not end before `launch` returns.
    fn wait(&mut self) -> Result<(), DeviceError> {
        Ok(())
    }

    /// A report on the launches since the buffers were freed, if there is one.
    fn report(&self) -> Option<String> {
        None
    }
}

/// Greatest alignment of a buffer's elements: the least with which devices allocate memory.
const ALIGNMENT: u64 = 256;

/// Number of runs at a time if there is no limit of the memory.
const RESIDENT: usize = 64;

impl dyn Machine + '_ {
    /// Bytes of all rooms, sights, desks, drafts, streams, parts and words of a batch.
    fn buffers(&mut self, batch: &Batch, kernels: &Kernels) -> Result<[usize; 7], DeviceError> {
        let [room, sight, desk, draft, stream, part, alignment] = self.bytes(kernels)?;
        if room == 0 || alignment > ALIGNMENT {
            let doing = "asking the module for the bytes of its buffers";
            return Err(DeviceError::Refused { doing, why: format!("{room} bytes, alignment {alignment}") });
        }
        let [particles, samples] = batch.most();
        let candidates = particles * samples;
        let of = |bytes: u64, count: usize| bytes as usize * count;
        Ok([
            of(room, 1),
            of(sight, candidates),
            of(desk, particles),
            of(draft, particles),
            of(stream, streams(candidates)),
            of(part, parts(candidates)),
            size_of::<u32>() * (kernels.words)(particles, samples),
        ]
        .map(|each| each * batch.runs.len()))
    }

    /// Bytes of memory for one run of the batch, without inputs and results.
    pub(crate) fn run_bytes(&mut self, batch: &Batch) -> Result<usize, DeviceError> {
        Ok(self.buffers(batch, &Kernels::of_sort(batch.sort))?.iter().sum::<usize>() / batch.runs.len().max(1))
    }

    /// Number of runs at the same time, if each needs this memory: as many as fit into nine tenths of the free memory. The rest is
    /// for the stacks of all threads.
    pub(crate) fn resident(&self, bytes_a_run: usize) -> Result<usize, DeviceError> {
        Ok(self.free()?.map_or(RESIDENT, |free| (free / 10 * 9 / bytes_a_run.max(1)).max(1)))
    }

    /// Processes all scans of every run of the batch, launch by launch, with a digest after every `digest_every` scans and after the
    /// last.
    pub fn run(&mut self, batch: &Batch, digest_every: u32) -> Result<Outcome, DeviceError> {
        fn bytes<T: Pod>(things: &[T]) -> &[u8] {
            bytemuck::cast_slice(things)
        }
        let mut outcome = Outcome::untouched(batch);
        let kernels = Kernels::of_sort(batch.sort);
        let buffers = self.buffers(batch, &kernels)?;
        self.clear();
        // The addresses of the buffers, and the counts, in the order of the fields of `Filters`.
        let mut fields = Vec::new();
        let inputs = [bytes(&batch.runs), bytes(&batch.scans), bytes(&batch.predictions), bytes(&batch.measurements)];
        for input in inputs {
            fields.push(self.upload(input)?);
        }
        let Outcome { statuses, results, features, .. } = &outcome;
        let outputs = [bytes(statuses), bytes(results), bytes(features)].map(<[u8]>::len);
        for bytes in buffers.into_iter().chain(outputs) {
            fields.push(self.zeros(bytes)?);
        }
        let [particles, samples] = batch.most();
        fields.extend([batch.runs.len(), particles, samples].map(|count| count as u64));
        let filters = self.upload(bytes(&fields))?;
        let [starting, predicting, scanning, digest] = &kernels.launches;
        let start = |machine: &mut Self, launches: &[Launch], scan| {
            launches.iter().try_for_each(|launch| machine.launch(launch, batch, (filters, scan, digest_every)))
        };
        start(self, starting, 0)?;
        self.wait()?;
        let (started, mut digests_s) = (Instant::now(), 0.0);
        for scan in 0..batch.most_scans() {
            for _ in 0..batch.predictions_before(scan) {
                start(self, predicting, scan)?;
            }
            start(self, scanning, scan)?;
            if batch.asks_for_digest(scan, digest_every) {
                self.wait()?;
                let begun = Instant::now();
                start(self, digest, scan)?;
                self.wait()?;
                digests_s += begun.elapsed().as_secs_f64();
            }
        }
        self.wait()?;
        outcome.launched_s = started.elapsed().as_secs_f64() - digests_s;
        let Outcome { statuses, results, features, .. } = &mut outcome;
        let outputs: [&mut [u8]; 3] =
            [bytemuck::cast_slice_mut(statuses), bytemuck::cast_slice_mut(results), bytemuck::cast_slice_mut(features)];
        for (&address, to) in fields[inputs.len() + buffers.len()..].iter().zip(outputs) {
            self.download(address, to)?;
        }
        Ok(outcome)
    }
}
