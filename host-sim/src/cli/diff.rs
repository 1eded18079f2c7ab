//! `scphd-sim diff`.

use super::args::DiffArgs;
use super::failure::Failure;
use super::outputs::{check_file, print_beside, write_file};
use scphd_score::results::sink;
use scphd_view::difference::{Difference, Written};
use scphd_view::output::difference;
use scphd_view::report::pair_page;
use std::path::Path;

pub fn diff(args: &DiffArgs) -> Result<(), Failure> {
    for (option, path) in [("--json", &args.json), ("--html", &args.html)] {
        path.as_deref().map_or(Ok(()), |path| check_file(option, path))?;
    }
    let read = |path: &Path| Written::read(path).map_err(Failure::input);
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    let found = Difference::of([&a, &b]);
    if !args.anyway && !found.other_inputs.is_empty() {
        return Err(Failure::input(format_args!(
            "these are not runs over the same inputs ({}); --anyway compares them",
            found.other_inputs.join("; ")
        )));
    }
    let page = args.html.as_ref().map(|_| pair_page(&found, [&a, &b])).transpose().map_err(Failure::input)?;
    if let Some(path) = &args.json {
        difference::write(path, &found)?;
    }
    if let (Some(path), Some(page)) = (&args.html, page) {
        write_file("--html", path, page.as_bytes())?;
    }
    let taken = [&args.json, &args.html].into_iter().flatten().find(|path| sink::is_stdout(path));
    print_beside(taken.map(|path| &**path), &difference::render(&found))
}
