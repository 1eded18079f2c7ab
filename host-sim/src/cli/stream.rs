//! `scphd-sim stream`.

use super::args::{PrecisionName, StreamArgs, Tuning};
use super::failure::Failure;
use super::offer::Offer;
use super::outputs::{check_file, print_beside, write_file};
use super::source::{Found, Source, either, tuned};
use scphd_boards::stream::{Recorded, Stream, worst_case, worst_case_joint};
use scphd_filters::settings::Origins;
use scphd_log::dimensions::Planar;
use scphd_stream::Scalar;
use scphd_stream::planar::MEASUREMENTS;

/// Sources that are neither a scenario nor a log: for a filter with a mixture for each particle, and for a joint map.
const WORST_CASE: &str = "worst-case";
const WORST_CASE_JOINT: &str = "worst-case-joint";
/// Default numbers of particles and samples for them: the capacities of the firmware.
const PARTICLES: usize = 32;
const SAMPLES: usize = 2;

/// Writes the stream and prints a summary.
pub fn stream(args: StreamArgs) -> Result<(), Failure> {
    check_file("FILE", &args.file)?;
    let seed = args.seed.seed;
    let scans = args.scans.unwrap_or(usize::MAX);
    let scalar = match args.precision {
        PrecisionName::F32 => Scalar::F32,
        PrecisionName::F64 => Scalar::F64,
    };
    let is_of_joint = args.source.as_os_str() == WORST_CASE_JOINT;
    let filter = if is_of_joint { Recorded::Joint } else { args.filter.recorded() };
    let stream = if is_of_joint || args.source.as_os_str() == WORST_CASE {
        let Tuning { particles, samples, .. } = args.tuning;
        let (log, defaults) = if is_of_joint {
            worst_case_joint(MEASUREMENTS)
        } else {
            worst_case(particles.unwrap_or(PARTICLES), samples.unwrap_or(SAMPLES), MEASUREMENTS)
        };
        let settings = tuned::<Planar>(defaults, &mut Origins::default(), &log, &args.tuning, &[])?;
        let stream = Planar::stream(&log, &settings, filter, seed, scalar, scans).map_err(Failure::input)?;
        recorded::<Planar>(stream, &args, scalar)?
    } else {
        let found = Found::find(&args.source, args.scenario_seed.scenario_seed)?;
        either!(found, source => of(&source, &args, filter, scalar, scans)?)
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

/// The stream of a log or scenario.
fn of<K: Offer>(
    source: &Source<K>,
    args: &StreamArgs,
    filter: Recorded,
    scalar: Scalar,
    scans: usize,
) -> Result<Stream, Failure> {
    let log = source.log(args.seed.seed)?;
    let settings = source.tuned(&log, &args.tuning, &[])?;
    let stream = K::stream(&log, &settings, filter, args.seed.seed, scalar, scans).map_err(Failure::input)?;
    recorded::<K>(stream, args, scalar)
}

/// The stream with snapshots, if requested.
fn recorded<K: Offer>(stream: Stream, args: &StreamArgs, scalar: Scalar) -> Result<Stream, Failure> {
    let Some(every) = args.snapshot_every else { return Ok(stream) };
    K::with_snapshots(stream, scalar, every).map_err(Failure::input)
}
