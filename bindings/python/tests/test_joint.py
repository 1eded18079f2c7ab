"""What a joint map has beside its map: features that move, learnt odometry, an archive, watches, earlier maps, double precision."""

import copy
import pickle

import numpy as np
import pytest

import scphd

LIDAR = {"range_sigma_m": 0.05, "bearing_sigma_rad": 0.01, "range_max_m": 12.0}


def seen(posts, pose, draws, reach_m=12.0):
    """The scan of all posts in reach."""
    offset = posts - pose[:2]
    scan = np.stack([np.hypot(*offset.T), np.arctan2(offset[:, 1], offset[:, 0]) - pose[2]], axis=1)
    scan = scan[scan[:, 0] < reach_m] + draws.normal(0.0, [0.05, 0.01], ((scan[:, 0] < reach_m).sum(), 2))
    scan[:, 1] = (scan[:, 1] + np.pi) % (2 * np.pi) - np.pi
    return scan


def move(pose, speed, rate, dt_s=0.1):
    along = pose[2] + 0.5 * rate * dt_s
    return pose + dt_s * np.array([speed * np.cos(along), speed * np.sin(along), rate])


def ring(slam, lidar, scans=300, scale=1.0, seed=1):
    """Drives a circle among posts by odometry that reads this share of the truth: the pose at the end, and the posts."""
    draws = np.random.default_rng(seed)
    posts, pose = draws.uniform(-9.0, 9.0, (15, 2)), np.array([5.0, 0.0, np.pi / 2])
    slam.reset(*pose)
    for _ in range(scans):
        pose = move(pose, 1.0, 0.2)
        slam.predict(scale * np.array([1.0, 0.2]) + draws.normal(0.0, 0.005, 2), 0.1)
        slam.scan(lidar, seen(posts, pose, draws))
    return pose, posts


def test_features_that_move():
    """A walker crosses among posts: it is a mover with its velocity, and no part of the map."""
    lidar = scphd.RangeBearing(**LIDAR, births_moving=0.002)
    slam = scphd.JointFilter(scphd.Unicycle(), movers=True, moving_velocity_sigma_mps=1.0)
    draws, posts = np.random.default_rng(2), np.array([[4.0, 2.0], [5.0, -3.0], [-4.0, 1.0], [0.0, 6.0]])
    slam.reset()
    for step in range(60):
        walker = np.array([[-3.0 + 0.1 * step, -2.0]])
        slam.predict((0.0, 0.0), 0.1)
        slam.scan(lidar, seen(np.concatenate([posts, walker]), np.zeros(3), draws))
    movers = slam.movers()
    assert len(movers) == 1 and movers.covariances.shape == (1, 4, 4)
    assert movers.positions_m[0] == pytest.approx(walker[0], abs=0.3)
    assert movers.velocities_mps[0] == pytest.approx([1.0, 0.0], abs=0.3)
    assert len(slam.map()) == len(posts)
    assert len(scphd.JointFilter(scphd.Unicycle()).movers()) == 0


def test_learnt_odometry():
    """Odometry that reads 4 % too much is found out."""
    slam = scphd.JointFilter(scphd.Unicycle(), odometry=True, odometry_lasts_s=1e6)
    assert slam.odometry() is None
    pose, _ = ring(slam, scphd.RangeBearing(**LIDAR), scans=600, scale=1.04)
    assert slam.odometry().speed_scale == pytest.approx(-0.04, abs=0.01)
    assert np.hypot(*(slam.estimate().mean[:2] - pose[:2])) < 0.1
    assert "speed_scale=-0.0" in repr(slam.odometry())
    assert scphd.JointFilter(scphd.Unicycle()).odometry() is None


def test_an_archive_keeps_what_the_window_cannot():
    """A corridor with more posts than the window of 40: the map has all of them."""
    lidar = scphd.RangeBearing(**LIDAR)
    slam = scphd.JointFilter(
        scphd.Unicycle(), memory="JOINT_40_ARCHIVE", movers=True, archive=True, archive_reach_m=12.0
    )
    draws, pose = np.random.default_rng(3), np.zeros(3)
    posts = np.stack([np.arange(80) * 1.5, np.where(np.arange(80) % 2, 4.0, -4.0)], axis=1)
    slam.reset()
    for _ in range(1100):
        pose = move(pose, 1.0, 0.0)
        slam.predict(np.array([1.0, 0.0]) + draws.normal(0.0, 0.005, 2), 0.1)
        slam.scan(lidar, seen(posts, pose, draws))
    assert len(slam.map()) > 60
    # A loaded map has to fit the window.
    with pytest.raises(scphd.InputError):
        slam.load_map(slam.map())


def test_a_watch_moves_a_filter_that_is_wrong():
    slam = scphd.JointFilter(scphd.Unicycle())
    gps = scphd.PositionFix(sigma_m=0.1, gate=16.0, watch_patience_s=2.0)
    slam.reset()
    moved = []
    for _ in range(60):
        slam.predict((0.0, 0.0), 0.1)
        moved.append(slam.observe(gps, (20.0, 5.0)).relocated)
    assert sum(moved) == 1 and slam.estimate().mean[:2] == pytest.approx([20.0, 5.0], abs=0.3)
    plain = scphd.JointFilter(scphd.Unicycle())
    plain.reset()
    reports = [plain.observe(scphd.PositionFix(sigma_m=0.1, gate=16.0), (20.0, 5.0)) for _ in range(60)]
    assert not any(report.accepted or report.relocated for report in reports)


def test_what_to_do_when_lost():
    slam = scphd.JointFilter(scphd.Unicycle())
    pose, _ = ring(slam, scphd.RangeBearing(**LIDAR))
    features = len(slam.map())
    slam.scatter(np.diag([1.0, 1.0, 0.01]))
    assert slam.estimate().covariance[0, 0] > 1.0
    slam.relocate(*pose, np.diag([0.01, 0.01, 1e-4]))
    assert slam.estimate().mean == pytest.approx(pose, abs=1e-4) and len(slam.map()) == features


@pytest.mark.parametrize("kind", [scphd.JointFilter, scphd.Filter])
def test_the_map_of_an_earlier_drive(kind):
    """The map of one filter, pickled in between, in another, which knows where it is at once."""
    lidar = scphd.RangeBearing(**LIDAR)
    first = scphd.JointFilter(scphd.Unicycle())
    pose, posts = ring(first, lidar)
    known = pickle.loads(pickle.dumps(first.map()))
    second = kind(scphd.Unicycle())
    second.reset(*pose)
    second.load_map(known)
    order = [np.lexsort(one.positions_m.T) for one in (second.map(), known)]
    assert second.map().positions_m[order[0]] == pytest.approx(known.positions_m[order[1]])
    draws = np.random.default_rng(4)
    for _ in range(50):
        pose = move(pose, 1.0, 0.2)
        second.predict((1.1, 0.22), 0.1)
        if kind is scphd.JointFilter:
            labels = list(second.map().labels)
            second.localise(lidar, seen(posts, pose, draws))
            assert list(second.map().labels) == labels
        else:
            second.scan(lidar, seen(posts, pose, draws))
    assert np.hypot(*(second.estimate().mean[:2] - pose[:2])) < 0.15


def test_a_start_that_is_not_certain():
    slam = scphd.JointFilter(scphd.Unicycle())
    slam.reset(1.0, 2.0, 0.5, position_sigma_m=2.0, heading_sigma_rad=0.1)
    assert np.diag(slam.estimate().covariance) == pytest.approx([4.0, 4.0, 0.01])
    with pytest.raises(scphd.InputError):
        slam.reset(1.0, 2.0, 0.5, position_sigma_m=float("nan"))
    assert slam.estimate().x_m == 1.0


def test_double_precision():
    """The same drive in both: the estimates agree as far as single precision goes, and arrays have the type."""
    lidar = scphd.RangeBearing(**LIDAR)
    single, double = (scphd.JointFilter(scphd.Unicycle(), precision=one) for one in ("single", "double"))
    ring(single, lidar)
    ring(double, lidar)
    assert double.estimate().mean.dtype == double.map().positions_m.dtype == np.float64
    assert single.estimate().mean.dtype == single.map().covariances.dtype == np.float32
    assert double.estimate().mean == pytest.approx(single.estimate().mean, abs=1e-3)
    assert double.estimate().x_m != float(np.float32(double.estimate().x_m))
    with pytest.raises(scphd.SettingError, match="DESK in double precision"):
        scphd.JointFilter(scphd.Unicycle(), memory="JOINT_40", precision="double")
    with pytest.raises(scphd.SettingError, match="'single' or 'double', not 'half'"):
        scphd.JointFilter(scphd.Unicycle(), precision="half")


def test_more_detectors_than_are_at_hand():
    """Six detectors in turn: each is known by its numbers, and the state is that of one and the same detector."""
    one, many = scphd.JointFilter(scphd.Unicycle()), scphd.JointFilter(scphd.Unicycle())
    for slam in (one, many):
        slam.reset()
    for step in range(30):
        seat = scphd.Mounting(forward_m=0.1 * (step % 6))
        for slam in (one, many):
            slam.predict((0.5, 0.1), 0.1)
            slam.scan(scphd.RangeBearing(**LIDAR, mounting=seat), [(5.0, 0.3), (6.0, -0.5)])
    assert one.digest() == many.digest()


@pytest.mark.parametrize("make", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
@pytest.mark.parametrize("kind", [scphd.JointFilter, scphd.Filter])
def test_copies_of_filters(make, kind):
    """A copy goes on from the state of the first, and on its own."""
    lidar = scphd.RangeBearing(**LIDAR)
    slam = kind(scphd.Unicycle(turn_sigma=0.05), merge_distance=3.0)
    assert make(slam).report() is None
    ring(slam, lidar, scans=20)
    before = slam.digest()
    other = make(slam)
    assert other.digest() == before and repr(other) == repr(slam) and "turn_sigma=0.05" in repr(slam)
    for one in (slam, other):
        one.predict((1.0, 0.2), 0.1)
        one.scan(lidar, [(4.0, 0.2)])
    assert slam.digest() == other.digest() != before


@pytest.mark.parametrize(
    "one",
    [
        scphd.Unicycle(turn_sigma=0.1, step="euler"),
        scphd.Ackermann(wheelbase_m=2.5, pose_left_m=0.1),
        scphd.Holonomic(speed_sigma_mps=0.3),
        scphd.Mounting(forward_m=0.2, yaw_rad=1.0),
        scphd.RangeBearing(**LIDAR),
        scphd.RangeBearing(**LIDAR, range_sigma_ratio=0.1),
        scphd.RangeBearing(**LIDAR, births_still=0.01, births_moving=0.02, mounting=scphd.Mounting(left_m=1.0)),
        scphd.BearingOnly(bearing_sigma_rad=0.1, range_max_m=9.0, births_rings=5),
        scphd.PositionFix(sigma_m=0.5, gate=16.0, antenna_left_m=0.3, watch_patience_s=3.0),
        scphd.HeadingFix(sigma_rad=0.1),
    ],
    ids=lambda one: type(one).__name__,
)
def test_what_is_printed_is_what_makes_it(one):
    names = {name: getattr(scphd, name) for name in scphd.__all__}
    for other in (eval(repr(one), names), copy.copy(one), pickle.loads(pickle.dumps(one))):
        assert other == one and hash(other) == hash(one) and repr(other) == repr(one)
    assert one != 3


@pytest.mark.parametrize(
    ("settings", "exception", "text"),
    [
        ({"odometry_speed_scale": 0.1}, scphd.SettingError, "odometry_speed_scale takes odometry=True"),
        ({"moving_lifetime_s": 9.0}, scphd.SettingError, "moving_lifetime_s takes movers=True"),
        ({"archive": True, "archive_reach_m": -1.0}, scphd.SettingError, "archive_reach_m must be"),
        ({"movers": 1.5}, TypeError, "movers must be True or False"),
        ({"memory": "JOINT_40", "archive": True}, scphd.SettingError, "joint.archive"),
        ({"memory": "JOINT_60_LEARNING"}, scphd.SettingError, "joint.odometry"),
        ({"speed_max_mps": -1.0}, scphd.SettingError, "speed_max_mps must be above 0, or infinite"),
    ],
)
def test_settings_of_parts(settings, exception, text):
    with pytest.raises(exception, match=text):
        scphd.JointFilter(scphd.Unicycle(), **settings)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (([[1.0, 2.0]], []), "not of one length"),
        (([[1.0, 2.0]], [np.eye(3)]), r"covariances must have the shape \(2, 2\)"),
        (([[1.0, 2.0]], [[[1.0, 0.5], [0.0, 1.0]]]), "not symmetric"),
        (([1.0, 2.0], [np.eye(2)]), "positions_m must have the shape"),
    ],
)
def test_maps_that_are_none(arguments, text):
    with pytest.raises(scphd.InputError, match=text):
        scphd.Map(*arguments)


def test_a_map_that_is_refused():
    slam = scphd.JointFilter(scphd.Unicycle())
    with pytest.raises(scphd.NotStartedError):
        slam.load_map(scphd.Map([[1.0, 2.0]], [np.eye(2)]))
    slam.reset()
    before = slam.digest()
    with pytest.raises(scphd.InputError):
        slam.load_map(scphd.Map([[1.0, 2.0]], [-np.eye(2)]))
    with pytest.raises(scphd.InputError):
        slam.relocate(0.0, 0.0, 0.0, -np.eye(3))
    assert slam.digest() == before
