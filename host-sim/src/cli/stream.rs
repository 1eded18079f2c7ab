//! `scphd-sim stream`.

use super::args::{PrecisionName, StreamArgs};
use super::failure::{Failure, print};
use super::source::{read, scenario_defaults, tuned};
use scphd_sim::output::atomic;
use scphd_sim::scenario::by_name;
use scphd_sim::settings::Settings;
use scphd_sim::stream::{worst_case, write};
use scphd_stream::{MEASUREMENTS, Scalar};

/// The source that is neither a scenario nor a log.
const WORST_CASE: &str = "worst-case";
/// Its particles and samples where the arguments do not say: those that the firmware has room for.
const PARTICLES: usize = 32;
const SAMPLES: usize = 2;

/// Writes the stream and tells what is in it.
pub fn stream(args: StreamArgs) -> Result<(), Failure> {
    let seed = args.seed.seed;
    let name = args.source.to_str().unwrap_or_default();
    let (log, defaults) = if name == WORST_CASE {
        worst_case(args.tuning.particles.unwrap_or(PARTICLES), args.tuning.samples.unwrap_or(SAMPLES), MEASUREMENTS)
    } else if let Some(log) = by_name(name, args.scenario_seed.scenario_seed.unwrap_or(seed)) {
        let defaults = scenario_defaults(name, &log);
        (log, defaults)
    } else {
        let log = read(&args.source)?;
        let defaults = Settings::for_log(&log);
        (log, defaults)
    };
    let settings = tuned(defaults, &args.tuning)?;
    let scalar = match args.precision {
        PrecisionName::F32 => Scalar::F32,
        PrecisionName::F64 => Scalar::F64,
    };
    let stream = write(&log, &settings, seed, scalar, args.scans.unwrap_or(usize::MAX));
    atomic::write(&args.file, &stream.bytes)
        .map_err(|error| Failure::input(format_args!("cannot write {}: {error}", args.file.display())))?;
    print(&format!(
        "{}: {} scans of up to {} measurements, {} predictions, {} bytes",
        args.file.display(),
        stream.scans,
        stream.most_measurements,
        stream.predictions,
        stream.bytes.len()
    ))
}
