"""A robot that drives in a circle among posts, as arrays: in the place of data of your own.

A drive is what a recording has: the odometry of every tenth of a second, a scan after each, and, since it is simulated, the truth.
"""

from dataclasses import dataclass

import numpy as np

import scphd

DT_S = 0.1
RANGE_SIGMA_M, BEARING_SIGMA_RAD, RANGE_MAX_M = 0.1, 0.02, 15.0
SPEED_SIGMA_RATIO, TURN_SIGMA_RATIO = 0.2, 0.3
CLUTTER_PER_SCAN, PROBABILITY = 3.0, 0.9


@dataclass
class Drive:
    """A recording."""

    start: np.ndarray  #: (3,): x m, y m, heading rad
    controls: np.ndarray  #: (n, 2): speed m/s, turn rate rad/s
    scans: list  #: n arrays of shape (k, 2): range m, bearing rad
    truth: np.ndarray  #: (n, 3): poses after each step
    posts: np.ndarray  #: (m, 2): x m, y m


def drive(seed, scans=400):
    """A drive of so many scans; another place and other errors for every seed."""
    draws = np.random.default_rng(seed)
    posts = draws.uniform(-14.0, 14.0, (25, 2))
    pose = np.array([7.0, 0.0, np.pi / 2])
    start, speed, rate = pose.copy(), 1.5, 1.5 / 7.0
    controls, seen, truth = [], [], []
    for step in range(scans):
        if step % 10 == 0:
            # An error of the odometry lasts for a second.
            shares = draws.normal(1.0, [SPEED_SIGMA_RATIO, TURN_SIGMA_RATIO])
        along = pose[2] + 0.5 * DT_S * rate
        pose = pose + DT_S * np.array([speed * np.cos(along), speed * np.sin(along), rate])
        offset = posts - pose[:2]
        scan = np.stack([np.hypot(*offset.T), np.arctan2(offset[:, 1], offset[:, 0]) - pose[2]], axis=1)
        scan = scan[(scan[:, 0] < RANGE_MAX_M) & (draws.uniform(size=len(scan)) < PROBABILITY)]
        scan = scan + draws.normal(0.0, [RANGE_SIGMA_M, BEARING_SIGMA_RAD], scan.shape)
        false = draws.poisson(CLUTTER_PER_SCAN)
        scan = np.concatenate([scan, draws.uniform([0.0, -np.pi], [RANGE_MAX_M, np.pi], (false, 2))])
        scan[:, 1] = (scan[:, 1] + np.pi) % (2.0 * np.pi) - np.pi
        controls.append(np.array([speed, rate]) * shares)
        seen.append(scan[scan[:, 0] > 0.0])
        truth.append(pose)
    return Drive(start, np.array(controls), seen, np.array(truth), posts)


def models(odometry_sigma_ratio=0.25, clutter_per_scan=CLUTTER_PER_SCAN):
    """The robot and its lidar, as the filter takes them."""
    robot = scphd.Unicycle(
        speed_sigma_ratio=odometry_sigma_ratio, turn_sigma_ratio=odometry_sigma_ratio, noise_interval_s=1.0
    )
    lidar = scphd.RangeBearing(
        range_sigma_m=RANGE_SIGMA_M, bearing_sigma_rad=BEARING_SIGMA_RAD, range_max_m=RANGE_MAX_M,
        range_edge_m=3.0 * RANGE_SIGMA_M, probability=PROBABILITY, clutter_per_scan=clutter_per_scan, births_still=0.002,
    )
    return robot, lidar


def errors_m(poses, truth):
    """How far off each position is, m."""
    return np.hypot(*(np.asarray(poses)[:, :2] - truth[:, :2]).T)
