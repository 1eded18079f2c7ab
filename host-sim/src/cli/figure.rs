//! The command that draws figures of the thesis.

use super::args::{Choice, ComparedFilter, FigureArgs, FilterName};
use super::contender::Contender;
use super::failure::{Failure, notice, print};
use super::monte_carlo::{Extent, Inputs, plan, run};
use super::outputs::{Outputs, make, print_beside};
use super::progress::Progress;
use super::source::Source;
use scphd_filters::settings::Settings;
use scphd_log::dimensions::Planar;
use scphd_log::log::Log;
use scphd_run::monte_carlo::Study;
use scphd_run::session;
use scphd_view::figure::{self, FIGURES};
use scphd_view::output::overview;
use scphd_view::plot::Figure;
use std::path::PathBuf;

pub fn figure(args: FigureArgs) -> Result<(), Failure> {
    let Some(number) = args.number.clone() else {
        let lines: Vec<String> = FIGURES.iter().map(|(number, about)| format!("{number}  {about}")).collect();
        return print(&lines.join("\n"));
    };
    let outputs = Outputs { json: None, out: Some(args.out.clone()) };
    outputs.check()?;
    let figures: Vec<(&str, Figure)> = match &number[..] {
        "5.4" => {
            let (log, settings, session) = single("thesis-dynamic", &args)?;
            let tracks = figure::tracks(&log, &settings, &session.record);
            vec![("5.4a", figure::estimate(&log, &session.record)), ("5.4b", tracks)]
        }
        "5.5" => {
            let study = study("thesis-dynamic", &[FilterName::Core], 100, &args)?;
            vec![("5.5", figure::mean_errors(&study))]
        }
        "5.8" => {
            let filters = [FilterName::Core, FilterName::RbSingle, FilterName::RbEmpty];
            let study = study("thesis-compare", &filters, 50, &args)?;
            vec![("5.8", figure::comparison(&study))]
        }
        _ => {
            let known: Vec<&str> = FIGURES.iter().map(|(number, _)| *number).collect();
            return Err(Failure::input(format_args!("no figure {number}, there are: {}", known.join(", "))));
        }
    };
    write(args.out, &figures)
}

fn write(out: PathBuf, figures: &[(&str, Figure)]) -> Result<(), Failure> {
    make(&out)?;
    for (number, figure) in figures {
        let [svg, png] = figure.write(&out, &format!("figure-{number}"))?;
        notice(format_args!("{} and {}", svg.display(), png.display()));
    }
    Ok(())
}

/// Runs the filter over a scenario once.
fn single(name: &str, args: &FigureArgs) -> Result<(Log, Settings, session::Session), Failure> {
    let source = Source::<Planar>::scenario(name.to_owned(), Some(args.seed))?;
    let log = source.log(args.seed)?.into_owned();
    let settings = source.tuned(&log, &args.tuning, &[ComparedFilter::Core.choice()])?;
    let choice = Choice::of(FilterName::Core, None).map_err(Failure::input)?;
    let progress = Progress::new(name.to_owned(), log.scans.len());
    let session = session::run::<Planar>(&log, &settings, choice.filter, args.seed, &mut |scans| progress.at(scans))?;
    Ok((log, settings, session))
}

/// Runs a study of a scenario, and prints its table.
fn study(name: &str, filters: &[FilterName], runs: usize, args: &FigureArgs) -> Result<Study, Failure> {
    let contenders = filters
        .iter()
        .map(|&name| Choice::of(name, None).map(Contender::plain).map_err(Failure::input))
        .collect::<Result<Vec<_>, _>>()?;
    let inputs = Inputs::<Planar>::of_scenario(name)?;
    let runs = args.runs.map_or(runs, |runs| runs as usize);
    let plan = plan(&inputs, &contenders, &args.tuning, &Extent { runs, input_sets: None, seed: args.seed })?;
    let study = run(&plan, &inputs, &contenders, &args.tuning, (args.jobs, None))?;
    print_beside(None, &overview::render(&study))?;
    Ok(study)
}
