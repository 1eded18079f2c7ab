//! A description as numbers, one for every setting in the order of the list: for recordings.

use crate::field::Place;
use crate::list::numbers;
use crate::{Description, Invalid, SENSORS, Sensor, Setting};
use core::ops::Range;
use scphd::Real;

/// The settings of the description alone, which come first; those of each sensor follow.
const OWN: usize = Setting::SENSOR_MODEL.place();
const OF_A_SENSOR: usize = Setting::COUNT - OWN;

/// The numbers of a sensor among those of its description.
#[must_use]
pub const fn numbers_of_sensor(sensor: usize) -> Range<usize> {
    let first = OWN + sensor * OF_A_SENSOR;
    first..first + OF_A_SENSOR
}

/// The number of each setting: 0 for one that the description does not have, and for a setting with choices the index of the choice.
/// They are exact in double precision, except for counts beyond 2⁵³. The number of a seed is the f64 with the seed's 64 bits.
impl<T: Real> Description<T> {
    /// Number of its numbers.
    pub const NUMBERS: usize = OWN + SENSORS * OF_A_SENSOR;

    /// Its numbers.
    #[must_use]
    pub fn numbers(&self) -> [f64; OWN + SENSORS * OF_A_SENSOR] {
        let mut copy = *self;
        let mut numbers = [0.0; OWN + SENSORS * OF_A_SENSOR];
        for (slot, (place, sensor)) in numbers.iter_mut().zip(places()) {
            *slot = copy.number(place, sensor);
        }
        numbers
    }

    /// Sets all settings of a description, which must be [`robot`](Self::robot), to these numbers; missing numbers are 0. In place,
    /// because a description has more than half a kilobyte.
    ///
    /// # Errors
    /// The first setting whose number is not the index of one of its choices. All other ranges are checked when a filter is built.
    pub fn take_numbers(&mut self, numbers: impl IntoIterator<Item = f64>) -> Result<(), Invalid> {
        let numbers = numbers.into_iter().chain(core::iter::repeat(0.0));
        places().zip(numbers).try_for_each(|((place, sensor), number)| self.put(place, sensor, number))
    }

    fn number(&mut self, place: usize, sensor: usize) -> f64 {
        match self.place(place, sensor) {
            Some(Place::Number(number)) => number.to_f64(),
            Some(Place::Count(count)) => *count as f64,
            Some(Place::Small(count)) => f64::from(*count),
            Some(Place::Seed(seed)) => f64::from_bits(*seed),
            None => self.choice(place, sensor).unwrap_or(0) as f64,
        }
    }

    fn put(&mut self, place: usize, sensor: usize, number: f64) -> Result<(), Invalid> {
        match self.place(place, sensor) {
            Some(Place::Number(slot)) => *slot = T::from_f64(number),
            Some(Place::Count(slot)) => *slot = number as usize,
            Some(Place::Small(slot)) => *slot = number as u16,
            Some(Place::Seed(slot)) => *slot = number.to_bits(),
            None => {
                // 0 is the first choice, and the number of an absent setting.
                let is_choice = number == 0.0 || numbers(place).is_some_and(|range| range.has(number));
                let is_put = is_choice && (self.choose(place, sensor, number as usize) || number == 0.0);
                return if is_put { Ok(()) } else { Err(Invalid::at(place, sensor)) };
            }
        }
        Ok(())
    }
}

impl<T: Real> Sensor<T> {
    /// Number of its numbers.
    pub const NUMBERS: usize = OF_A_SENSOR;

    /// Its numbers, as among those of its description.
    #[must_use]
    pub fn numbers(&self) -> [f64; OF_A_SENSOR] {
        let mut alone = Description::robot();
        alone.sensors = [Some(*self), None, None, None];
        let mut numbers = [0.0; OF_A_SENSOR];
        for (slot, place) in numbers.iter_mut().zip(OWN..) {
            *slot = alone.number(place, 0);
        }
        numbers
    }

    /// The sensor with these numbers, if there is one.
    ///
    /// # Errors
    /// The first setting whose number is not the index of one of its choices.
    pub fn of_numbers(numbers: &[f64]) -> Result<Option<Self>, Invalid> {
        let mut alone = Description::robot();
        for (place, number) in (OWN..Setting::COUNT).zip(numbers) {
            alone.put(place, 0, *number)?;
        }
        let [first, ..] = alone.sensors;
        Ok(first)
    }
}

/// Places in the list, with the sensor.
fn places() -> impl Iterator<Item = (usize, usize)> {
    let of_sensors = (0..SENSORS).flat_map(|sensor| (OWN..Setting::COUNT).map(move |place| (place, sensor)));
    (0..OWN).map(|place| (place, 0)).chain(of_sensors)
}
