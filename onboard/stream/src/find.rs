//! Finds snapshots in a stream without its beginning.

use crate::bytes::Bytes;
use crate::front::MAGIC;
use crate::head::Head;
use crate::kind::Kind;
use crate::reader::Reader;

/// Position of the first snapshot at or behind a position whose head can be read. The position may be anywhere in the stream, and
/// damage before the snapshot does not matter. The bytes from there on are a stream.
///
/// ```
/// use scphd_stream::planar::{Odometry, Planar};
/// use scphd_stream::{Header, Part, Reader, Writer, find_snapshot};
///
/// let mut log = Vec::new();
/// let mut writer = Writer::start(&Header::<Planar>::EMPTY, |bytes: &[u8]| Ok::<(), ()>(log.extend_from_slice(bytes)))?;
/// writer.predict(&Odometry { control: [1.0, 0.1, 0.0], dt_s: 0.05 })?;
/// writer.snapshot(&[Part::Filter], 0x1234)?;
/// // Whatever the filter saves.
/// writer.slice(Part::Filter, b"...")?;
/// writer.end()?;
/// let torn = &log[100..];
/// let at = find_snapshot::<Planar>(torn, 0).unwrap();
/// let reader = Reader::<Planar>::open(&torn[at..]).unwrap();
/// assert_eq!(reader.snapshot().unwrap().mark().digest, 0x1234);
/// assert_eq!(find_snapshot::<Planar>(torn, at + 1), None);
/// # Ok::<(), ()>(())
/// ```
#[must_use]
pub fn find_snapshot<K: Kind>(bytes: &[u8], from: usize) -> Option<usize> {
    let places = bytes.get(from..)?.windows(MAGIC.len()).enumerate().filter(|(_, window)| *window == MAGIC);
    let mut heads = places.map(|(place, _)| from + place);
    heads.find(|&place| {
        let begins = |bytes| Head::<K>::take(&mut Bytes(bytes)).is_ok_and(|head| head.mark().is_some());
        bytes.get(place..).is_some_and(begins)
    })
}

/// Position of the next complete snapshot at or behind a position, otherwise as [`find_snapshot`].
#[must_use]
pub fn find_whole_snapshot<K: Kind>(bytes: &[u8], mut from: usize) -> Option<usize> {
    loop {
        let place = find_snapshot::<K>(bytes, from)?;
        let snapshot = Reader::<K>::open(bytes.get(place..)?).ok().and_then(|reader| reader.snapshot());
        if snapshot.is_some_and(|snapshot| snapshot.is_whole()) {
            return Some(place);
        }
        from = place + 1;
    }
}
