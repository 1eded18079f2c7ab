//! Checks at compile time that the bytes of every set are sufficient on the target, and not much more than necessary.

use crate::block::{ALIGNMENT, Block, Handle};
use crate::memory::{NoState, Seated};
use crate::sets::{self, Set, memories};
use crate::{scphd_description, scphd_slam, scphd_sonar_detector, scphd_water};

const fn fits<H: Handle, S>(set: &Set) {
    let needed = size_of::<Block<H::Inner, S>>();
    assert!(needed <= set.bytes, "too few bytes");
    assert!(needed * 17 / 16 + 256 >= set.bytes, "too many bytes");
    assert!(align_of::<Block<H::Inner, S>>() == ALIGNMENT && set.bytes.is_multiple_of(ALIGNMENT));
    assert!(set.number / 100 == H::KIND);
}

macro_rules! fit {
    ($($(#[doc = $about:literal])+ $name:ident = $number:literal, $bytes:literal bytes of $memory:ident: $start:ident, $resume:ident, $services:ident;)+) => {
        $(const _: () = fits::<scphd_slam, Seated<memories::$memory>>(&sets::$name);)+
    };
}
sets::table!(fit);

const _: () = fits::<scphd_water, memories::WaterInformed16>(&sets::WATER_INFORMED_16);
const _: () = fits::<scphd_sonar_detector, memories::Sonar64>(&sets::SONAR_64);
const _: () = fits::<scphd_description, NoState>(&sets::DESCRIPTION);
