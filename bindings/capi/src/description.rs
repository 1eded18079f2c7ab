//! A description of a vehicle, changed by the numbers of its settings.

use crate::block::Handle;
use crate::memory::{Asked, Entry, NoState};
use crate::pointer::{Bytes, Handed, Out};
use crate::reason::Reason;
use crate::sets::DESCRIPTION;
use crate::{scphd_reason, scphd_status};
use core::ffi::c_char;
use scphd_vehicle::{Description, Setting};

/// A description of a vehicle, its filter, sensors, fixes and start, in its memory. It may be used for several filters, and is
/// not needed while they run.
#[derive(Debug)]
pub struct scphd_description {
    _opaque: [u8; 0],
}

impl Handle for scphd_description {
    type Inner = Description<f32>;
    const KIND: u32 = 4;
}

/// Starts a description in this memory of `SCPHD_SIZE_DESCRIPTION` bytes: a robot that turns in place, with a joint map and
/// without sensors. Writes the handle to `description`, or null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_description_start(
    abi_version: u32,
    memory: Bytes,
    size_bytes: usize,
    description: Out<*mut scphd_description>,
) -> scphd_status {
    let asked = Asked { abi_version, memory, size_bytes, reason: Out::NULL, handle: description };
    asked.make(&DESCRIPTION, Entry::Start, |_: &mut NoState, _| Ok(Description::robot()))
}

fn known(setting: u32) -> Result<Setting, scphd_status> {
    Setting::of_number(setting).ok_or(scphd_status::UnknownSetting)
}

/// Sets one of the settings above, such as `SCPHD_VEHICLE_KIND`. For `SCPHD_SENSOR_...`, `sensor` is the index of the sensor, 0
/// to 3. If the setting is a choice, `number` is the index of the choice. The reason may be null.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_description_set(
    mut description: Handed<scphd_description>,
    setting: u32,
    sensor: usize,
    number: f32,
    mut reason: Out<scphd_reason>,
) -> scphd_status {
    let mut set = || {
        let mut reason = Reason::of(&mut reason)?;
        let setting = known(setting)?;
        description.enter()?.set(setting, sensor, number).map_err(|invalid| reason.invalid(invalid))
    };
    scphd_status::of(set())
}

/// Reads a setting. Returns `SCPHD_STATUS_NOT_DESCRIBED` if the description has no such part.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_description_get(
    mut description: Handed<scphd_description>,
    setting: u32,
    sensor: usize,
    mut number: Out<f32>,
) -> scphd_status {
    let mut get = || {
        let place = number.place()?;
        let found = description.enter()?.get(known(setting)?, sensor);
        place.write(found.ok_or(scphd_status::NotDescribed)?);
        Ok(())
    };
    scphd_status::of(get())
}

/// The name of a setting, such as "joint.gate". The text is static.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_setting_name(setting: u32) -> *const c_char {
    Setting::of_number(setting).map_or(c"no setting", Setting::name_c).as_ptr()
}

/// The range of a setting, such as "finite and at least 0". The text is static.
#[unsafe(no_mangle)]
pub extern "C" fn scphd_setting_range(setting: u32) -> *const c_char {
    Setting::of_number(setting).map_or(c"no setting", Setting::range_c).as_ptr()
}
