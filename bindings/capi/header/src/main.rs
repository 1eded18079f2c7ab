//! Writes the C header of the crate beside it to the file that the command line names.

use std::error::Error;
use std::path::Path;

/// What stands at the beginning.
const TOP: &str = "/*
 * scphd: single-cluster PHD SLAM in fixed memory. Made from the crate scphd-capi by cbindgen; do not edit.
 *
 * The library keeps nothing: a filter and each of its detectors live in memory of the user's, SCPHD_SIZE_... bytes, aligned to
 * SCPHD_ALIGNMENT, and zero at first, which is not to be touched or moved while they do. Calls on different memories may run at the
 * same time. Every call says how it ended; what is refused changes nothing. Units are part of the names; angles grow to the left.
 */";

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which file?")?;
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut config = cbindgen::Config::from_file(library.join("cbindgen.toml"))?;
    config.header = Some(TOP.to_owned());
    config.after_includes = Some(sets());
    let bindings = cbindgen::Builder::new().with_crate(library).with_config(config).generate()?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    std::fs::write(path, plain_pointers(&String::from_utf8(text)?))?;
    Ok(())
}

/// The types that stand for pointers in the crate, by the beginnings of what cbindgen calls them.
const POINTERS: [&str; 4] = ["In_", "Out_", "Handed_", "Bytes"];

/// The header with pointers in place of the names that cbindgen gives to the types that stand for them.
fn plain_pointers(header: &str) -> String {
    let definition = |line: &str| {
        let (target, name) = line.strip_prefix("typedef ")?.strip_suffix(';')?.rsplit_once('*')?;
        let target = target.replace("struct ", "");
        POINTERS.iter().any(|start| name.starts_with(start)).then(|| (format!("{name} "), format!("{target}*")))
    };
    let mut names: Vec<(String, String)> = header.lines().filter_map(definition).collect();
    // No name is taken for the end of a longer one.
    names.sort_by_key(|(name, _)| std::cmp::Reverse(name.len()));
    let mut text = String::new();
    // A definition goes with the comment before it and the empty line behind it.
    for paragraph in header.split_inclusive("\n\n") {
        if !paragraph.lines().any(|line| definition(line).is_some()) {
            text += &names.iter().fold(paragraph.to_owned(), |text, (name, pointer)| text.replace(name, pointer));
        }
    }
    text
}

/// The sets, which cbindgen does not see: a macro makes them.
fn sets() -> String {
    let mut text = format!(
        "\n/* Alignment of every memory, bytes. */\n#define SCPHD_ALIGNMENT {}\n\n\
         /* A memory of so many bytes, aligned: `static SCPHD_MEMORY(memory, SCPHD_SIZE_JOINT_40);` is zero. */\n\
         #define SCPHD_MEMORY(name, bytes) uint64_t name[(bytes) / 8]\n",
        scphd_capi::scphd_memory_alignment()
    );
    for set in scphd_capi::SETS {
        text += &format!("\n/*{} */\n", set.about);
        text +=
            &format!("#define SCPHD_SET_{} {}\n#define SCPHD_SIZE_{} {}\n", set.name, set.number, set.name, set.bytes);
    }
    text
}
