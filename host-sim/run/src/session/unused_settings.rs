//! Settings that are declared as unused by a filter.

use crate::session;
use scphd_filters::ekf::Association;
use scphd_filters::settings::{Settings, is_used_by};
use scphd_filters::slam::{Filter, Precision};
use scphd_log::dimensions::Planar;
use scphd_worlds::scenario;
use toml::{Table, Value};

const FILTERS: [Filter; 4] = [
    Filter::Core(Precision::F64),
    Filter::Joint(Precision::F64),
    Filter::Reference,
    Filter::Ekf(Association::NearestNeighbour),
];

/// Another value, within the limits of any field.
fn another(value: &Value) -> Option<Value> {
    match value {
        Value::Float(number) => Some(Value::Float(0.9 * number + 1e-4)),
        Value::Integer(number) => Some(Value::Integer(number + 1)),
        Value::Boolean(is) => Some(Value::Boolean(!is)),
        Value::String(text) => {
            let other = match &**text {
                "blind" => "informed",
                "informed" => "blind",
                "heaviest" => "peaks",
                "peaks" | "confirmed" => "heaviest",
                _ => return None,
            };
            Some(Value::String(other.into()))
        }
        _ => None,
    }
}

/// Settings declared as unused change no bit of a run: a setting with an effect is never refused.
#[test]
fn unused_settings_change_no_bit_of_a_run() {
    let mut log = scenario::by_name("worlds", 7).unwrap();
    log.scans.truncate(40);
    log.odometry.retain(|row| row.t_s <= log.scans.last().unwrap().t_s);
    let of_filter = |filter: Filter| {
        let mut settings = Settings::for_log(&log);
        (settings.filter.particles, settings.filter.samples) = (2, 1);
        if filter == Filter::Reference {
            settings.restrict_to_reference();
        }
        let run = |settings: &Settings| {
            session::run::<Planar>(&log, settings, filter, 3, &mut |_| ()).map(|session| {
                let scans = session.record.scans.iter();
                (scans.map(|scan| (scan.pose, scan.pose_covariance)).collect::<Vec<_>>(), session.record.map)
            })
        };
        let usual = run(&settings).unwrap();
        let table = Table::try_from(&settings).unwrap();
        let mut compared = 0;
        for (section, fields) in &table {
            for (key, value) in fields.as_table().unwrap() {
                if is_used_by(filter, &format!("{section}.{key}")) {
                    continue;
                }
                let Some(other) = another(value) else { continue };
                let mut changed = table.clone();
                changed[section].as_table_mut().unwrap().insert(key.clone(), other);
                let changed: Settings = changed.try_into().unwrap();
                assert_eq!(run(&changed).unwrap(), usual, "{filter:?} uses {section}.{key}");
                compared += 1;
            }
        }
        compared
    };
    let compared = FILTERS.map(of_filter);
    assert!(compared[0] >= 5 && compared[1] >= 15 && compared[2] >= 10 && compared[3] >= 30, "{compared:?}");
}
