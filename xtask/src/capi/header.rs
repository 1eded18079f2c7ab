//! The header: generated and compared.

use super::workspace::{cargo, tools_dir};
use crate::{files, process};
use std::collections::BTreeSet;
use std::path::PathBuf;

pub fn path() -> PathBuf {
    process::root().join("bindings/capi/include/scphd.h")
}

pub fn text() -> Result<String, String> {
    files::text(&path())
}

pub fn functions() -> Result<BTreeSet<String>, String> {
    Ok(declared(&text()?))
}

fn declared(header: &str) -> BTreeSet<String> {
    let code = header.lines().filter(|line| !line.trim_start().starts_with("//") && !line.starts_with(['#', ' ']));
    let names = code.filter_map(|line| line.split_once('(')?.0.rsplit([' ', '*']).next());
    names.filter(|name| name.starts_with("scphd_")).map(str::to_owned).collect()
}

/// Fails if the generated header differs from the committed one; in blessing mode, writes it.
pub fn check() -> Result<(), String> {
    let dir = tools_dir();
    let made = dir.join("scphd.h");
    let mut cargo = cargo("run");
    process::run(cargo.args(["--package", "scphd-header", "--"]).arg(&made))?;
    let text = files::text(&made)?;
    if process::is_blessing() {
        return files::write(&path(), text);
    }
    if text == self::text()? {
        Ok(())
    } else {
        Err("bindings/capi/include/scphd.h is not what the crate makes; SCPHD_BLESS=1 writes it".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_distinguished_from_comments() {
        let header = "// Calls scphd_other(x).\n#define SCPHD_X(a) a\nconst char *scphd_text(int32_t status);\n\
                      scphd_status scphd_start(uint32_t version,\n                         int (*scphd_hook)(void));\n";
        assert_eq!(declared(header).into_iter().collect::<Vec<_>>(), ["scphd_start", "scphd_text"]);
        assert!(functions().unwrap().contains("scphd_slam_scan_range_bearing"));
    }
}
