//! Installs the C library: header, archive, and files for pkg-config, CMake and Zephyr.

use super::archive::{self, Builder};
use super::header;
use super::programs::Compiler;
use super::workspace::TARGETS;
use crate::outcome::{Outcome, Stop};
use crate::tools::CMAKE;
use crate::{files, process, toolchain};
use std::path::{Path, PathBuf};

/// Destination and target.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The folder with `include` and `lib`.
    pub prefix: PathBuf,
    /// One of [`TARGETS`]; `None` for the host.
    pub target: Option<&'static str>,
}

/// Builds the archive and installs it.
pub fn install(place: &Place) -> Result<Outcome, Stop> {
    let functions = header::functions()?;
    let dir = match place.target {
        None => archive::make(&Builder::Host, &functions)?,
        Some(target) => archive::make(&Builder::Bare(&toolchain::find_for(&[target])?, target), &functions)?,
    };
    write(&place.prefix, &dir.join(archive::NAME), place.target)?;
    Ok(Outcome::Passed(format!("in {}", place.prefix.display())))
}

const VERSION: &str = env!("CARGO_PKG_VERSION");

fn write(prefix: &Path, archive: &Path, target: Option<&str>) -> Result<(), String> {
    let put = |text: &str, to: &str| files::write(&prefix.join(to), text);
    put(&header::text()?, "include/scphd.h")?;
    files::write(&prefix.join("lib").join(archive::NAME), files::bytes(archive)?)?;
    put(&pkg_config(), "lib/pkgconfig/scphd.pc")?;
    put(CMAKE_CONFIG, "lib/cmake/scphd/scphd-config.cmake")?;
    put(&cmake_version(), "lib/cmake/scphd/scphd-config-version.cmake")?;
    put(ZEPHYR_MODULE, "zephyr/module.yml")?;
    put(ZEPHYR_CMAKE, "zephyr/CMakeLists.txt")?;
    put(&zephyr_kconfig(target), "zephyr/Kconfig")
}

fn pkg_config() -> String {
    format!(
        "prefix=${{pcfiledir}}/../..\n\nName: scphd\nDescription: Single-cluster PHD SLAM in fixed memory\n\
         Version: {VERSION}\nCflags: -I${{prefix}}/include\nLibs: -L${{prefix}}/lib -lscphd\n"
    )
}

/// Uses paths relative to this file, so that the folder can be moved.
const CMAKE_CONFIG: &str = r#"get_filename_component(_scphd_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET scphd::scphd)
  add_library(scphd::scphd STATIC IMPORTED)
  set_target_properties(scphd::scphd PROPERTIES
    IMPORTED_LOCATION "${_scphd_prefix}/lib/libscphd.a"
    INTERFACE_INCLUDE_DIRECTORIES "${_scphd_prefix}/include")
endif()
unset(_scphd_prefix)
"#;

fn cmake_version() -> String {
    format!(
        "set(PACKAGE_VERSION \"{VERSION}\")\nif(PACKAGE_FIND_VERSION VERSION_EQUAL PACKAGE_VERSION)\n  \
         set(PACKAGE_VERSION_EXACT TRUE)\nendif()\nif(NOT PACKAGE_FIND_VERSION VERSION_GREATER PACKAGE_VERSION)\n  \
         set(PACKAGE_VERSION_COMPATIBLE TRUE)\nendif()\n"
    )
}

/// The installed folder is a module of Zephyr: `ZEPHYR_EXTRA_MODULES` names it, `CONFIG_SCPHD=y` adds the library.
const ZEPHYR_MODULE: &str = "name: scphd\nbuild:\n  cmake: zephyr\n  kconfig: zephyr/Kconfig\n";

const ZEPHYR_CMAKE: &str = r#"if(CONFIG_SCPHD)
  zephyr_include_directories(${CMAKE_CURRENT_LIST_DIR}/../include)
  zephyr_library_import(scphd ${CMAKE_CURRENT_LIST_DIR}/../lib/libscphd.a)
endif()
"#;

/// An archive with the other floating-point ABI, or for another processor, would not link.
fn zephyr_kconfig(target: Option<&str>) -> String {
    let needs = match target {
        Some(target) if target == TARGETS[0] => "depends on CPU_CORTEX_M && FP_HARDABI",
        Some(_) => "depends on CPU_CORTEX_M && !FP_HARDABI",
        None => "depends on ARCH_POSIX",
    };
    format!(
        "config SCPHD\n\tbool \"Single-cluster PHD SLAM in fixed memory\"\n\t{needs}\n\thelp\n\t  \
         Pose of the vehicle and map of features, of odometry and\n\t  detections without names. Brings scphd.h and libscphd.a.\n"
    )
}

/// Checks that pkg-config, CMake, and CMake as used by Zephyr find the installed library, if these programs are present.
pub fn check(archive: &Path, c: &Compiler, dir: &Path) -> Result<(), String> {
    let prefix = dir.join("installed");
    write(&prefix, archive, None)?;
    let source = process::root().join("bindings/capi/examples/robot.c");
    match process::read(process::command("pkg-config").arg("--version")) {
        Err(_) => println!("no pkg-config: its file was not tried"),
        Ok(_) => {
            let mut pkg_config = process::command("pkg-config");
            pkg_config.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
            let flags = process::read(pkg_config.args(["--cflags", "--libs", "scphd"]))?;
            let program = dir.join("by-pkg-config");
            let mut compile = c.plain();
            compile.arg(&source).args(flags.split_whitespace()).args(["-lm", "-o"]).arg(&program);
            process::run(&mut compile)?;
            process::run(&mut process::command(program))?;
        }
    }
    match CMAKE.find() {
        None => println!("no cmake: its package was not tried"),
        Some(cmake) => {
            for (name, found_by) in [("cmake", "CMAKE_PREFIX_PATH"), ("zephyr", "ZEPHYR_EXTRA_MODULES")] {
                let build = dir.join(format!("by-{name}"));
                let mut configure = cmake.command();
                configure.arg("-S").arg(process::root().join("bindings/capi/tests").join(name)).arg("-B").arg(&build);
                configure.arg(format!("-D{found_by}={}", prefix.display()));
                process::run(&mut configure)?;
                process::run(cmake.command().arg("--build").arg(&build))?;
                process::run(&mut process::command(build.join("robot")))?;
            }
        }
    }
    Ok(())
}
