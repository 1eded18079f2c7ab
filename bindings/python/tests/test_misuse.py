"""What is wrong is an exception with a clear text, and leaves the filter as it was. Nothing crashes."""

import threading

import numpy as np
import pytest

import scphd

NAN, INFINITE = float("nan"), float("inf")
SENSOR = {"range_sigma_m": 0.1, "bearing_sigma_rad": 0.01, "range_max_m": 10.0}


@pytest.mark.parametrize(
    ("make", "exception", "text"),
    [
        (lambda: scphd.Unicycle(speed_sigma_mps=-1.0), scphd.SettingError, "speed_sigma_mps must be finite and not negative"),
        (lambda: scphd.Unicycle(turn_sigma=NAN), scphd.SettingError, "turn_sigma must be"),
        (lambda: scphd.Unicycle(noise_interval_s=INFINITE), scphd.SettingError, "noise_interval_s must be"),
        (lambda: scphd.Unicycle(speed_sigma_mps=0, speed_sigma_ratio=0, turn_sigma=0, turn_sigma_ratio=0), scphd.SettingError, "without any noise"),
        (lambda: scphd.Unicycle(step="long"), scphd.SettingError, "step must be 'arc' or 'euler', not 'long'"),
        (lambda: scphd.Unicycle(0.1), TypeError, None),
        (lambda: scphd.Unicycle(speed_sigma_mps=None), TypeError, None),
        (lambda: scphd.Unicycle(speed_sigma_mps="fast"), TypeError, None),
        (lambda: scphd.Unicycle(colour="red"), TypeError, "colour"),
        (lambda: scphd.Ackermann(), TypeError, "wheelbase_m"),
        (lambda: scphd.Ackermann(wheelbase_m=0.0), scphd.SettingError, "wheelbase_m must be finite and positive"),
        (lambda: scphd.Ackermann(wheelbase_m=2.0, turn_sigma=-1.0), scphd.SettingError, "turn_sigma must be"),
        (lambda: scphd.Ackermann(wheelbase_m=2.0, pose_left_m=NAN), scphd.SettingError, "pose_left_m must be finite"),
        (lambda: scphd.Mounting(forward_m=1e6), scphd.SettingError, "forward_m must be within 10 km"),
        (lambda: scphd.Mounting(yaw_rad=NAN), scphd.SettingError, "yaw_rad must be"),
        (lambda: scphd.RangeBearing(**SENSOR, probability=1.0), scphd.SettingError, r"probability must be in \[0, 1\)"),
        (lambda: scphd.RangeBearing(**{**SENSOR, "range_sigma_m": 0.0}), scphd.SettingError, "range_sigma_m must be"),
        (lambda: scphd.RangeBearing(**SENSOR, range_sigma_ratio=1.5), scphd.SettingError, "range_sigma_ratio must be between 0 and 1"),
        (lambda: scphd.RangeBearing(**{**SENSOR, "range_max_m": NAN}), scphd.SettingError, "range_max_m must be"),
        (lambda: scphd.RangeBearing(**SENSOR, births_still=-1.0), scphd.SettingError, "births_still must be"),
        (lambda: scphd.RangeBearing(**SENSOR, clutter_per_scan=NAN), scphd.SettingError, "clutter_per_scan must be"),
        (lambda: scphd.RangeBearing(**SENSOR, mounting=3), TypeError, None),
        (lambda: scphd.BearingOnly(bearing_sigma_rad=0.1, range_max_m=9.0, births_rings=1), scphd.SettingError, "births_rings"),
        (lambda: scphd.BearingOnly(bearing_sigma_rad=0.1, range_max_m=9.0, births_rings=-1), OverflowError, None),
        (lambda: scphd.PositionFix(sigma_m=0.0), scphd.SettingError, "sigma_m must be between"),
        (lambda: scphd.PositionFix(sigma_m=1.0, gate=0.0), scphd.SettingError, "gate must be above 0"),
        (lambda: scphd.PositionFix(sigma_m=1.0, antenna_left_m=NAN), scphd.SettingError, "antenna_left_m must be"),
        (lambda: scphd.HeadingFix(sigma_rad=NAN), scphd.SettingError, "sigma_rad must be"),
        (lambda: scphd.Filter(None), TypeError, "vehicle must be a Unicycle, an Ackermann, a Holonomic or a KnownPose, not NoneType"),
        (lambda: scphd.Filter(scphd.Unicycle(), memory="HUGE"), scphd.SettingError, "memory must be one of DESK, "),
        (lambda: scphd.Filter(scphd.Unicycle(), proposal="lucky"), scphd.SettingError, "proposal must be 'blind' or 'informed'"),
        (lambda: scphd.Filter(scphd.Unicycle(), particles=0), scphd.SettingError, "particles must be at least 1"),
        (lambda: scphd.Filter(scphd.Unicycle(), particles=-1), OverflowError, None),
        (lambda: scphd.Filter(scphd.Unicycle(), particles=10**6), scphd.SettingError, "do not fit a state for 512"),
        (lambda: scphd.Filter(scphd.Unicycle(), particles=2**63, samples=8), scphd.SettingError, "do not fit"),
        (lambda: scphd.Filter(scphd.Unicycle(), prune_weight=NAN), scphd.SettingError, "prune_weight must be above 0"),
        (lambda: scphd.Filter(scphd.Unicycle(), prune_weight=None), TypeError, "prune_weight must be a number"),
        (lambda: scphd.Filter(scphd.Unicycle(), prune_wait=0.1), TypeError, "there is no setting 'prune_wait'"),
        (lambda: scphd.Filter(scphd.Unicycle(), extraction="best"), scphd.SettingError, "extraction must be"),
        (lambda: scphd.Filter(scphd.Unicycle(), proposal="blind", informed_rounds=3), scphd.SettingError, "informed_rounds is of"),
        (lambda: scphd.JointFilter(3), TypeError, "vehicle must be"),
        (lambda: scphd.JointFilter(scphd.Unicycle(), memory="PLANE_32X2"), scphd.SettingError, "memory must be one of DESK, JOINT"),
        (lambda: scphd.JointFilter(scphd.Unicycle(), occlusion_factor=2.0), scphd.SettingError, "occlusion_factor must be between 0 and 1"),
        (lambda: scphd.JointFilter(scphd.Unicycle(), gate="wide"), TypeError, "gate must be a number"),
    ],
)
def test_settings(make, exception, text):
    with pytest.raises(exception, match=text):
        make()


def test_before_reset(slam, lidar):
    for act in (
        lambda: slam.predict((1.0, 0.0), 0.1),
        lambda: slam.scan(lidar, [(3.0, 0.0)]),
        lambda: slam.observe(scphd.HeadingFix(sigma_rad=0.1), 0.0),
        slam.estimate,
        slam.snapshot,
    ):
        with pytest.raises(scphd.NotStartedError, match="not been reset"):
            act()
    assert len(slam.map()) == 0 and slam.report() is None


@pytest.mark.parametrize(
    ("method", "arguments", "exception", "text"),
    [
        ("predict", ((1.0,), 0.1), scphd.InputError, r"\(speed_mps, turn_rate_radps\) must have the shape \(2,\), not \(1,\)"),
        ("predict", ((1.0, 0.0, 0.0), 0.1), scphd.InputError, "shape"),
        ("predict", ([[1.0, 0.0]], 0.1), scphd.InputError, "shape"),
        ("predict", (None, 0.1), scphd.InputError, "shape"),
        ("predict", ("ahead", 0.1), scphd.InputError, "no array of numbers"),
        ("predict", (object(), 0.1), scphd.InputError, "no array of numbers"),
        ("predict", ((1.0, NAN), 0.1), scphd.InputError, "control"),
        ("predict", ((1.0, 0.0), NAN), scphd.InputError, "time step"),
        ("predict", ((1.0, 0.0), -0.1), scphd.InputError, "time step"),
        ("predict", ((1.0, 0.0), None), TypeError, None),
        ("predict", ((400.0, 0.0), 0.1), scphd.InputError, "faster than speed_max_mps"),
        ("observe", (scphd.PositionFix(sigma_m=1.0), (1.0,)), scphd.InputError, "shape"),
        ("observe", (scphd.PositionFix(sigma_m=1.0), (1.0, NAN)), scphd.InputError, "not finite"),
        ("observe", (scphd.PositionFix(sigma_m=1.0), None), scphd.InputError, "shape"),
        ("observe", (scphd.HeadingFix(sigma_rad=1.0), (1.0, 2.0)), scphd.InputError, "a number"),
        ("observe", (scphd.HeadingFix(sigma_rad=1.0), NAN), scphd.InputError, "not finite"),
        ("observe", (None, 1.0), TypeError, "fix must be a PositionFix or a HeadingFix, not NoneType"),
        ("reset", (NAN, 0.0, 0.0), scphd.InputError, "pose"),
        ("reset", (1e12, 0.0, 0.0), scphd.InputError, "pose"),
        ("reset", ("here",), TypeError, None),
        ("restore", (b"",), scphd.SnapshotError, "ends before"),
        ("restore", (b"no snapshot" * 99,), scphd.SnapshotError, "not a snapshot"),
        ("restore", (None,), TypeError, None),
    ],
)
def test_calls(slam, method, arguments, exception, text):
    slam.reset(1.0, 2.0, 0.5)
    before = slam.snapshot()
    with pytest.raises(exception, match=text):
        getattr(slam, method)(*arguments)
    pose = slam.estimate().mean
    assert pose == pytest.approx([1.0, 2.0, 0.5])
    if method != "predict":
        assert slam.snapshot() == before


@pytest.mark.parametrize(
    ("scan", "text"),
    [
        ([1.0, 2.0], r"\(range_m, bearing_rad\) must have the shape \(n, 2\), not \(2,\)"),
        ([[1.0, 2.0, 3.0]], r"not \(1, 3\)"),
        ([[1.0], [2.0, 3.0]], "no array of numbers"),
        (np.zeros((2, 2, 2)), "shape"),
        (3.0, "shape"),
        (None, "shape"),
        ("scan", "no array of numbers"),
        ([{}], "no array of numbers"),
        (np.array([["a", "b"]]), "no array of numbers"),
        (np.array([[object(), object()]]), "no array of numbers"),
        ([[1.0, 0.0], [NAN, 0.0]], "measurement 1 is not finite"),
        ([[INFINITE, 0.0]], "measurement 0 is not finite"),
        ([[1e300, 0.0]], "measurement 0 is not finite"),
        (np.zeros((5000, 2)), "5000 measurements do not fit"),
    ],
)
@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning")
def test_scans(slam, lidar, scan, text):
    slam.reset()
    slam.scan(lidar, [[3.0, 0.1]])
    before = slam.digest()
    with pytest.raises(scphd.InputError, match=text):
        slam.scan(lidar, scan)
    assert slam.digest() == before


def test_scans_that_are_unusual(slam, lidar):
    slam.reset()
    for scan in ([], np.zeros((0, 2)), [(3, 0)], np.array([[3, 0]], dtype=np.int8), np.asfortranarray([[3.0, 0.0]])[::-1]):
        assert slam.scan(lidar, scan).measurements == len(scan)


def test_detectors_that_are_none(slam, lidar):
    slam.reset()
    for detector in (None, 3, slam, scphd.RangeBearing):
        with pytest.raises(TypeError, match="detector must be a RangeBearing"):
            slam.scan(detector, [])


def test_a_camera_is_not_for_a_joint_map(robot):
    slam = scphd.JointFilter(robot)
    slam.reset()
    with pytest.raises(TypeError, match="not BearingOnly"):
        slam.scan(scphd.BearingOnly(bearing_sigma_rad=0.1, range_max_m=9.0), [0.1])


def test_movers_take_memory(robot):
    slam = scphd.Filter(robot, memory="PLANE_INFORMED_4")
    slam.reset()
    with pytest.raises(scphd.SettingError, match="no moving maps"):
        slam.scan(scphd.RangeBearing(**SENSOR, births_moving=0.1), [])


def test_snapshots_of_others(robot):
    mixture, joint = scphd.Filter(robot), scphd.JointFilter(robot)
    mixture.reset()
    joint.reset()
    before = mixture.digest()
    for snapshot in (joint.snapshot(), mixture.snapshot(kind=7), mixture.snapshot()[:-1], scphd_of_eight(robot)):
        with pytest.raises(scphd.SnapshotError):
            mixture.restore(snapshot)
    assert mixture.digest() == before


def scphd_of_eight(robot):
    """A snapshot of a filter with more particles."""
    other = scphd.Filter(robot, particles=8)
    other.reset()
    return other.snapshot()


def test_damaged_snapshots(slam, lidar, robot):
    slam.reset()
    slam.scan(lidar, [(3.0, 0.1), (5.0, 1.0)])
    sound, before = slam.snapshot(), slam.digest()
    for place in range(0, len(sound), 7):
        damaged = bytearray(sound)
        damaged[place] ^= 1 << (place % 8)
        with pytest.raises(scphd.SnapshotError):
            slam.restore(bytes(damaged))
    assert slam.digest() == before


def test_objects_without_new():
    """What only the library makes cannot be made by hand."""
    for kind in (scphd.Pose, scphd.Map, scphd.Movers, scphd.ScanReport, scphd.Health):
        with pytest.raises(TypeError):
            kind()


def test_threads_that_share_a_filter(robot, lidar):
    """One of them is told that the other is at it; both work on with filters of their own."""
    slam = scphd.Filter(robot, proposal="blind", particles=512, samples=4)
    slam.reset()
    scan, refused = np.random.default_rng(1).uniform(1.0, 3.0, (50, 2)), []

    def work():
        for _ in range(30):
            try:
                slam.predict((1.0, 0.1), 0.1)
                slam.scan(lidar, scan)
            except RuntimeError as error:
                refused.append(str(error))

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert refused and all("borrowed" in text for text in refused)
    assert slam.estimate().covariance.shape == (3, 3)


def test_large_memory_on_a_small_stack(robot):
    """The state is made where it lies."""
    made = []
    before = threading.stack_size(256 * 1024)
    try:
        thread = threading.Thread(target=lambda: made.extend([scphd.Filter(robot), scphd.JointFilter(robot)]))
        thread.start()
        thread.join()
    finally:
        threading.stack_size(before)
    assert len(made) == 2
