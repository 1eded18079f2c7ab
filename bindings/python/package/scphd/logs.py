"""Log folders of the simulator: read into arrays, and run by a filter.

A log is a folder: `log.toml`, `odometry.csv`, `scans.csv`, `detections.csv` and perhaps `fixes.csv` and `truth.csv`, in metres, seconds and
radians. `docs/logs.md` has the details. The settings are those that `scphd-sim settings FOLDER` prints: a run in Python ends in the
digest of `scphd-sim replay FOLDER`.

    log = scphd.logs.read("example")
    run = log.run()
    run.poses, run.covariances, run.digest
"""

from __future__ import annotations

import csv
import math
import pathlib
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import NDArray

from ._native import (
    Ackermann,
    Filter,
    HeadingFix,
    Holonomic,
    JointFilter,
    Map,
    Mounting,
    PositionFix,
    RangeBearing,
    Unicycle,
)

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["Fix", "Log", "LogError", "Move", "Run", "Scan", "read"]

Vector = NDArray[np.float64]
PathLike = Union[str, pathlib.Path]


class LogError(ValueError):
    """A folder that is no log: the text names file, row and column, or key."""


@dataclass(frozen=True)
class Move:
    """The vehicle has moved."""

    control: Vector  #: (2,): speed m/s, steering angle rad or turn rate rad/s; holonomic (3,): speeds ahead and to the left m/s, turn rate
    dt_s: float  #: duration, s


@dataclass(frozen=True)
class Fix:
    """The pose itself was measured."""

    t_s: float
    position_m: Vector | None  #: (2,), or None
    heading_rad: float | None


@dataclass(frozen=True)
class Scan:
    """A scan was taken."""

    t_s: float
    sensor: str  #: its name; empty where there is one alone
    measurements: Vector  #: (n, 2): range m, bearing rad


@dataclass
class Run:
    """What a filter made of a log: one row a scan."""

    t_s: Vector  #: (n,)
    poses: NDArray[np.float32]  #: (n, 3): x m, y m, heading rad
    covariances: NDArray[np.float32]  #: (n, 3, 3)
    health: list[list[str]]  #: n lists of names of conditions
    ln_evidence: float  #: of all scans
    refused: int  #: rows of the odometry that no vehicle follows, which were left out
    map: Map  #: at the end
    digest: int  #: of the final state


@dataclass
class Log:
    """A log in memory. Numbers are as they are written."""

    name: str
    initial_pose: Vector  #: (3,): x m, y m, heading rad
    vehicle: dict[str, Any]  #: the section of `log.toml`
    sensors: dict[str, dict[str, Any]]  #: sections by name; the only one has the name ''
    odometry: Vector  #: (n, 3) or (n, 4): t s, and the control as in `Move`
    scans: list[Scan]
    fixes: list[Fix] = field(default_factory=list)
    fix_noise: dict[str, Any] = field(default_factory=dict)
    truth: Vector | None = None  #: (n, 4): t s, x m, y m, heading rad (NaN where unknown)
    folder: pathlib.Path | None = None  #: where it was read

    def events(self) -> Iterator[Move | Fix | Scan]:
        """Odometry, fixes and scans in the order in which a filter needs them, up to the last scan.

        A row of the odometry holds until the next one; before the first, nothing moves. What is seen or measured at the time of a row comes
        before any motion by it, and a fix before a scan of the same time.
        """
        rows, scans, fixes = 0, 0, 0
        times = self.odometry[:, 0]
        now = min([*times[:1], *(scan.t_s for scan in self.scans[:1])], default=0.0)
        while scans < len(self.scans):
            due = self.scans[scans].t_s
            while rows < len(times) and times[rows] <= now:
                rows += 1
            fix = self.fixes[fixes] if fixes < len(self.fixes) and self.fixes[fixes].t_s <= due else None
            if fix is not None and fix.t_s <= now:
                fixes += 1
                yield fix
            elif due <= now:
                scans += 1
                yield self.scans[scans - 1]
            else:
                until = min([due if fix is None else fix.t_s, *times[rows : rows + 1]])
                dt_s, now = until - now, until
                if rows > 0:
                    yield Move(self.odometry[rows - 1, 1:], float(dt_s))

    def filter(
        self, settings: PathLike | dict[str, Any] | None = None, kind: Literal["joint", "mixture"] = "joint", seed: int = 0
    ) -> tuple[Filter | JointFilter, dict[str, RangeBearing], tuple[PositionFix | None, HeadingFix | None]]:
        """A filter at the start of this log, its detectors by name, and its fixes.

        `settings` is a file as `scphd-sim settings` prints it, or its content; by default that program is run. A setting that the
        package does not have is an error.
        """
        if settings is None:
            settings = _default_settings(self.folder)
        chosen = settings if isinstance(settings, dict) else _toml(pathlib.Path(settings))
        recursion, moving = chosen["filter"], chosen["moving"]
        if recursion["likelihood"] != "single-cluster":
            raise LogError("settings: other likelihoods are in the simulator alone")
        margin = recursion["interval_margin"] if kind == "mixture" else 1.0
        vehicle = self._vehicle(chosen["vehicle"], margin)
        slam: Filter | JointFilter
        if kind == "mixture":
            slam = _mixture(vehicle, recursion, moving)
            slam.reset(*self.initial_pose, seed=seed)
        elif kind == "joint":
            movers = {"movers": True, **_movers(moving)} if moving["birth_intensity"] > 0.0 else {}
            slam = JointFilter(vehicle, **movers, **_calibration(chosen.get("calibration")), **chosen["joint"])
            slam.reset(*self.initial_pose)
        else:
            raise ValueError(f"kind must be 'joint' or 'mixture', not {kind!r}")
        sections = chosen["sensors"] if "sensors" in chosen else {"": chosen["sensor"]}
        detectors = {name: _detector(section, recursion, moving) for name, section in sections.items()}
        return slam, detectors, _fixes(chosen.get("fixes", {}))

    def run(
        self, settings: PathLike | dict[str, Any] | None = None, kind: Literal["joint", "mixture"] = "joint", seed: int = 0
    ) -> Run:
        """Runs a filter over the whole log: the joint map, or the mixture with the random numbers of a seed."""
        slam, detectors, (position, heading) = self.filter(settings, kind, seed)
        times, poses, covariances, health = [], [], [], []
        ln_evidence, refused = 0.0, 0
        for event in self.events():
            if isinstance(event, Move):
                try:
                    slam.predict(event.control, event.dt_s)
                except ValueError:
                    refused += 1
            elif isinstance(event, Fix):
                # A row may have both; the position is first.
                for fix, measured in ((position, event.position_m), (heading, event.heading_rad)):
                    if measured is not None:
                        if fix is None:
                            raise LogError("settings: the section 'fixes' does not say how good these fixes are")
                        slam.observe(fix, measured)
            else:
                report = slam.scan(detectors[event.sensor], event.measurements)
                pose = slam.estimate()
                times.append(event.t_s)
                poses.append(pose.mean)
                covariances.append(pose.covariance)
                health.append(report.health.names)
                ln_evidence += report.ln_evidence
        digest = slam.digest()
        return Run(
            np.array(times), np.array(poses), np.array(covariances), health, ln_evidence, refused, slam.map(), digest
        )

    def _vehicle(self, noise: dict[str, float], margin: float) -> Unicycle | Ackermann | Holonomic:
        known = {key: noise[key] for key in ("speed_sigma_mps", "speed_sigma_ratio", "turn_sigma", "turn_sigma_ratio")}
        known["noise_interval_s"] = noise["noise_interval_s"] * margin
        model = self.vehicle["model"]
        if model == "ackermann":
            return Ackermann(
                wheelbase_m=self.vehicle["wheelbase_m"],
                encoder_offset_m=self.vehicle.get("encoder_offset_m", 0.0),
                pose_forward_m=self.vehicle.get("sensor_forward_m", 0.0),
                pose_left_m=self.vehicle.get("sensor_left_m", 0.0),
                **known,
            )
        if model == "holonomic":
            return Holonomic(**known)
        step: Literal["arc", "euler"] = "arc" if model == "unicycle_arc" else "euler"
        return Unicycle(step=step, **known)


def _mixture(vehicle: Unicycle | Ackermann | Holonomic, recursion: dict[str, Any], moving: dict[str, float]) -> Filter:
    same = (
        "particles samples resample_threshold prune_weight confirming_detections unconfirmed_weight confirmed_weight merge_distance "
        "extraction extraction_weight births_wait proposal"
    )
    chosen = {key: recursion[key] for key in same.split()}
    if recursion["max_components"] < 2**32:
        chosen["max_components"] = recursion["max_components"]
    if recursion["proposal"] == "informed":
        for key in ("rounds", "sampled_fraction", "min_responsibility"):
            chosen[f"informed_{key}"] = recursion[f"proposal_{key}"]
    return Filter(vehicle, **_movers(moving), **chosen)


def _movers(moving: dict[str, float]) -> dict[str, Any]:
    return {f"moving_{key}": value for key, value in moving.items() if key != "birth_intensity"}


def _calibration(chosen: dict[str, float] | None) -> dict[str, Any]:
    if chosen is None:
        return {}
    sigmas = {f"odometry_{key}": chosen[f"{key}_sigma"] for key in ("speed_scale", "turn_scale", "turn_offset")}
    return {"odometry": True, **sigmas, "odometry_lasts_s": chosen["lasts_s"]}


def _default_settings(folder: pathlib.Path | None) -> dict[str, Any]:
    program = shutil.which("scphd-sim")
    if folder is None or program is None:
        raise LogError("settings: give a file, or install scphd-sim, which has the default settings of a log")
    printed = subprocess.run([program, "settings", str(folder)], capture_output=True, text=True, check=False)
    if printed.returncode != 0:
        raise LogError(f"scphd-sim settings: {printed.stderr.strip()}")
    return tomllib.loads(printed.stdout)


def _detector(section: dict[str, float], recursion: dict[str, Any], moving: dict[str, float]) -> RangeBearing:
    least, greatest = section["bearing_min_rad"], section["bearing_max_rad"]
    factor = section.get("birth_factor", 1.0)
    same = "range_sigma_m bearing_sigma_rad range_min_m range_max_m range_edge_m bearing_edge_rad clutter_per_scan"
    return RangeBearing(
        range_sigma_ratio=section.get("range_sigma_ratio", 0.0),
        bearing_center_rad=0.5 * (least + greatest),
        bearing_half_width_rad=0.5 * (greatest - least),
        probability=section["detection_near"],
        probability_far=section["detection_far"],
        births_still=factor * recursion["birth_intensity"],
        births_moving=factor * moving["birth_intensity"],
        mounting=Mounting(forward_m=section["forward_m"], left_m=section["left_m"], yaw_rad=section["yaw_rad"]),
        **{key: section[key] for key in same.split()},
    )


def _fixes(noise: dict[str, float]) -> tuple[PositionFix | None, HeadingFix | None]:
    position, heading = noise.get("position_sigma_m"), noise.get("heading_sigma_rad")
    gate = noise.get("gate", 25.0)
    forward, left = noise.get("forward_m", 0.0), noise.get("left_m", 0.0)
    return (
        None
        if position is None
        else PositionFix(sigma_m=position, gate=gate, antenna_forward_m=forward, antenna_left_m=left),
        None if heading is None else HeadingFix(sigma_rad=heading, gate=gate),
    )


_CONTROLS = {
    "ackermann": ("speed_mps", "steering_rad"),
    "unicycle": ("v_mps", "omega_radps"),
    "unicycle_arc": ("v_mps", "omega_radps"),
    "holonomic": ("vx_mps", "vy_mps", "omega_radps"),
}


def read(folder: PathLike) -> Log:
    """Reads a folder. Raises LogError if a file or key is missing or a cell is not a number; `scphd-sim check` finds wrong units."""
    folder = pathlib.Path(folder)
    head = _toml(folder / "log.toml")
    for key in ("initial_pose", "vehicle"):
        if key not in head:
            raise LogError(f"log.toml: {key}: missing")
    vehicle = head["vehicle"]
    columns = _CONTROLS.get(vehicle.get("model"))
    if columns is None:
        raise LogError(f"log.toml: vehicle.model: {vehicle.get('model')!r} is none of {', '.join(_CONTROLS)}")
    if "sensors" in head:
        sensors = {section["name"]: section for section in head["sensors"]}
    elif "sensor" in head:
        sensors = {"": head["sensor"]}
    else:
        raise LogError("log.toml: sensor: missing")
    truth = _table(folder, "truth.csv", ("t_s", "x_m", "y_m"), ("heading_rad",)) if (folder / "truth.csv").exists() else None
    fixes = []
    if (folder / "fixes.csv").exists():
        for t_s, x_m, y_m, heading in _table(folder, "fixes.csv", ("t_s",), ("x_m", "y_m", "heading_rad")):
            place = None if math.isnan(x_m) else np.array([x_m, y_m])
            fixes.append(Fix(t_s, place, None if math.isnan(heading) else heading))
    return Log(
        name=str(head.get("name", folder.name)),
        initial_pose=np.asarray(head["initial_pose"], dtype=float),
        vehicle=vehicle,
        sensors=sensors,
        odometry=_table(folder, "odometry.csv", ("t_s", *columns)),
        scans=_scans(folder, sensors),
        fixes=fixes,
        fix_noise=head.get("fixes", {}),
        truth=truth,
        folder=folder,
    )


def _scans(folder: pathlib.Path, sensors: dict[str, Any]) -> list[Scan]:
    header, rows = _rows(folder, "scans.csv")
    number, t_s = _column(header, "scans.csv", "scan"), _column(header, "scans.csv", "t_s")
    of = _column(header, "scans.csv", "sensor") if "" not in sensors else None
    detections = _table(folder, "detections.csv", ("scan", "range_m", "bearing_rad"))
    by_scan: dict[int, list[Vector]] = {}
    for row in detections:
        by_scan.setdefault(int(row[0]), []).append(row[1:])
    scans = []
    for place, row in enumerate(rows):
        sensor = "" if of is None else row[of]
        if sensor not in sensors:
            raise LogError(f"scans.csv, row {place + 2}, column sensor: there is no sensor {sensor!r}")
        seen = by_scan.get(int(_number(row[number], "scans.csv", place, "scan")), [])
        scans.append(Scan(_number(row[t_s], "scans.csv", place, "t_s"), sensor, np.array(seen).reshape(-1, 2)))
    return scans


def _toml(path: pathlib.Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise LogError(f"{path}: missing") from None
    except tomllib.TOMLDecodeError as error:
        raise LogError(f"{path}: {error}") from None


def _rows(folder: pathlib.Path, name: str) -> tuple[list[str], list[list[str]]]:
    try:
        with open(folder / name, encoding="utf-8", newline="") as file:
            rows = [[cell.strip() for cell in row] for row in csv.reader(file) if row]
    except FileNotFoundError:
        raise LogError(f"{folder / name}: missing") from None
    if not rows:
        raise LogError(f"{name}: empty")
    for place, row in enumerate(rows[1:]):
        if len(row) != len(rows[0]):
            raise LogError(f"{name}, row {place + 2}: {len(row)} cells, not {len(rows[0])}")
    return rows[0], rows[1:]


def _column(header: list[str], name: str, column: str) -> int:
    if column not in header:
        raise LogError(f"{name}: no column {column}")
    return header.index(column)


def _number(cell: str, name: str, place: int, column: str) -> float:
    try:
        number = float(cell)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise LogError(f"{name}, row {place + 2}, column {column}: {cell!r} is no number")
    return number


def _table(folder: pathlib.Path, name: str, columns: tuple[str, ...], optional: tuple[str, ...] = ()) -> Vector:
    """Columns by name, of shape (n, number of columns). An optional one may be missing, and its cells empty: NaN."""
    header, rows = _rows(folder, name)
    places = [_column(header, name, column) for column in columns]
    table = [[_number(row[at], name, place, header[at]) for at in places] for place, row in enumerate(rows)]
    for column in optional:
        at = header.index(column) if column in header else None
        for place, row in enumerate(rows):
            cell = "" if at is None else row[at]
            table[place].append(_number(cell, name, place, column) if cell else math.nan)
    return np.array(table, dtype=float).reshape(len(rows), len(columns) + len(optional))
