//! The bytes of every set of capacities are enough, and not many more, on whatever target this is built for.

use crate::block::{ALIGNMENT, Block, Handle};
use crate::sets::{memories, table};
use crate::{
    scphd_bearing_detector, scphd_joint, scphd_plane, scphd_range_bearing_detector, scphd_sonar_detector, scphd_water,
};

macro_rules! fit {
    ($($choose:ident, $handle:ident {
        $($(#[doc = $about:literal])+ $name:ident = $number:literal, $bytes:literal bytes of $memory:ident;)+
    })+) => {
        $($(const _: () = {
            type Needed = Block<<$handle as Handle>::Inner, memories::$memory>;
            assert!(size_of::<Needed>() <= $bytes, concat!(stringify!($name), ": too few bytes"));
            assert!(size_of::<Needed>() * 17 / 16 + 256 >= $bytes, concat!(stringify!($name), ": too many bytes"));
            assert!(align_of::<Needed>() == ALIGNMENT && $bytes % ALIGNMENT == 0);
            assert!($number / 100 == <$handle as Handle>::KIND);
        };)+)+
    };
}

table!(fit);
