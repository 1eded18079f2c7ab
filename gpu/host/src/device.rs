//! Devices that run the threads of a batch: what each of them can do, and the launches of a batch in their order.

use crate::batch::{Batch, Sort};
use crate::failure::Failure;
use bytemuck::{Pod, Zeroable};
use scphd_gpu_kernels::{
    Feature, HELPERS, JOINT_LAUNCHES, LAUNCHES, LargeMemory, Layout, Lists, Memory, Particles, Places, Prediction, Run,
    Scan, ScanResult, Status,
};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The outputs of a batch.
#[derive(Debug)]
pub struct Outcome {
    pub statuses: Vec<Status>,
    pub results: Vec<ScanResult>,
    pub features: Vec<Feature>,
    /// Wall time of all launches except those of digests, without copies, s.
    pub launched_s: f64,
}

/// What is computed besides the outputs of all scans.
#[derive(Debug, Clone, Copy, Default)]
pub struct Asked {
    /// Number of scans between two digests; 0 for one after the last scan only.
    pub digest_every: u32,
    /// Whether the predicted poses are estimated.
    pub predicted: bool,
}

pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let built = "`cargo xtask module` builds the module";
    std::fs::read(path).map_err(|error| Failure::of(path.display(), format_args!("{error}; {built}")))
}

/// The module of a folder as PTX text, which the driver assembles for its card when it loads it; and its path.
pub fn module(folder: &Path) -> Result<(String, PathBuf), Failure> {
    let path = folder.join("scphd.ptx");
    let said = String::from_utf8(read(&path)?).ok().filter(|said| !said.contains('\0'));
    said.ok_or_else(|| Failure::of(path.display(), "is no text")).map(|said| (said, path))
}

#[derive(Debug)]
pub struct Launch {
    pub kernel: String,
    pub threads: usize,
    /// Number of threads of a block, if it is fixed.
    pub block: Option<usize>,
}

/// The memory and the launches of a device. Addresses are those of the device.
pub trait Machine {
    fn name(&self) -> &str;

    fn clear(&mut self);

    /// Bytes that are free, if there is a limit.
    fn free(&self) -> Result<Option<usize>, Failure> {
        Ok(None)
    }

    fn upload(&mut self, bytes: &[u8]) -> Result<u64, Failure>;

    fn zeros(&mut self, bytes: usize) -> Result<u64, Failure>;

    /// Copies the start of a buffer back.
    fn download(&mut self, address: u64, to: &mut [u8]) -> Result<(), Failure>;

    /// Starts a kernel with these arguments.
    fn launch(&mut self, launch: &Launch, arguments: (u64, u32, u32)) -> Result<(), Failure>;

    /// Waits for all launches, if they do not end before `launch` returns.
    fn wait(&mut self) -> Result<(), Failure> {
        Ok(())
    }

    /// A report on the launches since the buffers were freed, if there is one.
    fn report(&self) -> Option<String> {
        None
    }
}

/// Prefix of the names of kernels, launches, and numbers of pages.
fn launches(sort: Sort) -> (&'static str, Lists, [usize; 2]) {
    match sort {
        Sort::Many => ("scphd_many", LAUNCHES, Memory::PAGES),
        Sort::Large => ("scphd_large", LAUNCHES, LargeMemory::PAGES),
        Sort::Joint => ("scphd_joint", JOINT_LAUNCHES, [0; 2]),
    }
}

impl dyn Machine + '_ {
    /// The memory and the threads of a filter of the batch.
    fn layout(&mut self, batch: &Batch) -> Result<Layout, Failure> {
        let kernel = format!("{}_layout", launches(batch.sort).0);
        let mut layout = Layout::zeroed();
        let [particles, samples] = batch.most().map(|most| most as u32);
        let told = self.upload(bytemuck::bytes_of(&layout))?;
        self.launch(&Launch { kernel, threads: 1, block: None }, (told, particles, samples))?;
        self.download(told, bytemuck::bytes_of_mut(&mut layout))?;
        if layout.buffers[0] == 0 {
            return Err(Failure::of("the layout that the module reports", format!("{layout:?}")));
        }
        Ok(layout)
    }

    /// Bytes of memory for a run, without inputs and results.
    pub(crate) fn run_bytes(&mut self, batch: &Batch) -> Result<usize, Failure> {
        Ok(self.layout(batch)?.buffers.iter().sum::<u64>() as usize)
    }

    /// Processes all scans of every run of the batch, launch by launch.
    pub fn run(&mut self, batch: &Batch, Asked { digest_every, predicted }: Asked) -> Result<Outcome, Failure> {
        fn bytes<T: Pod>(things: &[T]) -> &[u8] {
            bytemuck::cast_slice(things)
        }
        let runs = batch.runs.len();
        let mut statuses = vec![Status::zeroed(); runs];
        let mut results = vec![ScanResult::zeroed(); batch.scans.len()];
        let mut features = vec![Feature::zeroed(); batch.features()];
        let Layout { buffers, .. } = self.layout(batch)?;
        self.clear();
        let scans = self.upload(bytes(&batch.scans))?;
        let predictions = self.upload(bytes(&batch.predictions))?;
        let measurements = self.upload(bytes(&batch.measurements))?;
        let of_runs = self.upload(bytes(&batch.runs))?;
        let own = buffers.iter().map(|each| self.zeros(*each as usize * runs)).collect::<Result<Vec<_>, _>>()?;
        let outputs = [bytes(&statuses), bytes(&results), bytes(&features)].map(<[u8]>::len);
        let outputs = outputs.into_iter().map(|bytes| self.zeros(bytes)).collect::<Result<Vec<_>, _>>()?;
        let [particles, samples] = batch.most();
        // The data of every filter, in the order of the kernels' struct.
        let mut places: Vec<u64> = Vec::new();
        for (place, run) in (0..).zip(&batch.runs) {
            let at = |address: u64, size: usize, index: u32| address + size as u64 * u64::from(index);
            places.extend([
                at(of_runs, size_of::<Run>(), place),
                at(scans, size_of::<Scan>(), run.first_scan),
                at(predictions, size_of::<Prediction>(), run.first_prediction),
                at(measurements, size_of::<[f32; 2]>(), run.first_measurement),
            ]);
            places.extend(own.iter().zip(buffers).map(|(address, bytes)| address + bytes * u64::from(place)));
            places.extend([
                at(outputs[0], size_of::<Status>(), place),
                at(outputs[1], size_of::<ScanResult>(), run.first_scan),
                at(outputs[2], size_of::<Feature>(), run.first_feature),
                particles as u64,
            ]);
        }
        let first = self.upload(bytes(&places))?;
        let filters = self.upload(bytes(&[first, runs as u64, particles as u64, samples as u64]))?;
        let (prefix, lists, pages) = launches(batch.sort);
        let launch = |&(name, places): &(&str, Places)| Launch {
            kernel: format!("{prefix}_{name}"),
            threads: runs * places.count(pages, particles, samples),
            block: (places == Places::Leader).then_some(HELPERS + 1),
        };
        let [starting, predicting, forecasting, scanning, digest] =
            lists.map(|list| list.iter().map(launch).collect::<Vec<_>>());
        let start = |machine: &mut Self, launches: &[Launch], scan| {
            launches.iter().try_for_each(|launch| machine.launch(launch, (filters, scan, digest_every)))
        };
        start(self, &starting, 0)?;
        self.wait()?;
        let (started, mut digests_s) = (Instant::now(), 0.0);
        for scan in 0..batch.most_scans() {
            for _ in 0..batch.predictions_before(scan) {
                start(self, &predicting, scan)?;
            }
            if predicted {
                start(self, &forecasting, scan)?;
            }
            start(self, &scanning, scan)?;
            if batch.asks_for_digest(scan, digest_every) {
                self.wait()?;
                let begun = Instant::now();
                start(self, &digest, scan)?;
                self.wait()?;
                digests_s += begun.elapsed().as_secs_f64();
            }
        }
        self.wait()?;
        let launched_s = started.elapsed().as_secs_f64() - digests_s;
        self.download(outputs[0], bytemuck::cast_slice_mut(&mut statuses))?;
        self.download(outputs[1], bytemuck::cast_slice_mut(&mut results))?;
        self.download(outputs[2], bytemuck::cast_slice_mut(&mut features))?;
        Ok(Outcome { statuses, results, features, launched_s })
    }
}
