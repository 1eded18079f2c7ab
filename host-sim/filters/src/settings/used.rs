//! Table of the filters that use each setting and each option of the command line, so that none is ignored silently.

use crate::slam::Filter;

/// Filters with the same settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Family {
    Core,
    Joint,
    Reference,
    Ekf,
}

use Family::{Core, Ekf, Joint, Reference};

/// A setting, a section with a full stop at its end, or an option, with the filters that use it. The first matching row counts.
const USES: &[(&str, &[Family])] = &[
    ("--particles", &[Core, Reference]),
    ("--samples", &[Core, Reference]),
    ("--threads", &[Core]),
    ("--moving on", &[Core, Joint, Reference]),
    // Filters without moving features accept it.
    ("--moving off", &[Core, Joint, Reference, Ekf]),
    ("--hypotheses", &[Joint]),
    ("--save-map", &[Joint]),
    ("--map", &[Joint]),
    ("--locate", &[Joint]),
    ("filter.birth_intensity", &[Core, Joint, Reference]),
    // The reference has only the recursion of the thesis.
    ("filter.unconfirmed_weight", &[Core]),
    ("filter.extraction", &[Core]),
    ("filter.proposal", &[Core]),
    ("filter.proposal_rounds", &[Core]),
    ("filter.proposal_sampled_fraction", &[Core]),
    ("filter.proposal_min_responsibility", &[Core]),
    ("filter.births_wait", &[Core]),
    // The other likelihoods of section 5.3.2 are for comparison only.
    ("filter.likelihood", &[Reference]),
    ("filter.", &[Core, Reference]),
    ("joint.", &[Joint]),
    ("calibration.", &[Joint]),
    ("fixes.", &[Core, Joint]),
    // The EKF derives its noise from the log.
    ("moving.", &[Core, Joint, Reference]),
    ("vehicle.", &[Core, Joint, Reference]),
    ("sensor.", &[Core, Joint, Reference]),
    ("sensors.", &[Core, Joint, Reference]),
    ("camera.", &[Core, Joint, Reference]),
];

/// The filters that use a setting or an option; `None` if it does not exist.
fn users(what: &str) -> Option<&'static [Family]> {
    let fits = |name: &str| what == name || name.ends_with('.') && what.starts_with(name);
    USES.iter().find(|(name, _)| fits(name)).map(|(_, users)| *users)
}

/// Whether `filter` uses the setting `section.key`, or the option.
pub fn is_used_by(filter: Filter, what: &str) -> bool {
    let family = match filter {
        Filter::Core(_) => Core,
        Filter::Joint(_) => Joint,
        Filter::Reference => Reference,
        Filter::Ekf(_) => Ekf,
    };
    users(what).is_some_and(|users| users.contains(&family))
}

/// The values of `--filter` that use it, as text.
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
    use scphd_log::log::{Fix, FixNoise, PoseFix};
    use scphd_worlds::{scenario, underwater};

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
        let in_space = crate::underwater::settings::Settings::for_log(&space);
        for field in leaves(&settings).into_iter().chain(leaves(&in_space)) {
            assert!(users(&field).is_some(), "{field}");
        }
        assert_eq!((users("filter"), users("sensor"), users("--seed")), (None, None, None));
    }
}
