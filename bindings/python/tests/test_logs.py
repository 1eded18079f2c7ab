"""Log folders: what is read, in which order a filter gets it, and what is wrong with others."""

import json
import sys

import numpy as np
import pytest

import scphd
from scphd.logs import Fix, LogError, Move, Scan

HEAD = """
name = "small"
initial_pose = [1.0, 2.0, 0.5]
[vehicle]
model = "unicycle_arc"
[sensor]
model = "range_bearing"
range_max_m = 10.0
bearing_min_rad = -3.15
bearing_max_rad = 3.15
[fixes]
position_sigma_m = 0.5
"""
FILES = {
    "log.toml": HEAD,
    "odometry.csv": "omega_radps,t_s,v_mps\n0.1,0.0,1.0\n0.2,1.0,2.0\n",
    "scans.csv": "scan,t_s\n0,0.0\n1,0.5\n3,1.5\n",
    "detections.csv": "scan,range_m,bearing_rad\n0,5.0,0.1\n3,4.0,-0.1\n0,6.0,1.0\n",
    "fixes.csv": "t_s,x_m,y_m,heading_rad\n0.5,1.5,2.0,\n",
    "truth.csv": "t_s,x_m,y_m\n0.0,1.0,2.0\n",
}
SETTINGS = {
    "filter": {
        "particles": 4, "samples": 1, "birth_intensity": 0.002, "resample_threshold": 0.5,
        "prune_weight": 1e-3, "confirming_detections": 1.0, "unconfirmed_weight": 0.5,
        "confirmed_weight": 0.0, "merge_distance": 4.0, "max_components": 1000, "extraction": "peaks",
        "extraction_weight": 0.0, "proposal": "informed", "proposal_rounds": 3, "proposal_sampled_fraction": 0.2,
        "proposal_min_responsibility": 0.02, "interval_margin": 2.0, "births_wait": False, "likelihood": "single-cluster",
    },
    "vehicle": {
        "speed_sigma_mps": 0.1, "speed_sigma_ratio": 0.1, "turn_sigma": 0.02, "turn_sigma_ratio": 0.1, "noise_interval_s": 1.0,
    },
    "sensor": {
        "range_sigma_m": 0.1, "bearing_sigma_rad": 0.02, "range_min_m": 0.0, "range_max_m": 10.0, "range_edge_m": 0.1,
        "bearing_min_rad": -3.15, "bearing_max_rad": 3.15, "bearing_edge_rad": 0.0, "detection_near": 0.9,
        "detection_far": 0.9, "clutter_per_scan": 1.0, "forward_m": 0.0, "left_m": 0.0, "yaw_rad": 0.0,
    },
    "moving": {
        "birth_intensity": 0.0, "velocity_sigma_mps": 1.0, "acceleration_psd": 0.1, "lifetime_s": 100.0,
        "spread_max_m": 3.0, "extraction_weight": 0.5,
    },
    "joint": {"visible_s": 1e9, "occluded_s": 1.0, "lifetime_s": 1e9, "occlusion_factor": 1.0, "merge_distance": 9.0},
    "fixes": {"position_sigma_m": 0.5},
}  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def test_what_is_read(folder):
    log = scphd.logs.read(folder)
    assert log.name == "small" and list(log.initial_pose) == [1.0, 2.0, 0.5] and list(log.sensors) == [""]
    assert log.odometry.tolist() == [[0.0, 1.0, 0.1], [1.0, 2.0, 0.2]]
    assert [scan.t_s for scan in log.scans] == [0.0, 0.5, 1.5]
    assert log.scans[0].measurements.tolist() == [[5.0, 0.1], [6.0, 1.0]]
    assert log.scans[1].measurements.shape == (0, 2)
    assert log.truth[0, :3].tolist() == [0.0, 1.0, 2.0] and np.isnan(log.truth[0, 3])


def test_the_order_of_events(folder):
    """Scan 0 is seen from the start, a fix comes before a scan of its time, and rows are split at scans."""
    events = list(scphd.logs.read(folder).events())
    assert [type(event) for event in events] == [Scan, Move, Fix, Scan, Move, Move, Scan]
    moves = [(event.control.tolist(), event.dt_s) for event in events if isinstance(event, Move)]
    assert moves == [([1.0, 0.1], 0.5), ([1.0, 0.1], 0.5), ([2.0, 0.2], 0.5)]


@pytest.mark.parametrize("kind", ["joint", "mixture"])
def test_a_run(folder, kind):
    run = scphd.logs.read(folder).run(SETTINGS, kind=kind)
    assert run.t_s.tolist() == [0.0, 0.5, 1.5] and run.poses.shape == (3, 3) and run.covariances.shape == (3, 3, 3)
    assert run.poses[0] == pytest.approx([1.0, 2.0, 0.5], abs=0.2) and run.refused == 0 and len(run.health) == 3
    again = scphd.logs.read(folder).run(SETTINGS, kind=kind)
    assert run.digest == again.digest and np.array_equal(run.poses, again.poses)


def test_a_run_with_features_that_move(folder):
    log = scphd.logs.read(folder)
    with_movers = log.run({**SETTINGS, "moving": {**SETTINGS["moving"], "birth_intensity": 0.1}})
    assert with_movers.digest != log.run(SETTINGS).digest


def test_noise_that_grows_with_the_range(folder):
    log = scphd.logs.read(folder)
    digests = {log.run({**SETTINGS, "sensor": {**SETTINGS["sensor"], **ratio}}).digest
               for ratio in ({}, {"range_sigma_ratio": 0.0}, {"range_sigma_ratio": 0.1})}  # fmt: skip
    assert len(digests) == 2


def test_settings_by_default(folder, tmp_path, monkeypatch):
    log = scphd.logs.read(folder)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    with pytest.raises(LogError, match="install scphd-sim"):
        log.run()
    written = "\n".join(f"[{name}]\n" + "\n".join(f"{key} = {json.dumps(value)}" for key, value in section.items())
                        for name, section in SETTINGS.items())  # fmt: skip
    program = tmp_path / "bin" / "scphd-sim"
    program.parent.mkdir()
    (tmp_path / "printed.toml").write_text(written)
    program.write_text(f"#!{sys.executable}\nimport sys\nassert sys.argv[1:] == ['settings', {str(folder)!r}]\n"
                       f"print(open({str(tmp_path / 'printed.toml')!r}).read())\n")  # fmt: skip
    program.chmod(0o755)
    assert log.run().digest == log.run(SETTINGS).digest
    program.write_text(f"#!{sys.executable}\nimport sys\nsys.exit('no such log')\n")
    with pytest.raises(LogError, match="settings: no such log"):
        log.run()


def test_a_holonomic_vehicle(folder):
    (folder / "log.toml").write_text(HEAD.replace("unicycle_arc", "holonomic"))
    (folder / "odometry.csv").write_text("t_s,vx_mps,vy_mps,omega_radps\n0.0,0.0,1.0,0.0\n")
    (folder / "detections.csv").write_text("scan,range_m,bearing_rad\n")
    (folder / "fixes.csv").unlink()
    pose = scphd.logs.read(folder).run(SETTINGS).poses[-1]
    assert pose == pytest.approx([1.0 - 1.5 * np.sin(0.5), 2.0 + 1.5 * np.cos(0.5), 0.5], abs=1e-5)


def test_calibration(folder):
    log = scphd.logs.read(folder)
    chosen = {"speed_scale_sigma": 0.1, "turn_scale_sigma": 0.1, "turn_offset_sigma": 0.01, "lasts_s": 1e9}
    slam, *_ = log.filter({**SETTINGS, "calibration": chosen})
    assert slam.odometry() is not None and log.filter(SETTINGS)[0].odometry() is None


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("log.toml", None, "log.toml: missing"),
        ("log.toml", "name = ", "log.toml: "),
        ("log.toml", "name = 'x'", "log.toml: initial_pose: missing"),
        ("log.toml", HEAD.replace("unicycle_arc", "boat"), "vehicle.model: 'boat' is none of"),
        ("log.toml", HEAD.replace("[sensor]", "[eye]"), "sensor: missing"),
        ("odometry.csv", None, "odometry.csv: missing"),
        ("odometry.csv", "", "odometry.csv: empty"),
        ("odometry.csv", "t_s,v_mps\n0,1\n", "odometry.csv: no column omega_radps"),
        ("odometry.csv", "t_s,v_mps,omega_radps\n0,1,0\n1,fast,0\n", "odometry.csv, row 3, column v_mps: 'fast' is no number"),
        ("odometry.csv", "t_s,v_mps,omega_radps\n0,nan,0\n", "'nan' is no number"),
        ("scans.csv", "scan,t_s\n0\n", "scans.csv, row 2: 1 cells, not 2"),
        ("detections.csv", "scan,range_m,bearing_rad\n0,5,\n", "column bearing_rad: '' is no number"),
    ],
)
def test_what_is_wrong(folder, name, text, message):
    if text is None:
        (folder / name).unlink()
    else:
        (folder / name).write_text(text)
    with pytest.raises(LogError) as raised:
        scphd.logs.read(folder)
    assert message in str(raised.value)


def test_settings_that_python_does_not_have(folder):
    log = scphd.logs.read(folder)
    with pytest.raises(LogError, match="other likelihoods"):
        log.run({**SETTINGS, "filter": {**SETTINGS["filter"], "likelihood": "rb-empty"}})
    with pytest.raises(LogError, match="how good these fixes are"):
        log.run({**SETTINGS, "fixes": {}})
    with pytest.raises(ValueError, match="kind must be"):
        log.run(SETTINGS, kind="ekf")
    with pytest.raises(LogError, match="missing"):
        log.run(folder / "settings.toml")
