//! The command line: names of steps, `test` for all of them, `help`.

use crate::options::Options;
use crate::steps::{OTHERS, STEPS, Step};
use crate::{capi, debian, doctor, quick, toolchain};

pub enum Request {
    Print(String),
    /// Run these steps in order.
    Run(Vec<&'static Step>, Options),
}

/// Reads the arguments of `cargo xtask`. The error is one line for the user.
pub fn parse(words: &[String]) -> Result<Request, String> {
    let mut chosen: Vec<&'static Step> = Vec::new();
    let mut options = Options::default();
    let mut words = words.iter().peekable();
    let target = |word: &str| capi::TARGETS.into_iter().find(|target| *target == word);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--strict" => options.strict = true,
            "doctor" => return Ok(Request::Print(doctor::report())),
            "--json" => options.json = Some(words.next().ok_or("--json needs a file")?.into()),
            "help" | "--help" | "-h" => return Ok(Request::Print(usage())),
            "test" => {
                chosen.extend(if words.next_if(|word| *word == "--all").is_some() { STEPS } else { quick::STEPS })
            }
            "install-c" if !options.place.prefix.as_os_str().is_empty() => {
                return Err("install-c can be asked for once".into());
            }
            "install-c" => {
                options.place.prefix = words.next().ok_or("install-c needs a folder")?.into();
                chosen.extend(OTHERS.iter().filter(|step| step.name == "install-c"));
            }
            word if target(word).is_some() && chosen.last().is_some_and(|step| step.name == "install-c") => {
                options.place.target = target(word);
            }
            number if number.parse::<u64>().is_ok() && chosen.last().is_some_and(|step| step.name == "fuzz") => {
                options.numbers.extend(number.parse::<u64>());
                if options.numbers.len() > 2 {
                    return Err("fuzz takes operations and a seed".into());
                }
            }
            "--all" if chosen.last().is_some_and(|step| ["logs", "python"].contains(&step.name)) => {
                options.studies = true
            }
            name => match STEPS.iter().chain(quick::STEPS).chain(OTHERS).find(|step| step.name == name) {
                Some(step) => chosen.push(step),
                None => return Err(format!("unknown command `{name}`")),
            },
        }
    }
    toolchain::choice()?;
    if chosen.is_empty() {
        return Err("no command given".into());
    }
    Ok(Request::Run(chosen, options))
}

/// The text of `cargo xtask help`.
pub fn usage() -> String {
    let mut text = String::from("Usage: cargo xtask <command>... [--strict] [--json FILE]\n\nCommands:\n");
    let mut line = |name: &str, what: &str| text.push_str(&format!("  {name:<11}{what}\n"));
    line("test", "that it works here, in eight minutes: the five steps from `libraries` on; goes on after a failure");
    line("  --all", "everything, in 40 minutes: the steps from `fmt` to `msrv`");
    for step in quick::STEPS.iter().chain(STEPS).chain(OTHERS) {
        line(step.name, step.what);
    }
    line("doctor", "says which of the programs that steps need are here; changes nothing");
    line("help", "this text");
    text.push_str("\nOptions:\n  --all        after `python`: its studies too; after `logs`: rerun too\n  --strict     a step that could not check everything makes the run a failure\n  --json FILE  where `budget` writes its figures, as a list of flat objects, or `bench`,\n               \
         as a list of objects {name, value, unit}\n");
    text.push_str(&format!(
        "\nEnvironment:\n  {}=rustup|debian\n          \
         the only toolchain the steps for a Cortex-M may use; unset: the first that works of\n          \
         the active toolchain, `rustup target add`, Debian's packages\n\
           {}\n          the folder of the recorded logs; unset: shared/data beside the repository\n\
         \nWhat is not here is unpacked to {}\nor fetched by rustup; where neither is possible the steps that need it are skipped, and the summary counts them.\n\
         \nExit code: 0 no step failed, 1 one failed, or with --strict was not checked in full, 2 wrong usage.\n",
        toolchain::CHOICE_VARIABLE,
        scphd_shared_data::FOLDER,
        debian::cache().display()
    ));
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(words: &[&str]) -> Option<(Vec<&'static str>, Options)> {
        let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
        match parse(&words) {
            Ok(Request::Run(steps, options)) => Some((steps.iter().map(|step| step.name).collect(), options)),
            _ => None,
        }
    }

    fn names(words: &[&str]) -> Option<Vec<&'static str>> {
        run(words).map(|(names, _)| names)
    }

    fn options(words: &[&str]) -> Option<Options> {
        run(words).map(|(_, options)| options)
    }

    #[test]
    fn test_is_quick_without_all() {
        let of = |steps: &[Step]| Some(steps.iter().map(|step| step.name).collect::<Vec<_>>());
        assert_eq!(names(&["test"]), of(quick::STEPS));
        assert_eq!(names(&["test", "--strict"]), of(quick::STEPS));
        assert_eq!(names(&["test", "--all"]), of(STEPS));
    }

    #[test]
    fn only_the_fuzzer_takes_numbers() {
        let numbers = |words: &[&str]| options(words).map(|options| options.numbers);
        assert_eq!(numbers(&["fuzz"]), Some(vec![]));
        assert_eq!(numbers(&["fuzz", "1000", "7", "fmt"]), Some(vec![1000, 7]));
        assert_eq!(numbers(&["fuzz", "1", "2", "3"]), None);
        assert_eq!(numbers(&["fmt", "1000"]), None);
    }

    #[test]
    fn the_c_library_is_installed_in_the_given_folder() {
        let place = |words: &[&str]| options(words).map(|options| options.place);
        let of = |target| Some(capi::Place { prefix: "/x".into(), target });
        assert_eq!(place(&["install-c", "/x"]), of(None));
        assert_eq!(place(&["install-c", "/x", capi::TARGETS[0]]), of(Some(capi::TARGETS[0])));
        assert_eq!(place(&["install-c"]), None);
        assert_eq!(place(&["install-c", "/x", "install-c", "/y"]), None);
        assert_eq!(place(&["fmt", capi::TARGETS[0]]), None);
    }

    #[test]
    fn only_python_and_logs_have_studies() {
        let studies = |words: &[&str]| options(words).is_some_and(|options| options.studies);
        assert!(studies(&["python", "--all"]) && studies(&["logs", "--all"]) && !studies(&["python"]));
        assert!(!studies(&["fmt", "--all"]));
    }

    #[test]
    fn a_run_is_strict_only_when_asked() {
        let strict = |words: &[&str]| options(words).is_some_and(|options| options.strict);
        assert!(strict(&["test", "--strict"]) && strict(&["--strict", "fmt"]) && !strict(&["test"]));
    }

    #[test]
    fn steps_run_in_the_order_given() {
        assert_eq!(names(&["lint", "fmt"]), Some(vec!["lint", "fmt"]));
    }

    #[test]
    fn a_file_for_the_figures_may_be_given() {
        let json = |words: &[&str]| options(words).map(|options| options.json);
        assert_eq!(json(&["budget", "--json", "figures.json"]), Some(Some("figures.json".into())));
        assert_eq!(json(&["budget", "--json"]), None);
        assert_eq!(json(&["--json", "figures.json"]), None);
    }

    #[test]
    fn unknown_and_missing_words_are_errors() {
        assert_eq!((names(&["fmt", "nonsense"]), names(&[])), (None, None));
    }

    #[test]
    fn help_names_every_step() {
        assert!(matches!(parse(&["help".into()]), Ok(Request::Print(text)) if text == usage()));
        let text = usage();
        assert!(STEPS.iter().chain(quick::STEPS).chain(OTHERS).all(|step| text.contains(step.name)));
        assert!(text.contains(toolchain::CHOICE_VARIABLE));
    }
}
