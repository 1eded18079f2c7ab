//! `scphd-sim stream`.

use super::args::{PrecisionName, StreamArgs, Tuning};
use super::failure::Failure;
use super::outputs::{check_file, print_beside, write_file};
use super::source::{Source, tuned};
use super::underwater;
use scphd_sim::stream::{worst_case, write, write_underwater};
use scphd_stream::Scalar;
use scphd_stream::planar::MEASUREMENTS;

/// The source that is neither a scenario nor a log.
const WORST_CASE: &str = "worst-case";
/// Its particles and samples where the arguments do not say: those that the firmware has room for.
const PARTICLES: usize = 32;
const SAMPLES: usize = 2;

/// Writes the stream and tells what is in it.
pub fn stream(args: StreamArgs) -> Result<(), Failure> {
    check_file("FILE", &args.file)?;
    let seed = args.seed.seed;
    let scenario_seed = args.scenario_seed.scenario_seed;
    let scans = args.scans.unwrap_or(usize::MAX);
    let scalar = match args.precision {
        PrecisionName::F32 => Scalar::F32,
        PrecisionName::F64 => Scalar::F64,
    };
    let stream = if let Some(source) = underwater::source(&args.source, scenario_seed)? {
        let log = source.log(seed)?;
        let settings = underwater::tuned(source.defaults(&log), &args.tuning)?;
        write_underwater(&log, &settings, seed, scalar, scans).map_err(Failure::input)?
    } else {
        let (log, defaults) = if args.source.as_os_str() == WORST_CASE {
            let Tuning { particles, samples, .. } = args.tuning;
            worst_case(particles.unwrap_or(PARTICLES), samples.unwrap_or(SAMPLES), MEASUREMENTS)
        } else {
            let source = Source::scenario_or_folder(&args.source, scenario_seed.unwrap_or(seed))?;
            let log = source.log(seed)?.into_owned();
            let defaults = source.defaults(&log);
            (log, defaults)
        };
        write(&log, &tuned(defaults, &args.tuning)?, seed, scalar, scans)
    };
    write_file("FILE", &args.file, &stream.bytes)?;
    let said = format!(
        "{}: {} scans of up to {} measurements, {} predictions, {} bytes",
        args.file.display(),
        stream.scans,
        stream.most_measurements,
        stream.predictions,
        stream.bytes.len()
    );
    print_beside(Some(&args.file), &said)
}
