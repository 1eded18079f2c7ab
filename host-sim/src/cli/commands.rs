//! Execution of the commands.

use super::args::{Choice, Cli, Command, FilterName, MainJob, RunArgs, Tuning};
use super::constants::constants;
use super::failure::{Failure, be_quiet, note_innovations, print, warn_of_errors, warning};
use super::folder::export;
use super::maps::{Maps, told};
use super::offer::Offer;
use super::outputs::{Outputs, check_file, label, write_file};
use super::progress::Progress;
use super::source::{Found, OfKind, Source, Sources, all_scenarios, either, scenario, settings_command, tuned, used};
use super::{check, compare, diff, figure, hil, import, monte_carlo, recording, repeat, stream, tune, worlds};
use scphd::Health;
use scphd_filters::kind::Kind;
use scphd_filters::threads::Threads;
use scphd_log::dimensions::{Dimensions, Planar, Underwater};
use scphd_run::film::Film;
use scphd_run::session::{self, Filter, LeftOut, MapUse, Session, condition_name};
use scphd_score::results::json::Summary;
use scphd_view::output::table;
use scphd_view::report::page;
use std::fs;
use std::path::Path;

/// The scenario of the program without a command.
const MAIN_SCENARIO: &str = "survey";
/// Its filters, the recommended one first. The EKF is not among them, because it takes minutes in clutter.
const MAIN_FILTERS: [FilterName; 3] = [FilterName::Joint, FilterName::Core, FilterName::Reference];

pub fn execute(cli: Cli) -> Result<(), Failure> {
    if cli.quiet {
        be_quiet();
    }
    match cli.command {
        None => main_job(cli.job),
        Some(Command::Replay { dirs, truth_sigma, run }) => {
            let mut found = dirs.iter().map(|dir| Found::folder(dir)).collect::<Result<Vec<_>, _>>()?;
            if let Some(sigma_m) = truth_sigma {
                found.iter_mut().try_for_each(|found| found.take_truth_for(sigma_m))?;
            }
            let names: Vec<String> = dirs.iter().map(|dir| dir.display().to_string()).collect();
            found.iter().for_each(Found::warn);
            either!(Sources::of(found)?, sources => runs(&sources, &names, run))
        }
        Some(Command::Run { scenario: name, run, scenario_seed }) => {
            let found = Found::scenario(&name, scenario_seed.scenario_seed)?;
            either!(found, source => runs(&[source], &[name], run))
        }
        Some(Command::Check(args)) => check::check(&args),
        Some(Command::Diff(args)) => diff::diff(&args),
        Some(Command::MonteCarlo(args)) => match worlds::asked_for(&args) {
            Some(OfKind::Planar(name)) => worlds::study::<Planar>(name, args),
            Some(OfKind::Underwater(name)) => worlds::study::<Underwater>(name, args),
            None => monte_carlo::study(args),
        },
        Some(Command::Figure(args)) => figure::figure(args),
        Some(Command::Compare(args)) => {
            let found = Found::find(&args.source, args.scenario_seed.scenario_seed)?;
            either!(found, source => compare::compare(&source, args))
        }
        Some(Command::Scenarios) => list_scenarios(),
        Some(Command::Export { scenario: name, dir, seed, count }) => match Found::scenario(&name, None)? {
            OfKind::Planar(_) => export_all(&name, &dir, seed, count),
            OfKind::Underwater(_) => {
                // A folder of a stereo log has fewer data than the scenario.
                let (dir, why) = (dir.display(), "a log folder has no compass, depth and outages of the Doppler log");
                Err(Failure::input(format_args!("{name} with seed {seed} cannot be written to {dir}: {why}")))
            }
        },
        Some(Command::Import(args)) => import::import(args),
        Some(Command::Stream(args)) => stream::stream(args),
        Some(Command::Hil(args)) => hil::hil(&args),
        Some(Command::Tune(args)) => tune::tune(args),
        Some(Command::Settings { source, language: None, tuning }) => {
            either!(Found::find(&source, None)?, source => settings(&source, &tuning))
        }
        Some(Command::Settings { source: name, language: Some(language), tuning }) => {
            let OfKind::Planar(source) = Found::find(&name, None)? else {
                return Err(Failure::input("--as: only vehicles in the plane are described by settings"));
            };
            let log = &*source.log(0)?;
            let choice = usual(&source, &tuning)?;
            let defaults = source.defaults(log, &[choice]);
            let settings = tuned::<Planar>(defaults, &mut source.origins(log), log, &tuning, &[])?;
            print(&constants(log, &settings, &name.display().to_string(), language)?)
        }
    }
}

/// The default filter.
fn usual<K: Offer>(source: &Source<K>, tuning: &Tuning) -> Result<Choice, Failure> {
    Choice::of(FilterName::usual(source.is_joint_usual(), tuning, 1), None).map_err(Failure::input)
}

fn settings<K: Offer>(source: &Source<K>, tuning: &Tuning) -> Result<(), Failure> {
    let log = &*source.log(0)?;
    let mut origins = source.origins(log);
    let choice = usual(source, tuning)?;
    let settings = tuned::<K>(source.defaults(log, &[choice]), &mut origins, log, tuning, &[])?;
    let text = origins.annotated(&settings, Some(choice.filter))?;
    let about = "# After each value: where it is from. stated: the log or scenario says it; default: taken where the log does not say.";
    print(&format!("{about}\n{}", text.trim_end()))
}

fn list_scenarios() -> Result<(), Failure> {
    let width = all_scenarios().map(|(name, _)| name.len()).max().unwrap_or(0);
    let lines: Vec<String> = all_scenarios().map(|(name, about)| format!("{name:width$}  {about}")).collect();
    print(&lines.join("\n"))
}

/// Runs one filter over one or several logs, with one or several seeds; `names` are the names of the sources.
fn runs<K: Offer>(sources: &[Source<K>], names: &[String], args: RunArgs) -> Result<(), Failure> {
    match (sources, names) {
        ([source], [name]) if args.repeat == 1 => single(source, name, args),
        _ => repeat::repeat(sources, args),
    }
}

fn single<K: Offer>(source: &Source<K>, name: &str, args: RunArgs) -> Result<(), Failure> {
    let log = &*source.log(args.seed.seed)?;
    let choice = args.filter(source.is_joint_usual()).map_err(Failure::input)?;
    let threads = args.threads()?;
    let mut origins = source.origins(log);
    args.options().into_iter().try_for_each(|option| used(&[choice], option, ""))?;
    let settings = choice.settings::<K>(source.tuned_from(&mut origins, log, &args.tuning, &[choice])?);
    let outputs = Outputs { json: args.json, out: args.out };
    outputs.check()?;
    let html = args.html.as_deref();
    html.map_or(Ok(()), |path| check_file("--html", path))?;
    let mcap = args.mcap.as_deref();
    mcap.map_or(Ok(()), |path| recording::check::<K>(log, path))?;
    let maps = Maps { map: args.map, locate: args.locate, save: args.save_map };
    let file = maps.read()?;
    let (filter, seed) = (choice.filter, args.seed.seed);
    let progress = progress_of::<K>(log, &settings, filter);
    // Tables, plots and pages show the error of the map over time.
    let last_error_alone = outputs.out.is_none() && html.is_none();
    let (start, mut at) = (maps.to_use(file.as_deref(), last_error_alone), |scans| progress.at(scans));
    let mut film = html.or(mcap).map(|_| Film::of(K::scans(log).len()));
    let (session, outcome) =
        session::run_in_map::<K>(&threads, log, &settings, filter, seed, start, film.as_mut(), &mut at)?;
    drop(progress);
    outputs.write_one::<K>(log, &session)?;
    if let Some(film) = &film {
        let text = origins.annotated(&settings, Some(filter))?;
        if let Some(path) = html {
            write_file("--html", path, page::<K>(log, &settings, &session, film, &text).as_bytes())?;
        }
        if let Some(path) = mcap {
            recording::write::<K>(path, log, &settings, &session, film, &text)?;
        }
    }
    maps.write(&outcome)?;
    report(&outputs, &[session])?;
    outcome.search.iter().try_for_each(|search| outputs.print(&told(search)))?;
    outputs.print(&settings_command(name, &args.tuning))
}

/// The page of the program without a command, in the folder of its plots.
const MAIN_PAGE: &str = "report.html";

/// Runs the recommended filter, the fixed-capacity filter and the reference over the scenario.
fn main_job(job: MainJob) -> Result<(), Failure> {
    let seed = job.seed.seed;
    let source = Source::<Planar>::scenario(MAIN_SCENARIO.to_owned(), job.scenario_seed.scenario_seed)?;
    let log = source.log(seed)?;
    let mut origins = source.origins(&log);
    let choices = MAIN_FILTERS.map(|name| Choice::of(name, None));
    let choices = choices.into_iter().collect::<Result<Vec<_>, _>>().map_err(Failure::input)?;
    let settings = source.tuned_from(&mut origins, &log, &job.tuning, &choices)?;
    let page_file = job.out.join(MAIN_PAGE);
    let outputs = Outputs { json: job.json, out: Some(job.out) };
    outputs.check()?;
    // In sequence: in parallel they would slow each other down, and their times would be wrong.
    let run = |filter, film: Option<&mut Film<Planar>>| {
        let progress = progress_of::<Planar>(&log, &settings, filter);
        let (threads, mut at) = (Threads::default(), |scans| progress.at(scans));
        session::run_in_map::<Planar>(&threads, &log, &settings, filter, seed, MapUse::default(), film, &mut at)
    };
    let mut film = Film::of(log.scans.len());
    let mut sessions = Vec::with_capacity(choices.len());
    for choice in &choices {
        let (session, _) = run(choice.filter, sessions.is_empty().then_some(&mut film))?;
        sessions.push(session);
    }
    let text = origins.annotated(&settings, None)?;
    let page = page::<Planar>(&log, &settings, &sessions[0], &film, &text);
    outputs.write_all::<Planar>(&log, &sessions)?;
    write_file("--out", &page_file, page.as_bytes())?;
    outputs.print(&format!(
        "the joint map (recommended), the thesis's filter with {} particles (scphd), and its independent reference (f64):",
        settings.filter.particles
    ))?;
    report(&outputs, &sessions)?;
    outputs.print(&format!("the run in a browser: {}", page_file.display()))?;
    outputs.print(&settings_command(MAIN_SCENARIO, &job.tuning))
}

fn progress_of<K: Kind>(log: &K::Log, settings: &K::Settings, filter: Filter) -> Progress {
    let name = format!("{} {}", filter.name(K::recursion(settings).likelihood), filter.precision());
    Progress::new(name, K::scans(log).len())
}

/// Explanation of the rows on innovations.
const ABOUT_INNOVATIONS: &str = "\
innovations: how far detections lie from where they were expected, beside the standard deviations in the settings. NIS/dim is 1 where these are right, \
less where they are too large (a recorded log's noise is taken 1.1 times if it is white, otherwise 1.5 times: 0.83 and 0.44 are usual), more \
where they are too small; either way fewer scans lie within 95 % of χ².";

/// Prints the table and the conditions reported by the fixed-capacity filter.
fn report<D: Dimensions>(outputs: &Outputs, sessions: &[Session<D>]) -> Result<(), Failure> {
    let summaries: Vec<_> = sessions.iter().map(|session| session.summary.clone()).collect();
    outputs.print(&table::render(&summaries))?;
    if summaries.iter().any(|summary| summary.nis_mean.is_some()) {
        outputs.print(ABOUT_INNOVATIONS)?;
    }
    for session in sessions.iter().filter(|session| session.summary.digest.is_some()) {
        report_health(outputs, &session.summary, &session.health)?;
    }
    for summary in summaries.iter().filter(|summary| summary.fixes > 0) {
        let Summary { fixes, fixes_left_out, fix_relocations, .. } = summary;
        let back = match fix_relocations {
            0 => String::new(),
            times => format!("; where they agreed with each other the filter was put to them, {times} times"),
        };
        outputs.print(&format!("fixes, {}: {fixes} shown, {fixes_left_out} beyond the gate{back}", label(summary)))?;
    }
    sessions.iter().for_each(warn_of_rows);
    summaries.iter().for_each(warn_of_fixes);
    summaries.iter().for_each(|summary| warn_of_errors(std::slice::from_ref(summary)));
    summaries.iter().for_each(note_innovations);
    Ok(())
}

/// Warns of rows of the odometry that were left out.
fn warn_of_rows<D: Dimensions>(session: &Session<D>) {
    if let [LeftOut { row, t_s, what }, more @ ..] = &session.left_out[..] {
        let rest = if more.is_empty() { String::new() } else { format!("; and {} more", more.len()) };
        let label = label(&session.summary);
        warning(format_args!("warning: {label}: row {} of the odometry ({t_s} s) left out: {what}{rest}", row + 1));
    }
}

/// Warns if more fixes are left out than usual for outliers.
fn warn_of_fixes(summary: &Summary) {
    let Summary { fixes, fixes_left_out, .. } = summary;
    if *fixes_left_out > 1 && fixes_left_out * 10 > *fixes {
        let label = label(summary);
        warning(format_args!(
            "warning: {label}: {fixes_left_out} of {fixes} fixes lie beyond the gate and are left out; check their frame and clock, \
             position_sigma_m and initial_pose; a greater `gate` in [fixes] takes more in, inf all"
        ));
    }
}

/// Prints the conditions reported by the fixed-capacity filter.
fn report_health(outputs: &Outputs, summary: &Summary, health: &[(Health, usize)]) -> Result<(), Failure> {
    let scans = summary.scans;
    let conditions: Vec<String> = health
        .iter()
        .map(|&(condition, count)| format!("{} in {count} of {scans} scans", condition_name(condition)))
        .collect();
    let text = if conditions.is_empty() { "good in all scans".into() } else { conditions.join(", ") };
    outputs.print(&format!("health, {}: {text}", label(summary)))
}

/// Writes one folder, or `count` folders in a folder, with consecutive seeds.
fn export_all(name: &str, dir: &Path, seed: u64, count: Option<u32>) -> Result<(), Failure> {
    let Some(count) = count else { return export(&scenario::<Planar>(name, seed)?, dir) };
    fs::create_dir_all(dir).map_err(|error| Failure::input(format_args!("cannot make {}: {error}", dir.display())))?;
    (0..u64::from(count)).try_for_each(|k| {
        let seed = seed.checked_add(k).ok_or_else(|| Failure::input(format_args!("--seed {seed}: too large")))?;
        export(&scenario::<Planar>(name, seed)?, &dir.join(format!("{name}-{seed}")))
    })
}
