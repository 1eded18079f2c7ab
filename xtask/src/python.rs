//! The Python package: builds a wheel in a virtual environment, runs its tests, and compares its digests with those of Rust.

use crate::outcome::{Missing, Outcome, Stop};
use crate::{capi, files, install, process};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Oldest Python version, as in the wheel.
const OLDEST: (u32, u32) = (3, 10);
const NEEDED: [&str; 3] = ["maturin>=1.9,<2", "numpy>=1.23", "pytest>=8"];
const STUDIES: [&str; 7] =
    ["dask[distributed]", "ipykernel", "matplotlib", "mypy", "nbclient", "nbformat", "stonesoup>=1.7"];

/// Version of a Python that is present and not too old.
pub fn interpreter() -> Result<String, Missing> {
    let said = process::read(process::command("python3").args(["-c", "import sys; print(sys.version.split()[0])"]))
        .map_err(|_| Missing("there is no python3".into()))?;
    let mut numbers = said.split('.').map_while(|number| number.parse().ok());
    match (numbers.next(), numbers.next()) {
        (Some(major), Some(minor)) if (major, minor) >= OLDEST => Ok(said),
        _ => Err(Missing(format!("python3 is {said}, older than {}.{}", OLDEST.0, OLDEST.1))),
    }
}

/// The step: quick tests, and the studies if requested.
pub fn step(studies: bool) -> Result<Outcome, Stop> {
    let environment = Environment::obtain()?;
    environment.equip(&NEEDED)?;
    let stream = capi::stream()?;
    environment.install()?;
    environment.test("bindings/python/tests", ("SCPHD_DRIVE", &stream))?;
    if studies {
        environment.equip(&STUDIES)?;
        environment.test("bindings/python/studies", ("SCPHD_SIM", &simulator()?))?;
    }
    Ok(environment.passed())
}

/// The simulator, with a fast build.
fn simulator() -> Result<PathBuf, String> {
    let folder = process::own_target_dir("python").join("simulator");
    let mut cargo = process::cargo();
    cargo.args(["build", "--quiet", "--release", "--package", "scphd-sim", "--target-dir"]).arg(&folder);
    process::run(cargo.env("CARGO_PROFILE_RELEASE_LTO", "off").env("CARGO_PROFILE_RELEASE_DEBUG", "0"))?;
    Ok(folder.join("release").join("scphd-sim"))
}

/// A virtual environment of this project.
pub struct Environment {
    version: String,
    folder: PathBuf,
}

impl Environment {
    /// The environment for the Python that is present, which is created if necessary.
    pub fn obtain() -> Result<Self, Missing> {
        let version = interpreter()?;
        let environment = Self { folder: process::own_target_dir("python").join(format!("venv-{version}")), version };
        if process::read(environment.python().args(["-m", "pip", "--version"])).is_ok() {
            return Ok(environment);
        }
        let made = environment.make().or_else(|reason| {
            println!("- a virtual environment: {reason}");
            // Debian has the module that creates environments in a separate package.
            install::packages(&["python3-venv"]).and_then(|()| environment.make())
        });
        match made {
            Ok(()) => Ok(environment),
            Err(reason) => Err(Missing(format!("no virtual environment for Python {}: {reason}", environment.version))),
        }
    }

    /// The outcome of a step whose checks passed with it.
    pub fn passed(&self) -> Outcome {
        Outcome::Passed(format!("Python {}", self.version))
    }

    fn make(&self) -> Result<(), String> {
        process::run(process::command("python3").args(["-m", "venv", "--clear"]).arg(&self.folder))
    }

    pub fn program(&self) -> PathBuf {
        self.folder.join("bin").join("python")
    }

    fn python(&self) -> Command {
        let mut python = process::command(self.program());
        // Without packages of the user, and without files written to the sources.
        python.env_remove("PYTHONPATH").env_remove("PYTHONHOME").env("PYTHONDONTWRITEBYTECODE", "1");
        python
    }

    fn pip(&self) -> Command {
        let mut pip = self.python();
        pip.args(["-m", "pip", "--disable-pip-version-check", "install", "--quiet"]);
        pip
    }

    /// Installs missing packages; if the list of installed packages is the same, no network is needed.
    pub fn equip(&self, packages: &[&str]) -> Result<(), Missing> {
        self.equip_with("all", &[], packages)
    }

    /// As `equip`, without dependencies.
    pub fn equip_alone(&self, packages: &[&str]) -> Result<(), Missing> {
        self.equip_with("alone", &["--no-deps"], packages)
    }

    /// There is a separate list for each way and number of packages.
    fn equip_with(&self, way: &str, options: &[&str], packages: &[&str]) -> Result<(), Missing> {
        let list = self.folder.join(format!("equipped-{way}-{}.txt", packages.len()));
        let wanted = packages.join("\n");
        if files::text(&list).is_ok_and(|there| there == wanted) {
            return Ok(());
        }
        process::run(self.pip().args(options).args(packages))
            .and_then(|()| files::write(&list, wanted))
            .map_err(|reason| Missing(format!("pip cannot install {}: {reason}", packages.join(", "))))
    }

    pub fn packages(&self) -> Result<PathBuf, String> {
        let words = ["-c", "import sysconfig; print(sysconfig.get_path('purelib'))"];
        process::read(self.python().args(words)).map(PathBuf::from)
    }

    /// Builds and installs the wheel as a user does, but with the packages that are present, and with less optimisation, which builds
    /// in two thirds of the time: the filter's bits are the same.
    fn install(&self) -> Result<(), String> {
        let mut pip = self.pip();
        pip.args(["--no-deps", "--no-build-isolation", "--force-reinstall", "./bindings/python"]);
        // maturin is in the environment.
        let path = std::env::var_os("PATH").unwrap_or_default();
        let first = [self.folder.join("bin")].into_iter().chain(std::env::split_paths(&path));
        let path = std::env::join_paths(first).map_err(|error| error.to_string())?;
        pip.env("PATH", path).env("CARGO_TARGET_DIR", process::own_target_dir("python").join("build"));
        pip.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1");
        process::run(&mut pip)
    }

    /// Runs the tests in a folder, with an environment variable that names a file.
    fn test(&self, folder: &str, (variable, file): (&str, &Path)) -> Result<(), String> {
        let mut pytest = self.python();
        pytest.args(["-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider"]);
        pytest.args(["-c", "bindings/python/pyproject.toml", folder]);
        process::run(pytest.env(variable, file))
    }
}
