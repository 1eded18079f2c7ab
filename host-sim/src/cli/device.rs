//! Runs on a GPU, or by an interpreter of its module.

use super::args::DeviceName;
use super::failure::Failure;
use scphd_filters::kind::Kind;
use scphd_filters::slam::Slam;
use scphd_log::dimensions::Planar;
use scphd_run::session::{self, Filter, Session};
use std::borrow::Cow;

/// The inputs of a run: log, settings and seed.
pub type Input<'l, K> = (Cow<'l, <K as Kind>::Log>, <K as Kind>::Settings, u64);

/// What runs, and how.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "without the feature there is no device"))]
pub struct On {
    pub filter: Filter,
    /// Number of threads that prepare inputs and score outputs.
    pub threads: usize,
    /// Whether the predicted poses are needed.
    pub predicted: bool,
}

/// The session of a run on a device.
pub fn session<K: Kind>(
    slam: &mut dyn Slam<K>,
    filter: Filter,
    (log, settings, seed): &Input<'_, K>,
) -> Result<Session<K>, Failure> {
    let mut session = session::run_of::<K>(slam, log, settings, filter, *seed)?;
    // The measured times are those of the replay.
    (session.summary.scan_us_mean, session.summary.scan_us_p99) = (None, None);
    Ok(session)
}

#[cfg(not(feature = "gpu"))]
pub fn run<'l, R: Send>(
    _: DeviceName,
    _: On,
    _: usize,
    _: impl Fn(usize) -> Result<Input<'l, Planar>, Failure> + Sync,
    _: impl Fn(usize, &mut dyn Slam<Planar>, &Input<'l, Planar>) -> Result<R, Failure> + Sync,
) -> Result<Vec<R>, Failure> {
    Err(Failure::input("--device: not in this build; `cargo run --release --features gpu --` has it"))
}

/// Runs a filter with all inputs on a device, and passes each run as a filter to `finish`.
#[cfg(feature = "gpu")]
pub fn run<'l, R: Send>(
    device: DeviceName,
    On { filter, threads, predicted }: On,
    runs: usize,
    input: impl Fn(usize) -> Result<Input<'l, Planar>, Failure> + Sync,
    finish: impl Fn(usize, &mut dyn Slam<Planar>, &Input<'l, Planar>) -> Result<R, Failure> + Sync,
) -> Result<Vec<R>, Failure> {
    use super::failure::{notice, warning};
    use scphd_gpu::{Asked, Cuda, Interpreted, MODULES, Machine, Played, run_all};

    let folder = std::env::var_os("SCPHD_GPU_MODULES").unwrap_or_else(|| MODULES.into());
    let mut device: Box<dyn Machine> = match device {
        DeviceName::Cuda => Box::new(Cuda::open(folder.as_ref(), false)?),
        DeviceName::Ptx => Box::new(Interpreted::open(folder.as_ref(), false)?),
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let finish = |run, mut played: Played<'_>, input: &Input<'l, Planar>| finish(run, &mut played, input);
    let asked = Asked { digest_every: 0, predicted };
    let (took, all) = run_all(&mut *device, &pool, (filter, asked), runs, input, finish)?;
    let ([short, scans], name) = (took.short, device.name());
    if short > 0 {
        warning(format_args!(
            "warning: {short} runs had too little memory on {name} in {scans} scans: the host may differ"
        ));
    }
    notice(format_args!("{name}: {runs} runs, {} at once, in {:.3} s", took.resident, took.launched_s));
    Ok(all)
}

#[cfg(feature = "gpu")]
impl From<scphd_gpu::Failure> for Failure {
    fn from(failure: scphd_gpu::Failure) -> Self {
        Self::input(format_args!("--device: {failure}"))
    }
}
