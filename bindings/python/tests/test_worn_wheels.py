"""A robot whose wheels are 2 % smaller than it takes them to be, set up with the words of docs/python.md."""

import numpy as np
import pytest

import scphd


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_worn_wheels(seed):
    draws = np.random.default_rng(seed)
    posts = draws.uniform(-12.0, 12.0, (40, 2))
    lidar = scphd.RangeBearing(range_sigma_m=0.05, bearing_sigma_rad=0.01, range_max_m=10.0)
    slam = scphd.JointFilter(scphd.Unicycle())
    pose = np.array([6.0, 0.0, np.pi / 2])
    slam.reset(*pose)
    squares, nees = [], []
    for row in range(1, 15001):
        speed, rate, dt_s = 0.8, 0.8 / 6.0, 0.02
        along = pose[2] + 0.5 * rate * dt_s
        pose += dt_s * np.array([speed * np.cos(along), speed * np.sin(along), rate])
        slam.predict(1.02 * np.array([speed, rate]) + draws.normal(0.0, 0.01, 2), dt_s)
        if row % 5:
            continue
        offset = posts - pose[:2]
        scan = np.stack([np.hypot(*offset.T), np.arctan2(offset[:, 1], offset[:, 0]) - pose[2]], axis=1)
        seen = (scan[:, 0] < 10.0) & (draws.uniform(size=len(scan)) < 0.9)
        scan = scan[seen] + draws.normal(0.0, [0.05, 0.01], (seen.sum(), 2))
        scan[:, 1] = (scan[:, 1] + np.pi) % (2 * np.pi) - np.pi
        slam.scan(lidar, scan)
        estimate = slam.estimate()
        off = estimate.mean.astype(float) - pose
        off[2] = (off[2] + np.pi) % (2 * np.pi) - np.pi
        squares.append(off[:2] @ off[:2])
        nees.append(off @ np.linalg.solve(estimate.covariance.astype(float), off) / 3)
    assert np.sqrt(np.mean(squares)) < 0.05
    assert 0.3 < np.mean(nees) < 2.0
