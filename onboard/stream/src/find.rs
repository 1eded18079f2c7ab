//! How to find snapshots in a stream of which the beginning is not at hand.

use crate::bytes::Bytes;
use crate::front::MAGIC;
use crate::head::Head;
use crate::header::Header;
use crate::kind::Kind;
use crate::reader::Reader;

/// Where the first snapshot at or behind a place begins whose head can be read, wherever in a stream that place is: what stands
/// before it, or is damaged, does not matter. From there on the bytes are a stream.
///
/// ```
/// use scphd_stream::planar::{Odometry, Planar};
/// use scphd_stream::{Header, Part, Reader, Writer, find_snapshot};
///
/// let mut log = Vec::new();
/// let mut writer = Writer::start(&Header::<Planar>::EMPTY, |bytes: &[u8]| Ok::<(), ()>(log.extend_from_slice(bytes)))?;
/// writer.predict(&Odometry { control: [1.0, 0.1], dt_s: 0.05 })?;
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
        let begins = |bytes| {
            Head::take::<K>(&mut Bytes(bytes)).is_some_and(|head| head.mark().is_some())
                && Header::<K>::decode(&mut Bytes(bytes)).is_ok()
        };
        bytes.get(place..).is_some_and(begins)
    })
}

/// The next snapshot at or behind a place of which all is there, as [`find_snapshot`] finds them.
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
