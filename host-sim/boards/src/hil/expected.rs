//! The results of the host's filter for a stream.

use scphd_filters::slam::contract::{Refusal, refusal};
use scphd_stream::planar::{BlackBox, BlackBoxJoint, Planar};
use scphd_stream::{Aboard, Monitor, Reader, ScanCost, Seen, replay};

use crate::stream::replaying;

/// Digest after a scan; `None` if the filter refused it.
pub type Expected = Option<u64>;

/// The digest after every scan, by the same filter as on the target, in single precision.
pub fn expected(stream: &[u8]) -> Result<Vec<Expected>, Refusal> {
    if Reader::<Planar>::open(stream).map_err(refusal)?.is_of_joint_map() {
        replaying(|| digests::<BlackBoxJoint>(stream))
    } else {
        replaying(|| digests::<BlackBox>(stream))
    }
}

fn digests<A: Aboard<f32>>(stream: &[u8]) -> Result<Vec<Expected>, Refusal> {
    let (mut memory, mut digests) = (Box::new(A::MEMORY), Digests(Vec::new()));
    let totals = replay::<A, f32>(stream, &mut memory, u32::MAX, &mut digests).map_err(refusal)?;
    digests.0.resize(totals.scans as usize, None);
    Ok(digests.0)
}

struct Digests(Vec<Expected>);

impl Monitor for Digests {
    fn scanned(&mut self, cost: &ScanCost, _: &Seen, digest: u64) {
        self.0.resize(cost.scan as usize, None);
        self.0.push(Some(digest));
    }

    /// Refused records are skipped, as on a vehicle and on the target.
    fn refused(&mut self, _: u32, _: &scphd_stream::Refusal) -> bool {
        true
    }
}
