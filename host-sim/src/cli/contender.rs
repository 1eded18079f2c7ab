//! The participants of a study: filters with the settings of the log or with variants of them.

use super::args::{Choice, FilterName, MonteCarloArgs, PrecisionName};
use super::failure::Failure;
use clap::ValueEnum;
use scphd_filters::kind::Kind;
use scphd_run::monte_carlo::variants::{self, Variant};
use scphd_run::session::Filter;
use std::path::PathBuf;

/// A filter, and the variant of its settings.
#[derive(Debug, Clone)]
pub struct Contender {
    choice: Choice,
    variant: Option<(PathBuf, Variant)>,
    /// Whether its name must include the filter besides the variant.
    names_filter: bool,
}

impl Contender {
    /// A filter with the settings of the log.
    pub fn plain(choice: Choice) -> Self {
        Self { choice, variant: None, names_filter: true }
    }

    /// All participants that the command line requests, grouped by filter and in the order of the file; without a named filter,
    /// with the default one.
    pub fn all(args: &MonteCarloArgs, are_worlds: bool) -> Result<Vec<Self>, Failure> {
        let asked_for = args.filters(are_worlds);
        let choice = |name| Choice::of(name, args.precision).map_err(Failure::input);
        let Some(path) = &args.variants else {
            return asked_for.iter().map(|&name| Ok(Self::plain(choice(name)?))).collect();
        };
        let mut all = Vec::new();
        let (own, common): (Vec<_>, Vec<_>) =
            variants::read(path).map_err(Failure::input)?.into_iter().partition(|variant| variant.filter.is_some());
        let asked_for = if common.is_empty() { Vec::new() } else { asked_for };
        for &name in &asked_for {
            for variant in &common {
                let variant = Some((path.clone(), variant.clone()));
                all.push(Self { choice: choice(name)?, variant, names_filter: asked_for.len() > 1 });
            }
        }
        for variant in own {
            let choice = named(variant.filter.as_deref().unwrap_or_default(), args.precision)
                .map_err(|why| Failure::input(format_args!("{}: {}: {why}", path.display(), variant.name)))?;
            all.push(Self { choice, variant: Some((path.clone(), variant)), names_filter: false });
        }
        Ok(all)
    }

    pub fn choice(&self) -> Choice {
        self.choice
    }

    pub fn filter(&self) -> Filter {
        self.choice.filter
    }

    pub fn is_variant(&self) -> bool {
        self.variant.is_some()
    }

    /// Whether both have the same filter, with different settings.
    pub fn is_of_the_filter_of(&self, other: &Self) -> bool {
        self.choice == other.choice
    }

    /// Its name with these settings.
    pub fn name<K: Kind>(&self, settings: &K::Settings) -> String {
        let filter = self.choice.filter.name(K::recursion(settings).likelihood);
        match &self.variant {
            None => filter.to_owned(),
            Some((_, variant)) if self.names_filter => format!("{filter}: {}", variant.name),
            Some((_, variant)) => variant.name.clone(),
        }
    }

    /// Its settings for a log with these settings.
    pub fn settings<K: Kind>(&self, settings: K::Settings) -> Result<K::Settings, Failure> {
        let settings = self.choice.settings::<K>(settings);
        match &self.variant {
            None => Ok(settings),
            Some((path, variant)) => variant
                .applied::<K>(&settings)
                .map_err(|problem| Failure::input(format_args!("{}: {}: {problem}", path.display(), variant.name))),
        }
    }
}

fn named(name: &str, precision: Option<PrecisionName>) -> Result<Choice, String> {
    let known = || FilterName::value_variants().iter().filter_map(|name| name.to_possible_value());
    let name = FilterName::from_str(name, false).map_err(|_| {
        let names: Vec<String> = known().map(|value| value.get_name().to_owned()).collect();
        format!("no filter '{name}', there are {}", names.join(", "))
    })?;
    Choice::of(name, precision).map_err(str::to_owned)
}
