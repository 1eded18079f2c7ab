"""The same inputs give the same bits as the library without Python, and as the C interface, whose check replays the same file."""

import os
import pathlib

import numpy as np
import pytest

import scphd

# Places of the holonomic vehicle and of the cars among the filters.
SIDEWAYS, CARS = 7, (8, 9)
SEAT = scphd.Mounting(forward_m=0.22, yaw_rad=0.5)
BACK = scphd.Mounting(forward_m=-0.3, left_m=0.1, yaw_rad=3.0)


def single(*numbers):
    """Sums and products of settings are made in single precision, as in the other languages."""
    product = np.float32(1.0)
    for number in numbers:
        product = product * np.float32(number)
    return float(product)


def detectors():
    lidar = scphd.RangeBearing(
        range_sigma_m=0.05, bearing_sigma_rad=0.01, range_max_m=12.0, range_edge_m=single(3, 0.05),
        bearing_edge_rad=single(3, 0.01), bearing_half_width_rad=2.0, probability=0.85, clutter_per_scan=2.0,
        births_still=0.002, births_moving=0.001, mounting=SEAT,
    )
    radar = scphd.RangeBearing(
        range_sigma_m=0.2, range_sigma_ratio=0.02, bearing_sigma_rad=0.03, range_max_m=20.0,
        range_edge_m=single(3, 0.2), bearing_edge_rad=single(3, 0.03), bearing_half_width_rad=0.8, probability=0.85,
        clutter_per_scan=1.0, births_still=0.003, mounting=BACK,
    )
    camera = scphd.BearingOnly(
        bearing_sigma_rad=0.02, range_max_m=12.0, bearing_half_width_rad=2.0, probability=0.85, births_nearest_m=2.0,
        births_rings=3, births_sectors=16, births_weight=0.0005, mounting=SEAT,
    )
    return lidar, radar, camera


def filters():
    robot = scphd.Unicycle()
    sets = ["PLANE_32X2", "PLANE_INFORMED_4_MOVING"]
    blind = scphd.Filter(robot, proposal="blind", particles=32, samples=2, memory=sets[0])
    informed = scphd.Filter(robot, proposal="informed", particles=4, prune_weight=1e-3, memory=sets[1])
    blind.reset(5.0, 0.0, 1.5, seed=7)
    informed.reset(5.0, 0.0, 1.5, seed=8)
    maps = [
        scphd.JointFilter(robot, memory="JOINT_40"),
        scphd.JointFilter(robot, memory="JOINT_60_MOVERS", movers=True),
        scphd.JointFilter(robot, memory="JOINT_40_ARCHIVE", movers=True, archive=True, archive_reach_m=12.0),
        scphd.JointFilter(robot, memory="JOINT_60_LEARNING", odometry=True),
        scphd.JointFilter(robot, memory="JOINT_24_HYPOTHESES", movers=True, hypotheses=True),
    ]
    car = scphd.Ackermann(wheelbase_m=2.5, encoder_offset_m=0.5, pose_forward_m=3.0, pose_left_m=0.25)
    strict = {"least_existence": 0.01, "least_tentative": 0.1}
    of_others = [
        scphd.JointFilter(scphd.Holonomic(), memory="JOINT_40"),
        scphd.JointFilter(car, memory="JOINT_40"),
        scphd.Filter(car, proposal="informed", particles=4, memory=sets[1]),
        scphd.JointFilter(scphd.Unicycle(step="euler"), memory="JOINT_40", **strict),
    ]
    for joint in (*maps, *of_others):
        joint.reset(5.0, 0.0, 1.5)
    of_others[2].reset(5.0, 0.0, 1.5, seed=10)
    return blind, informed, *maps, *of_others


def control(place, speed, rate):
    """The holonomic vehicle also moves to the left, and a car has a steering angle."""
    if place == SIDEWAYS:
        return [speed, np.float32(0.25) * rate, rate]
    return [speed, np.float32(0.5) * rate if place in CARS else rate]


def take(letter, numbers, each, of):
    """Gives one input to every filter that takes it."""
    lidar, radar, camera = of
    gps = scphd.PositionFix(sigma_m=0.3, gate=25.0, antenna_forward_m=-0.5, antenna_left_m=0.1)
    compass = scphd.HeadingFix(sigma_rad=0.05)
    for place, slam in enumerate(each):
        if letter == "p":
            slam.predict(control(place, *numbers[:2]), numbers[2])
        elif letter in "lr":
            slam.scan(lidar if letter == "l" else radar, numbers.reshape(-1, 2))
        elif letter == "g":
            slam.observe(gps, numbers)
        elif letter == "h":
            slam.observe(compass, numbers[0])
    if letter == "c":
        each[0].scan(camera, numbers)


def replay(path, restart_at=None):
    """The scans after which the states are not those of the file, and how many were compared."""
    each, of = filters(), detectors()
    scans, apart = 0, []
    for line in path.read_text().splitlines():
        letter, _, *words = line.split()
        if letter == "=":
            digests = [slam.digest() for slam in each]
            # The fourth is a diver's, whom Python does not have.
            if digests != [int(word, 16) for word in words[:3] + words[4:]]:
                apart.append(scans)
            scans += 1
            if scans == restart_at:
                snapshots = [slam.snapshot() for slam in each]
                each = filters()
                for slam, snapshot in zip(each, snapshots):
                    slam.restore(snapshot)
        else:
            bits = np.array([int(word, 16) for word in words], dtype=np.uint32)
            take(letter, bits.view(np.float32), each, of)
    return scans, apart


@pytest.fixture
def stream():
    path = os.environ.get("SCPHD_DRIVE")
    if path is None:
        pytest.skip("SCPHD_DRIVE does not name the file that scphd-drive writes: `cargo xtask python` sets it")
    return pathlib.Path(path)


def test_eleven_filters_over_300_scans(stream):
    assert replay(stream) == (300, [])


def test_from_snapshots_in_fresh_filters(stream):
    assert replay(stream, restart_at=150) == (300, [])

