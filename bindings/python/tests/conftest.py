"""What tests have in common."""

import numpy as np
import pytest

import scphd


@pytest.fixture
def lidar():
    return scphd.RangeBearing(range_sigma_m=0.05, bearing_sigma_rad=0.01, range_max_m=15.0)


@pytest.fixture
def robot():
    return scphd.Unicycle()


@pytest.fixture(params=["mixture", "joint"])
def slam(request, robot):
    """Either filter, not reset yet."""
    return scphd.Filter(robot) if request.param == "mixture" else scphd.JointFilter(robot)


class World:
    """A robot that goes in a circle among posts, with a lidar that sees all around."""

    def __init__(self, seed=1, posts=12):
        self.draws = np.random.default_rng(seed)
        self.posts = self.draws.uniform(-9.0, 9.0, (posts, 2))
        self.pose = np.array([4.0, 0.0, np.pi / 2])

    def step(self):
        """The odometry of a tenth of a second, with noise, and the scan at its end."""
        speed, rate = 1.0, 0.25
        along = self.pose[2] + 0.05 * rate
        self.pose += 0.1 * np.array([speed * np.cos(along), speed * np.sin(along), rate])
        control = np.array([speed, rate]) * self.draws.normal(1.0, 0.1, 2)
        offset = self.posts - self.pose[:2]
        scan = np.stack([np.hypot(*offset.T), np.arctan2(offset[:, 1], offset[:, 0]) - self.pose[2]], axis=1)
        scan += self.draws.normal(0.0, [0.05, 0.01], scan.shape)
        scan[:, 1] = (scan[:, 1] + np.pi) % (2 * np.pi) - np.pi
        seen = (scan[:, 0] < 15.0) & (self.draws.uniform(size=len(scan)) < 0.9)
        false = [[self.draws.uniform(0.5, 15.0), self.draws.uniform(-np.pi, np.pi)]]
        return control, np.concatenate([scan[seen], false])


@pytest.fixture
def world():
    return World()
