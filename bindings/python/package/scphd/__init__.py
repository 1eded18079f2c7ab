"""Single-cluster PHD SLAM: the filter of the firmware, bit for bit, with NumPy in and out.

A vehicle (`Unicycle`, `Ackermann`, `Holonomic`, `KnownPose`), its detectors (`RangeBearing`, `BearingOnly`, each where a `Mounting` puts it) and a
filter: `Filter`, the thesis's mixture, or `JointFilter`, one Gaussian over pose and map.

>>> import scphd
>>> lidar = scphd.RangeBearing(range_sigma_m=0.1, bearing_sigma_rad=0.01, range_max_m=20.0)
>>> slam = scphd.JointFilter(scphd.Unicycle())
>>> slam.reset(0.0, 0.0, 0.0)
>>> _ = slam.predict((1.0, 0.0), 0.1)            # speed m/s, turn rate rad/s; s
>>> report = slam.scan(lidar, [(5.0, 0.3)])      # range m, bearing rad
>>> report.health.is_good
True
>>> round(slam.estimate().x_m, 3)
0.1

Numbers are in metres, seconds and radians; angles grow to the left. What is refused is an exception and leaves the filter as it was.
"""

from . import logs
from ._native import (
    Ackermann,
    BearingOnly,
    Filter,
    FixReport,
    HeadingFix,
    Health,
    Holonomic,
    InputError,
    JointFilter,
    JointReport,
    KnownPose,
    Map,
    Mounting,
    Movers,
    NotStartedError,
    Odometry,
    Pose,
    PositionFix,
    PredictReport,
    RangeBearing,
    ScanReport,
    SettingError,
    SnapshotError,
    Unicycle,
    _joint_settings,
)


def _text(name: str, range: str, unit: str, about: str) -> str:
    return f"{name} : {range}{', ' + unit if unit else ''}\n    {about}\n"


# The settings are those of the list that C and the firmware have too.
JointFilter.__doc__ = f"{JointFilter.__doc__}\n" + "".join(_text(*setting) for setting in _joint_settings())

__all__ = [
    "Ackermann",
    "BearingOnly",
    "Filter",
    "FixReport",
    "HeadingFix",
    "Health",
    "Holonomic",
    "InputError",
    "JointFilter",
    "JointReport",
    "KnownPose",
    "Map",
    "Mounting",
    "Movers",
    "NotStartedError",
    "Odometry",
    "Pose",
    "PositionFix",
    "PredictReport",
    "RangeBearing",
    "ScanReport",
    "SettingError",
    "SnapshotError",
    "Unicycle",
    "logs",
]
