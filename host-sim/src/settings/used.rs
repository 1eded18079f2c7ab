//! Which filter uses which setting and which option of the command line: one table, so that nothing that is asked for is ignored in silence.

use crate::slam::Filter;

/// Filters that use the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Family {
    Core,
    Joint,
    Reference,
    Ekf,
}

use Family::{Core, Ekf, Joint, Reference};

/// A setting, a section of them with a full stop at its end, or an option; and who uses it. The first row that fits counts.
const USES: &[(&str, &[Family])] = &[
    ("--particles", &[Core, Reference]),
    ("--samples", &[Core, Reference]),
    ("--threads", &[Core]),
    ("--moving on", &[Core, Joint, Reference]),
    // Who knows of nothing that moves does so as it is.
    ("--moving off", &[Core, Joint, Reference, Ekf]),
    ("--save-map", &[Joint]),
    ("--map", &[Joint]),
    ("--locate", &[Joint]),
    ("filter.birth_intensity", &[Core, Joint, Reference]),
    // The reference is the recursion of the thesis: what goes beyond it is the filter's own.
    ("filter.unconfirmed_weight", &[Core]),
    ("filter.extraction", &[Core]),
    ("filter.proposal", &[Core]),
    ("filter.proposal_rounds", &[Core]),
    ("filter.proposal_sampled_fraction", &[Core]),
    ("filter.proposal_min_responsibility", &[Core]),
    ("filter.births_wait", &[Core]),
    // The other likelihoods of section 5.3.2 are for comparison alone.
    ("filter.likelihood", &[Reference]),
    ("filter.", &[Core, Reference]),
    ("joint.", &[Joint]),
    ("calibration.", &[Joint]),
    ("fixes.", &[Core, Joint]),
    // The EKF has noise of its own, by what the log states.
    ("moving.", &[Core, Joint, Reference]),
    ("vehicle.", &[Core, Joint, Reference]),
    ("sensor.", &[Core, Joint, Reference]),
    ("sensors.", &[Core, Joint, Reference]),
    ("camera.", &[Core, Joint, Reference]),
];

/// Who uses a setting or an option, if it is one.
fn users(what: &str) -> Option<&'static [Family]> {
    let fits = |name: &str| what == name || name.ends_with('.') && what.starts_with(name);
    USES.iter().find(|(name, _)| fits(name)).map(|(_, users)| *users)
}

/// Whether `filter` uses the setting `section.key`, or the option.
#[must_use]
pub fn is_used_by(filter: Filter, what: &str) -> bool {
    let family = match filter {
        Filter::Core(_) => Core,
        Filter::Joint(_) => Joint,
        Filter::Reference => Reference,
        Filter::Ekf(_) => Ekf,
    };
    users(what).is_some_and(|users| users.contains(&family))
}

/// The values of `--filter` that use it, in words.
#[must_use]
pub fn users_of(what: &str) -> String {
    let name = |family: &Family| match family {
        Core => "core",
        Joint => "joint",
        Reference => "reference",
        Ekf => "ekf",
    };
    users(what).unwrap_or_default().iter().map(name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::origin::leaves;
    use super::super::{CalibrationSettings, Settings};
    use super::*;
    use crate::dimensions::Planar;
    use crate::ekf::Association;
    use crate::log::{Fix, FixNoise, PoseFix};
    use crate::session;
    use crate::slam::Precision;
    use crate::{scenario, underwater};
    use toml::{Table, Value};

    const FILTERS: [Filter; 4] = [
        Filter::Core(Precision::F64),
        Filter::Joint(Precision::F64),
        Filter::Reference,
        Filter::Ekf(Association::NearestNeighbour),
    ];

    #[test]
    fn every_setting_has_a_row() {
        let mut log = scenario::survey(1);
        log.fixes = vec![Fix { t_s: 0.0, measured: PoseFix::Position([0.0; 2]) }];
        log.fix_noise = FixNoise { position_sigma_m: Some(1.0), ..FixNoise::default() };
        let mut settings = Settings::for_log(&log);
        settings.calibration = Some(CalibrationSettings {
            speed_scale_sigma: 0.1,
            turn_scale_sigma: 0.1,
            turn_offset_sigma: 0.1,
            lasts_s: 1.0,
        });
        let space = underwater::by_name("girona-tank", 1).unwrap();
        let in_space = underwater::settings::Settings::for_log(&space);
        for field in leaves(&settings).into_iter().chain(leaves(&in_space)) {
            assert!(users(&field).is_some(), "{field}");
        }
        assert_eq!((users("filter"), users("sensor"), users("--seed")), (None, None, None));
    }

    /// Another value, within the limits of every field that there is.
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

    /// What a filter is said not to use changes no bit of its run; so nothing that does something is ever refused.
    #[test]
    fn what_is_not_used_changes_nothing() {
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
}
