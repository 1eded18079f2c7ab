"""What the filters do, seen from Python."""

import numpy as np
import pytest

import scphd


def test_a_robot_among_posts(slam, lidar, world):
    slam.reset(*world.pose)
    for _ in range(300):
        control, scan = world.step()
        slam.predict(control, 0.1)
        report = slam.scan(lidar, scan)
        assert report.measurements == len(scan)
    pose, features = slam.estimate(), slam.map()
    assert np.hypot(*(pose.mean[:2] - world.pose[:2])) < 0.3
    assert pose.mean.dtype == np.float32 and pose.covariance.shape == (3, 3)
    assert (pose.x_m, pose.y_m, pose.heading_rad) == tuple(pose.mean)
    assert np.all(np.linalg.eigvalsh(pose.covariance) > -1e-6)
    count = len(features)
    assert features.positions_m.shape == (count, 2) and features.covariances.shape == (count, 2, 2)
    assert features.labels.shape == features.weights.shape == (count,) and len(set(features.labels)) == count
    nearest = [np.min(np.hypot(*(features.positions_m - post).T)) for post in world.posts]
    assert np.mean(np.array(nearest) < 0.5) > 0.8
    assert abs(features.expected_features - len(world.posts)) < 3
    assert slam.report().health.names == report.health.names


def test_a_snapshot_goes_on(slam, lidar, world, robot):
    slam.reset(*world.pose)
    inputs = [world.step() for _ in range(60)]
    digests = []
    for step, (control, scan) in enumerate(inputs):
        if step == 30:
            snapshot = slam.snapshot()
        slam.predict(control, 0.1)
        slam.scan(lidar, scan)
        digests.append(slam.digest())
    again = type(slam)(robot)
    again.restore(snapshot)
    assert again.report() is None
    for step, (control, scan) in enumerate(inputs[30:]):
        again.predict(control, 0.1)
        again.scan(lidar, scan)
        assert again.digest() == digests[30 + step]


def test_a_car_goes_straight_and_turns():
    slam = scphd.JointFilter(scphd.Ackermann(wheelbase_m=2.5))
    slam.reset()
    slam.predict((10.0, 0.0), 1.0)
    assert slam.estimate().mean == pytest.approx([10.0, 0.0, 0.0], abs=1e-4)
    slam.predict((1.0, 0.2), 0.5)
    assert slam.estimate().heading_rad == pytest.approx(0.5 * np.tan(0.2) / 2.5, rel=1e-4)


def test_a_robot_goes_along_an_arc(slam):
    slam.reset(1.0, 2.0, 0.0)
    slam.predict(np.array([np.pi / 2, np.pi / 2]), 1.0)
    assert slam.estimate().mean == pytest.approx([2.0, 3.0, np.pi / 2], abs=1e-5)


def test_a_vehicle_that_moves_sideways():
    slam = scphd.JointFilter(scphd.Holonomic())
    slam.reset(0.0, 0.0, np.pi / 2)
    for _ in range(10):
        slam.predict((1.0, 2.0, 0.0), 0.1)
    assert slam.estimate().mean == pytest.approx([-2.0, 1.0, np.pi / 2], abs=1e-4)
    with pytest.raises(ValueError):
        slam.predict((1.0, 2.0), 0.1)


def test_fixes(slam):
    slam.reset(seed=1) if isinstance(slam, scphd.Filter) else slam.reset()
    for _ in range(20):
        slam.predict((1.0, 0.5), 0.1)
    gps = scphd.PositionFix(sigma_m=0.01, gate=16.0)
    far = slam.observe(gps, (100.0, 100.0))
    assert not far.accepted and far.distance > 16.0
    x, y, heading = slam.estimate().mean
    assert slam.observe(gps, (x, y)).accepted
    assert slam.observe(scphd.HeadingFix(sigma_rad=0.01), float(heading)).accepted


def test_two_detectors_and_their_seats(slam):
    """A post 5 m ahead of a robot whose second lidar looks backwards, half a metre behind the pose."""
    front = scphd.RangeBearing(range_sigma_m=0.05, bearing_sigma_rad=0.01, range_max_m=15.0)
    seat = scphd.Mounting(forward_m=-0.5, yaw_rad=np.pi)
    back = scphd.RangeBearing(range_sigma_m=0.05, bearing_sigma_rad=0.01, range_max_m=15.0, mounting=seat)
    slam.reset()
    for _ in range(6):
        slam.predict((0.0, 0.0), 0.1)
        slam.scan(front, [(5.0, 0.0)])
        slam.scan(back, [(5.5, np.pi)])
    features = slam.map()
    assert len(features) == 1 and features.positions_m[0] == pytest.approx([5.0, 0.0], abs=0.05)


def test_a_tracker():
    """Two targets cross the view of a mast; the filter tells them by their velocities."""
    radar = scphd.RangeBearing(
        range_sigma_m=0.3, bearing_sigma_rad=0.01, range_max_m=40.0, probability=0.95, clutter_per_scan=2.0,
        births_still=0.0, births_moving=0.1 / (40.0 * 2 * np.pi),
    )
    mast = scphd.Filter(
        scphd.KnownPose(), proposal="blind", particles=1, prune_weight=1e-5, moving_velocity_sigma_mps=2.0
    )
    mast.reset()
    draws = np.random.default_rng(3)
    start, velocity = np.array([[-20.0, 10.0], [15.0, 15.0]]), np.array([[2.0, 0.0], [-1.0, -1.5]])
    for step in range(1, 81):
        places = start + 0.1 * step * velocity
        scan = np.stack([np.hypot(*places.T), np.arctan2(places[:, 1], places[:, 0])], axis=1)
        scan += draws.normal(0.0, [0.3, 0.01], scan.shape)
        mast.predict((0.0, 0.0, 0.0), 0.1)
        mast.scan(radar, scan)
    tracks = mast.movers()
    assert len(tracks) == 2 and tracks.covariances.shape == (2, 4, 4)
    order = np.argsort(tracks.positions_m[:, 0])
    assert np.all(np.hypot(*(tracks.positions_m[order] - places).T) < 1.0)
    assert np.all(np.hypot(*(tracks.velocities_mps[order] - velocity).T) < 0.5)
    assert len(mast.map()) == 0


def test_health_has_names(lidar):
    """A robot that is carried away looks for what it knows, and sees something else."""
    slam = scphd.JointFilter(scphd.Unicycle(speed_sigma_mps=0.05, turn_sigma=0.02))
    slam.reset()
    draws = np.random.default_rng(1)
    known = [(4.0, 0.3), (6.0, -1.0), (5.0, 2.0), (7.0, -2.5)]
    other = [(9.0, 1.3), (3.0, -0.4), (11.0, -2.0), (2.0, 2.9)]
    for step in range(110):
        slam.predict((0.0, 0.0), 0.1)
        places = known if step < 80 else other
        health = slam.scan(lidar, places + draws.normal(0.0, [0.05, 0.01], (4, 2))).health
        assert ("LOST" in health) <= (step > 80)
    assert health.names == ["LOST"] and health.bits == 1024 and not health.is_good and repr(health) == "Health(LOST)"
    assert health == slam.report().health and "DEGENERATE" not in health
    with pytest.raises(scphd.InputError, match="no condition 'HUNGRY'"):
        "HUNGRY" in health
    with pytest.raises(scphd.InputError):
        slam.predict((float("nan"), 0.0), 0.1)
    assert "PREDICTION_REFUSED" in slam.predict((0.0, 0.0), 0.1).health


def test_a_map_of_what_is_confirmed(robot, lidar, world):
    """A feature that was seen once is part of no such map."""
    slam = scphd.Filter(robot, extraction="confirmed")
    slam.reset(*world.pose)
    assert len(slam.map()) == 0
    for _ in range(50):
        control, scan = world.step()
        slam.predict(control, 0.1)
        slam.scan(lidar, scan)
    assert 8 <= len(slam.map()) <= 12


def test_a_step_of_euler():
    slam = scphd.JointFilter(scphd.Unicycle(step="euler"))
    slam.reset()
    slam.predict((1.0, 1.0), 1.0)
    assert slam.estimate().mean == pytest.approx([1.0, 0.0, 1.0])


def test_settings_reach_the_filter(robot, lidar, world):
    """A filter that prunes nearly everything has a smaller map."""
    sizes = []
    inputs = [world.step() for _ in range(30)]
    for prune_weight in (1e-4, 0.3):
        slam = scphd.Filter(robot, prune_weight=prune_weight)
        slam.reset(4.0, 0.0, np.pi / 2)
        for control, scan in inputs:
            slam.predict(control, 0.1)
            slam.scan(lidar, scan)
        sizes.append(slam.report().pages_used)
    assert sizes[1] < sizes[0]


def test_docstrings():
    """Every public class and method says what it is."""
    for name in scphd.__all__:
        thing = getattr(scphd, name)
        assert thing.__doc__, name
        if isinstance(thing, type) and not issubclass(thing, Exception):
            for method in (method for method in dir(thing) if not method.startswith("_")):
                assert getattr(thing, method).__doc__, f"{name}.{method}"
