//! Sinks and sources of snapshots in slices.

/// The end of the slice was reached in writing or reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the slice ends before the snapshot does")]
pub struct SliceEnd;

/// A sink for [`ScPhd::save`](crate::ScPhd::save) that fills a slice from its start.
pub fn into_slice(bytes: &mut [u8]) -> impl FnMut(&[u8]) -> Result<(), SliceEnd> {
    let mut at = 0_usize;
    move |chunk| {
        let end = at.saturating_add(chunk.len());
        let room = bytes.get_mut(at..end).ok_or(SliceEnd)?;
        room.iter_mut().zip(chunk).for_each(|(slot, &byte)| *slot = byte);
        at = end;
        Ok(())
    }
}

/// A source for [`ScPhd::restore`](crate::ScPhd::restore) that reads from a slice.
pub fn from_slice(bytes: &[u8]) -> impl FnMut(usize, &mut [u8]) -> Result<(), SliceEnd> {
    move |at, into| {
        let found = bytes.get(at..at.saturating_add(into.len())).ok_or(SliceEnd)?;
        into.iter_mut().zip(found).for_each(|(slot, &byte)| *slot = byte);
        Ok(())
    }
}
