//! The list of settings: every one can be read and written by its name, and is refused out of its range.

use scphd::{Config, Real};
use scphd_vehicle::{Description, Filter, Invalid, Sensor, Setting, StartError};

/// Two descriptions that together have every part.
fn full() -> [Description<f64>; 2] {
    let mut joint = Description::<f64>::robot();
    for (name, choice) in [
        ("joint.movers", 1.0),
        ("joint.odometry", 1.0),
        ("joint.archive", 1.0),
        ("joint.hypotheses", 1.0),
        ("sensor.model", 1.0),
        ("position", 1.0),
        ("position.watch", 1.0),
        ("heading", 1.0),
        ("heading.watch", 1.0),
    ] {
        joint.set(Setting::of_name(name).unwrap(), 0, choice).unwrap();
    }
    let mixture = Description { filter: Filter::Mixture(Config::informed(4)), ..joint };
    [joint, mixture]
}

#[test]
fn every_setting_is_in_a_description_and_is_read_as_it_was_written() {
    for setting in Setting::all() {
        assert_eq!(Setting::all().filter(|other| other.name() == setting.name()).count(), 1);
        assert!(setting.about().ends_with('.') && !setting.name().is_empty(), "{}", setting.name());
        let of_it = full().into_iter().filter(|description| description.get(setting, 0).is_some());
        assert_ne!(of_it.clone().count(), 0, "{} is of none", setting.name());
        for mut description in of_it {
            let before = description;
            let number = description.get(setting, 0).unwrap();
            description.set(setting, 0, number).unwrap();
            assert_eq!(description, before, "{}", setting.name());
            assert!(description.set(setting, 0, f64::NAN).is_err() && description == before, "{}", setting.name());
            // Another valid number is stored, and read back.
            let other = [0.5, 1.0, 2.0, 3.0, 4.0, 0.0]
                .into_iter()
                .find(|other| *other != number && description.set(setting, 0, *other).is_ok());
            assert_eq!(description.get(setting, 0), other, "{}", setting.name());
            assert_ne!(description, before, "{}", setting.name());
        }
    }
}

#[test]
fn settings_out_of_range_are_named() {
    for description in full() {
        assert_eq!(description.check(), Ok(()));
    }
    let mut robot = full()[0];
    robot.sensors[2] = Some(Sensor { clutter_per_scan: -1.0, ..Sensor::range_bearing(10.0, 0.9, [0.1, 0.01]) });
    let Err(StartError::Invalid(invalid)) = robot.check() else { panic!() };
    assert_eq!(invalid.to_string(), "sensor.clutter_per_scan of sensor 2 must be between 0 and 1000000000");
    robot.sensors[2] = None;
    let gate = Setting::of_name("joint.gate").unwrap();
    assert_eq!(robot.set(gate, 0, -1.0).unwrap_err().to_string(), "joint.gate must be finite and at least 0");
    robot.vehicle.noise = scphd::models::ControlNoise::NONE;
    assert_eq!(robot.check().unwrap_err().to_string(), "vehicle.noise must be above 0 in one of its numbers");
    assert!(Setting::of_name("joint").is_none());
}

/// The description with these numbers.
fn read<T: Real>(numbers: &[f64]) -> Result<Description<T>, Invalid> {
    let mut description = Description::robot();
    description.take_numbers(numbers.iter().copied()).map(|()| description)
}

#[test]
fn a_description_comes_back_from_its_numbers() {
    for mut description in full() {
        description.sensors[3] = Some(Sensor::range_bearing(7.0, 0.8, [0.3, 0.04]));
        description.start.seed = u64::MAX;
        // All numbers differ from those of the default.
        for (setting, sensor) in Setting::all().flat_map(|setting| [(setting, 0), (setting, 3)]) {
            if let Some(number) = description.get(setting, sensor).filter(|_| setting.choices().is_empty()) {
                let _ = [0.75 * number, number + 1.0].map(|other| description.set(setting, sensor, other));
            }
        }
        assert_eq!(read(&description.numbers()), Ok(description));
        let sensor = description.sensors[3].unwrap();
        assert_eq!(Sensor::of_numbers(&sensor.numbers()), Ok(Some(sensor)));
        assert_eq!(description.numbers()[scphd_vehicle::numbers_of_sensor(3)], sensor.numbers());
        // What a vehicle in single precision had is exact, too.
        let single = read::<f32>(&description.numbers()).unwrap();
        assert_eq!(read(&single.numbers()), Ok(single));
        for (place, choice) in [(0, 4.0), (0, f64::NAN), (Setting::FILTER.place(), 2.0)] {
            let mut numbers = description.numbers();
            numbers[place] = choice;
            assert_eq!(read::<f32>(&numbers).unwrap_err().setting.place(), place);
        }
    }
}
