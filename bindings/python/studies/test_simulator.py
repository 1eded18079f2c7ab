"""A log that Python runs ends in the digest of `scphd-sim replay` with the same settings."""

import json
import os
import subprocess

import pytest

import scphd


@pytest.fixture(scope="module")
def simulator():
    program = os.environ.get("SCPHD_SIM")
    if program is None:
        pytest.skip("SCPHD_SIM does not name the program: `cargo xtask python --all` sets it")

    def run(*words):
        return subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=True).stdout

    return run


@pytest.mark.parametrize("scenario", ["survey", "survey-fixes", "two-sensors", "worlds", "worlds-mounted"])
@pytest.mark.parametrize("kind", ["joint", "mixture"])
def test_digests_of_whole_logs(simulator, tmp_path, scenario, kind):
    folder, settings, figures = tmp_path / "log", tmp_path / "settings.toml", tmp_path / "figures.json"
    simulator("export", scenario, folder, "--seed", 3)
    settings.write_text(simulator("settings", folder))
    filter_name = {"joint": "joint", "mixture": "core"}[kind]
    simulator("replay", folder, "--filter", filter_name, "--settings", settings, "--seed", 5, "--json", figures)
    wanted = json.loads(figures.read_text())
    run = scphd.logs.read(folder).run(settings, kind=kind, seed=5)
    assert len(run.t_s) == wanted["scans"]
    assert run.digest == int(wanted["digest"], 16)
