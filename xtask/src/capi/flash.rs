//! Compares the flash of the loop of `docs/c.md` with each set with the table of that page.

use crate::firmware::image::Image;
use crate::{files, process};
use std::path::Path;
use std::process::Command;

/// Greatest ratio of the figure on the page and the measured one, in both directions, as for budgets.
const MARGIN: f64 = 1.2;

/// The sets of the page and their KB, with and without a floating-point unit. A set under water has other functions, and is not
/// checked here.
fn claimed() -> Result<Vec<(String, [f64; 2])>, String> {
    let text = files::text(&process::root().join("docs/c.md"))?;
    let rows = text.lines().filter(|line| line.starts_with("| `") && !line.starts_with("| `WATER"));
    Ok(rows.filter_map(claim).collect())
}

/// A row of the table: its first set, and the last column.
fn claim(row: &str) -> Option<(String, [f64; 2])> {
    let set = row.split('`').nth(1)?;
    let (hard, soft) = row.trim_end_matches([' ', '|']).rsplit('|').next()?.trim().split_once(", ")?;
    Some((set.to_owned(), [hard.parse().ok()?, soft.parse().ok()?]))
}

/// Builds the loop with every set of the page and the archive in `dir`. `column` is 0 with a floating-point unit and 1 without;
/// `compile` returns a command that compiles and links for the processor.
pub fn check(dir: &Path, column: usize, compile: impl Fn() -> Result<Command, String>) -> Result<(), String> {
    let sets = claimed()?;
    if sets.len() < 4 {
        return Err(format!("docs/c.md has only {} sets with flash", sets.len()));
    }
    let without = flash(dir, compile()?, None)?;
    for (set, claims) in sets {
        let measured = (flash(dir, compile()?, Some(&set))? - without) as f64 / 1000.0;
        let claim = claims[column];
        println!("{set}: {measured:.1} KB of flash, docs/c.md says {claim}");
        if measured > MARGIN * claim || claim > MARGIN * measured {
            return Err(format!("docs/c.md says that {set} takes {claim} KB of flash, and it takes {measured:.1}"));
        }
    }
    Ok(())
}

/// Flash of a program with this set, or without a filter, bytes.
fn flash(dir: &Path, mut compile: Command, set: Option<&str>) -> Result<u64, String> {
    let (tests, examples) = ("bindings/capi/tests/c", "bindings/capi/examples");
    let path = dir.join("flash.elf");
    compile.arg(process::root().join(tests).join("flash.c"));
    if let Some(set) = set {
        compile.arg("-DWITH_FILTER").arg(process::root().join(examples).join("loop.c"));
        if set != "JOINT_40" {
            compile.arg(format!("-Dscphd_start_joint_40=scphd_start_{}", set.to_lowercase()));
        }
        compile.arg(dir.join(super::archive::NAME));
    }
    process::run_or_quote(compile.arg("-o").arg(&path))?;
    let elf = files::bytes(&path)?;
    let sizes = Image { path, elf }.sizes()?;
    Ok(sizes.text + sizes.rodata)
}

#[cfg(test)]
mod tests {
    use super::{claim, claimed};

    #[test]
    fn rows_are_read() {
        let row = "| `JOINT_40`, `JOINT_100` | `JointSlam` | 21 504, 94 208 | 80, 83 |";
        assert_eq!(claim(row), Some(("JOINT_40".to_owned(), [80.0, 83.0])));
        assert_eq!(claim("| `DESCRIPTION` | a description | 640 | in the above |"), None);
        assert!(claimed().unwrap().len() >= 6);
    }
}
