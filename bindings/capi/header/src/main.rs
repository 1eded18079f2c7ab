//! Writes the C header of the crate `scphd-capi` to the file that the command line names.

use scphd_vehicle::Setting;
use std::error::Error;
use std::path::Path;

/// The beginning of the header.
const TOP: &str = "/*
 * scphd: single-cluster PHD SLAM in fixed memory. Made from the crate scphd-capi by cbindgen; do not edit.
 *
 * The library keeps nothing: a filter and its description live in memory of the user's, SCPHD_SIZE_... bytes, aligned to
 * SCPHD_ALIGNMENT, and zero at first, which is not to be touched or moved while they do. Calls on different memories may run at the
 * same time. Every call says how it ended; what is refused changes nothing. Units are part of the names; angles grow to the left.
 */";

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which file?")?;
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut config = cbindgen::Config::from_file(library.join("cbindgen.toml"))?;
    config.header = Some(TOP.to_owned());
    config.after_includes = Some(sets() + &settings());
    let bindings = cbindgen::Builder::new().with_crate(library).with_config(config).generate()?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    let text = plain_pointers(&String::from_utf8(text)?);
    let end = text.rfind("#ifdef __cplusplus\n}").ok_or("where do the functions end?")?;
    let (functions, after) = text.split_at(end);
    std::fs::write(path, [functions, &starts(), after].concat())?;
    Ok(())
}

/// Prefixes of cbindgen's names for the types of the crate that stand for pointers.
const POINTERS: [&str; 4] = ["In_", "Out_", "Handed_", "Bytes"];

/// Replaces cbindgen's names of pointer types in the header by pointers.
fn plain_pointers(header: &str) -> String {
    let definition = |line: &str| {
        let (target, name) = line.strip_prefix("typedef ")?.strip_suffix(';')?.rsplit_once('*')?;
        let target = target.replace("struct ", "");
        POINTERS.iter().any(|start| name.starts_with(start)).then(|| (format!("{name} "), format!("{target}*")))
    };
    let mut names: Vec<(String, String)> = header.lines().filter_map(definition).collect();
    // Longer names first, so that a name is not replaced within a longer one.
    names.sort_by_key(|(name, _)| std::cmp::Reverse(name.len()));
    let mut text = String::new();
    // Removes each definition with its comment and the empty line after it.
    for paragraph in header.split_inclusive("\n\n") {
        if !paragraph.lines().any(|line| definition(line).is_some()) {
            text += &names.iter().fold(paragraph.to_owned(), |text, (name, pointer)| text.replace(name, pointer));
        }
    }
    text
}

/// The definitions of the sets, which cbindgen does not see because a macro generates them.
fn sets() -> String {
    let mut text = format!(
        "\n/* Alignment of every memory, bytes. */\n#define SCPHD_ALIGNMENT {}\n\n\
         /* A memory of so many bytes, aligned: `static SCPHD_MEMORY(memory, SCPHD_SIZE_JOINT_40);` is zero. */\n\
         #define SCPHD_MEMORY(name, bytes) uint64_t name[(bytes) / 8]\n",
        scphd_capi::scphd_memory_alignment()
    );
    for set in scphd_capi::SETS {
        text += &format!("\n/*{} */\n#define SCPHD_SIZE_{} {}\n", set.about, set.name, set.bytes);
    }
    text
}

/// The definitions of the settings of a description.
fn settings() -> String {
    let mut text = "\n/*\n * Settings of a description, for scphd_description_set: what each is, its unit, and the numbers that it may have.\n */\n".to_owned();
    for setting in Setting::all() {
        let name = format!("SCPHD_{}", setting.name().replace('.', "_").to_uppercase());
        let unit = if setting.unit().is_empty() { String::new() } else { format!(" In {}.", setting.unit()) };
        let range = if setting.choices().is_empty() { format!(" Must be {}.", setting.range()) } else { String::new() };
        text += &format!("\n/* {}{unit}{range} */\n#define {name} {}\n", setting.about(), setting.number());
        for (number, choice) in setting.choices().iter().enumerate() {
            text += &format!("#define {name}_{} {number}\n", choice.to_uppercase());
        }
    }
    text
}

/// The declarations of the functions that start or resume a filter and give its services, which a macro generates too.
fn starts() -> String {
    let mut text = "// Start the filter that is described in this memory, which is zero or was released: `abi_version` is `SCPHD_ABI_VERSION`,\n\
                    // `size_bytes` at least the SCPHD_SIZE_... of the set. The reason may be null. The handle is written to `slam`, or null. Reset\n\
                    // the filter next.\n\
                    //\n\
                    // Those that resume go on with what the same build of this library has left in this memory: after a reset of the processor\n\
                    // that kept it, or in a copy of it. The description may be another, but for particles, samples and proposal of a mixture. What\n\
                    // is found of a mixture is checked, of a joint map taken as it is; it is no checksum, and memory that may have been damaged needs\n\
                    // one.\n\
                    //\n\
                    // Services are the functions that say so above. scphd_services_... of its set provides them for a filter, until this is started or\n\
                    // resumed again. A program that does not call it does not contain them.\n"
        .to_owned();
    for set in scphd_capi::SETS {
        let Some([start, resume, services]) = set.functions else { continue };
        text += &format!("\n//{}\n", set.about);
        for function in [start, resume] {
            let indent = " ".repeat("scphd_status (".len() + function.len());
            text += &format!(
                "scphd_status {function}(uint32_t abi_version, void *memory, size_t size_bytes,\n\
                 {indent}scphd_description *description, scphd_reason *reason, scphd_slam **slam);\n"
            );
        }
        text += &format!("scphd_status {services}(scphd_slam *slam);\n");
    }
    text + "\n"
}
