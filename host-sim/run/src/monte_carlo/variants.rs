//! Variants of settings, for studies of the effect of a change: a file of named variants.
//!
//! ```toml
//! [[variant]]
//! name = "as they are"
//!
//! [[variant]]
//! name = "noise x 2"
//! times.sensor = { range_sigma_m = 2, bearing_sigma_rad = 2 }
//!
//! [[variant]]
//! name = "blind"
//! filter = "rb-single"
//! set.filter = { particles = 100 }
//! ```

use super::worlds::WorldRun;
use scphd_filters::kind::Kind;
use scphd_filters::settings::FileProblem;
use serde::Deserialize;
use std::fs;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Named changes of the settings of a log.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    pub name: String,
    /// The filter of the variant; all requested filters if absent.
    pub filter: Option<String>,
    /// Values, by section and key as in a settings file.
    #[serde(default)]
    set: Table,
    /// Factors for values of the settings, by section and key.
    #[serde(default)]
    times: Table,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    variant: Vec<Variant>,
}

/// Why a file of variants cannot be read; displays as one line.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct VariantsError {
    path: PathBuf,
    problem: String,
}

/// The variants in the file at `path`, in its order.
pub fn read(path: &Path) -> Result<Vec<Variant>, VariantsError> {
    let bad = |problem: String| {
        let problem = problem.split_whitespace().collect::<Vec<_>>().join(" ");
        VariantsError { path: path.into(), problem }
    };
    let text = fs::read_to_string(path).map_err(|error| bad(format!("cannot be read: {error}")))?;
    parse(&text).map_err(bad)
}

fn parse(text: &str) -> Result<Vec<Variant>, String> {
    let File { variant: variants } = toml::from_str(text).map_err(|error| error.to_string())?;
    if variants.is_empty() {
        return Err("there is no variant in it".into());
    }
    for (place, Variant { name, filter, .. }) in variants.iter().enumerate() {
        // Names become parts of file names.
        if name.trim().is_empty() || name.contains(|c: char| c.is_control() || "/\\".contains(c)) {
            return Err(format!("variant {}: a name needs letters, and no slash", place + 1));
        }
        if variants[..place].iter().any(|before| before.name == *name && before.filter == *filter) {
            return Err(format!("variant {}: {name} is there twice", place + 1));
        }
    }
    Ok(variants)
}

impl Variant {
    /// Applies the changes to settings.
    pub fn applied<K: Kind>(&self, settings: &K::Settings) -> Result<K::Settings, FileProblem> {
        let base = Table::try_from(settings).map_err(|error| FileProblem::Field(error.to_string()))?;
        let mut over = self.set.clone();
        for (section, factors) in &self.times {
            let factors = factors.as_table().ok_or_else(|| FileProblem::Field(format!("{section}: not a section")))?;
            for (key, factor) in factors {
                let value = base.get(section).and_then(|section| section.get(key));
                let product = value.and_then(number).zip(number(factor)).map(|(value, factor)| value * factor);
                let product =
                    product.ok_or_else(|| FileProblem::Field(format!("{section}.{key}: not a number to multiply")))?;
                let section = over.entry(section).or_insert_with(|| Value::Table(Table::new()));
                if let Some(section) = section.as_table_mut() {
                    section.insert(key.clone(), Value::Float(product));
                }
            }
        }
        K::with_toml(settings, &over.to_string())
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// The run with the least error among those of `filters` in each world, under the name `name`; worlds without a run of one of
/// them are left out.
pub fn best_of(runs: &[WorldRun], filters: &[String], worlds: &[&str], name: &str) -> Vec<WorldRun> {
    let best = |world: &&str| {
        let of = filters.iter().map(|filter| runs.iter().find(|run| run.world == *world && run.filter == *filter));
        let all: Vec<&WorldRun> = of.collect::<Option<_>>()?;
        let best = all.into_iter().min_by(|a, b| a.position_rmse_m.total_cmp(&b.position_rmse_m))?;
        Some(WorldRun { filter: name.to_owned(), ..best.clone() })
    };
    worlds.iter().filter_map(best).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scphd_filters::settings::Settings;
    use scphd_log::dimensions::Planar;
    use scphd_worlds::scenario;

    const TEXT: &str = "
        [[variant]]
        name = 'as they are'
        [[variant]]
        name = 'noise x 2'
        times.sensor = { range_sigma_m = 2, bearing_sigma_rad = 2.0 }
        set.sensor = { detection_near = 0.5 }
        [[variant]]
        name = 'noise x 2'
        filter = 'ekf'
        [[variant]]
        name = 'few'
        set.filter = { particles = 3 }
    ";

    #[test]
    fn changes_of_the_file_are_applied() {
        let settings = Settings::for_log(&scenario::survey(1));
        let variants = parse(TEXT).unwrap();
        assert_eq!(variants[0].applied::<Planar>(&settings).unwrap(), settings);
        let mut noisy = settings.clone();
        noisy.sensor.range_sigma_m *= 2.0;
        noisy.sensor.bearing_sigma_rad *= 2.0;
        noisy.sensor.detection_near = 0.5;
        assert_eq!(variants[1].applied::<Planar>(&settings).unwrap(), noisy);
        assert_eq!((variants[1].filter.as_deref(), variants[2].filter.as_deref()), (None, Some("ekf")));
        let mut few = settings.clone();
        few.filter.particles = 3;
        assert_eq!(variants[3].applied::<Planar>(&settings).unwrap(), few);
    }

    #[test]
    fn invalid_variants_are_refused() {
        for (text, part) in [
            ("", "variant"),
            ("variant = []", "no variant"),
            ("[[variant]]\nname = ' '", "variant 1: a name"),
            ("[[variant]]\nname = 'a/b'", "variant 1: a name"),
            ("[[variant]]\nname = 'a'\n[[variant]]\nname = 'a'", "variant 2: a is there twice"),
            ("[[variant]]\nname = 'a'\nsett.filter = { particles = 3 }", "sett"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
        let settings = Settings::for_log(&scenario::survey(1));
        for (changes, part) in [
            ("times.sensor = { range_sigma = 2 }", "sensor.range_sigma"),
            ("times.filter = { proposal = 2 }", "filter.proposal"),
            ("times.sensor = 2", "sensor"),
            ("times.sensor = { detection_near = 2 }", "sensor.detection_near"),
            ("set.filter = { particles = 0 }", "filter.particles"),
            ("set.filter = { particle = 1 }", "particle"),
        ] {
            let variants = parse(&format!("[[variant]]\nname = 'a'\n{changes}")).unwrap();
            let error = variants[0].applied::<Planar>(&settings).unwrap_err().to_string();
            assert!(error.contains(part), "{changes}: {error}");
        }
    }

    #[test]
    fn the_best_filter_is_chosen_in_each_world() {
        let run = |world: &str, filter: &str, position_rmse_m| WorldRun {
            world: world.into(),
            filter: filter.into(),
            settings: format!("{world}{filter}"),
            position_rmse_m,
            dead_reckoning_rmse_m: 5.0,
            nees_median: None,
            scan_us_mean: None,
        };
        let runs = [run("a", "x", 1.0), run("a", "y", 2.0), run("b", "x", 4.0), run("b", "y", 3.0), run("c", "x", 1.0)];
        let best = best_of(&runs, &["x".into(), "y".into()], &["a", "b", "c"], "best of 2");
        assert_eq!(
            best.iter().map(|run| (&run.settings[..], &run.filter[..])).collect::<Vec<_>>(),
            [("ax", "best of 2"), ("by", "best of 2")]
        );
    }
}
