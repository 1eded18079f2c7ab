//! Streams with snapshots, as recorded by a vehicle with a black box.

use super::entry::Stream;
use scphd_filters::slam::contract::{Refusal, refusal};
use scphd_stream::{Aboard, Kind, Reader, RerecordError, Saves, Scalar, planar, rerecord, underwater};
use scphd_vehicle::Filter;
use std::convert::Infallible;

/// Stack of the thread that replays, bytes: an unoptimised build creates the memory on the stack before moving it to the heap,
/// several times.
const STACK_BYTES: usize = 64 << 20;

/// The filter of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recorded {
    /// The filter with a mixture for each particle.
    Mixture,
    /// The filter with a joint map.
    Joint,
}

impl Stream {
    /// The stream of a vehicle in the plane with a snapshot after every `every` scans, in numbers of this type.
    pub fn with_snapshots(self, scalar: Scalar, every: u32) -> Result<Self, Refusal> {
        match scalar {
            Scalar::F32 => by_filter::<f32>(self, every),
            #[cfg(feature = "f64")]
            Scalar::F64 => by_filter::<f64>(self, every),
            #[cfg(not(feature = "f64"))]
            Scalar::F64 => Err(scphd_filters::slam::contract::not_built()),
        }
    }

    /// The same for a vehicle under water.
    pub fn with_snapshots_under_water(self, scalar: Scalar, every: u32) -> Result<Self, Refusal> {
        match scalar {
            Scalar::F32 => recorded::<underwater::BlackBox, f32>(self, every),
            #[cfg(feature = "f64")]
            Scalar::F64 => recorded::<underwater::BlackBox, f64>(self, every),
            #[cfg(not(feature = "f64"))]
            Scalar::F64 => Err(scphd_filters::slam::contract::not_built()),
        }
    }
}

/// By the black box with the optional parts of the filter in the head.
fn by_filter<T: scphd::Real>(stream: Stream, every: u32) -> Result<Stream, Refusal> {
    let header = Reader::<planar::Planar>::open(&stream.bytes).map_err(refusal)?.header();
    let Filter::Joint(joint) = header.description::<f64>().map_err(refusal)?.filter else {
        return recorded::<planar::BlackBox, T>(stream, every);
    };
    match (joint.hypotheses.is_some(), joint.odometry.is_some(), joint.movers.is_some()) {
        (true, ..) => recorded::<planar::BlackBoxHypotheses, T>(stream, every),
        (_, true, _) => recorded::<planar::BlackBoxCalibrated, T>(stream, every),
        (_, _, true) => recorded::<planar::BlackBoxMovers, T>(stream, every),
        _ => recorded::<planar::BlackBoxJoint, T>(stream, every),
    }
}

fn recorded<A, T>(stream: Stream, every: u32) -> Result<Stream, Refusal>
where
    T: scphd::Real,
    A: Aboard<T, Kind: Kind>,
    for<'m> A::Filter<'m>: Saves<A::Kind>,
{
    let plain = &stream.bytes;
    let work = || -> Result<Vec<u8>, RerecordError<Infallible>> {
        let (mut memory, mut bytes) = (Box::new(A::MEMORY), Vec::new());
        rerecord::<A, T, _>(plain, &mut memory, every, |piece| {
            bytes.extend_from_slice(piece);
            Ok(())
        })?;
        Ok(bytes)
    };
    let bytes = replaying(|| work().map_err(refusal))?;
    Ok(Stream { bytes, ..stream })
}

/// The result of a replay in a thread with stack for it.
pub(crate) fn replaying<R: Send>(work: impl FnOnce() -> Result<R, Refusal> + Send) -> Result<R, Refusal> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, work);
        let thread = thread.map_err(|error| refusal(format_args!("cannot start a thread: {error}")))?;
        thread.join().map_err(|_| refusal("the replay panicked"))?
    })
}
