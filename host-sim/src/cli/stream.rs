//! `scphd-sim stream`.

use super::args::{PrecisionName, StreamArgs, Tuning};
use super::failure::Failure;
use super::outputs::{check_file, print_beside, write_file};
use super::source::{Found, tuned};
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
    let scans = args.scans.unwrap_or(usize::MAX);
    let scalar = match args.precision {
        PrecisionName::F32 => Scalar::F32,
        PrecisionName::F64 => Scalar::F64,
    };
    let stream = if args.source.as_os_str() == WORST_CASE {
        let Tuning { particles, samples, .. } = args.tuning;
        let (log, defaults) = worst_case(particles.unwrap_or(PARTICLES), samples.unwrap_or(SAMPLES), MEASUREMENTS);
        write(&log, &tuned(defaults, &args.tuning)?, seed, scalar, scans)
    } else {
        match Found::find(&args.source, args.scenario_seed.scenario_seed)? {
            Found::Planar(source) => {
                let log = source.log(seed)?;
                write(&log, &tuned(source.defaults(&log), &args.tuning)?, seed, scalar, scans)
            }
            Found::Underwater(source) => {
                let log = source.log(seed)?;
                let settings = source.tuned(&log, &args.tuning)?;
                write_underwater(&log, &settings, seed, scalar, scans).map_err(Failure::input)?
            }
        }
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
