from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack, TypedDict

class SettingError(ValueError): ...
class InputError(ValueError): ...
class NotStartedError(RuntimeError): ...
class SnapshotError(ValueError): ...

class _Plausible(TypedDict, total=False):
    step_max_s: float
    speed_max_mps: float
    turn_rate_max_radps: float
    jump_max_m: float

class _MixtureSettings(_Plausible, total=False):
    informed_rounds: int
    informed_sampled_fraction: float
    informed_min_responsibility: float
    resample_threshold: float
    prune_weight: float
    confirming_detections: float
    unconfirmed_weight: float
    confirmed_weight: float
    merge_distance: float
    extraction: Literal["heaviest", "peaks", "confirmed"]
    max_components: int
    extraction_weight: float
    moving_velocity_sigma_mps: float
    moving_acceleration_psd: float
    moving_lifetime_s: float
    moving_spread_max_m: float
    moving_extraction_weight: float

class _JointSettings(_Plausible, total=False):
    birth_probability_min: float
    gate: float
    occlusion_factor: float
    least_existence: float
    least_tentative: float
    extraction_existence: float
    merge_distance: float
    visible_s: float
    occluded_s: float
    lifetime_s: float
    movers: bool
    odometry: bool
    archive: bool
    hypotheses: bool
    archive_reach_m: float
    odometry_speed_scale: float
    odometry_turn_scale: float
    odometry_turn_offset: float
    odometry_lasts_s: float
    hypotheses_most: float
    hypotheses_joined_sigmas: float
    hypotheses_least_ratio: float
    hypotheses_least_share: float
    moving_velocity_sigma_mps: float
    moving_acceleration_psd: float
    moving_lifetime_s: float
    moving_spread_max_m: float
    moving_extraction_weight: float

@final
class Unicycle:
    def __new__(
        cls,
        *,
        speed_sigma_mps: float = 0.02,
        speed_sigma_ratio: float = 0.1,
        turn_sigma: float = 0.02,
        turn_sigma_ratio: float = 0.1,
        noise_interval_s: float = 0.5,
        step: Literal["arc", "euler"] = "arc",
    ) -> Unicycle: ...

@final
class Ackermann:
    def __new__(
        cls,
        *,
        wheelbase_m: float,
        encoder_offset_m: float = 0.0,
        pose_forward_m: float = 0.0,
        pose_left_m: float = 0.0,
        speed_sigma_mps: float = 0.02,
        speed_sigma_ratio: float = 0.1,
        turn_sigma: float = 0.02,
        turn_sigma_ratio: float = 0.1,
        noise_interval_s: float = 0.5,
    ) -> Ackermann: ...

@final
class Holonomic:
    def __new__(
        cls,
        *,
        speed_sigma_mps: float = 0.02,
        speed_sigma_ratio: float = 0.1,
        turn_sigma: float = 0.02,
        turn_sigma_ratio: float = 0.1,
        noise_interval_s: float = 0.5,
    ) -> Holonomic: ...

@final
class KnownPose:
    def __new__(cls) -> KnownPose: ...

@final
class Mounting:
    def __new__(cls, *, forward_m: float = 0.0, left_m: float = 0.0, yaw_rad: float = 0.0) -> Mounting: ...

@final
class RangeBearing:
    def __new__(
        cls,
        *,
        range_sigma_m: float,
        bearing_sigma_rad: float,
        range_max_m: float,
        range_sigma_ratio: float = 0.0,
        range_min_m: float = 0.0,
        range_edge_m: float = 0.0,
        bearing_center_rad: float = 0.0,
        bearing_half_width_rad: float = ...,
        bearing_edge_rad: float = 0.0,
        probability: float = 0.9,
        probability_far: float | None = None,
        clutter_per_scan: float = 1.0,
        births_still: float | None = None,
        births_moving: float = 0.0,
        mounting: Mounting | None = None,
    ) -> RangeBearing: ...

@final
class BearingOnly:
    def __new__(
        cls,
        *,
        bearing_sigma_rad: float,
        range_max_m: float,
        range_min_m: float = 0.0,
        range_edge_m: float = 0.0,
        bearing_center_rad: float = 0.0,
        bearing_half_width_rad: float = ...,
        bearing_edge_rad: float = 0.0,
        probability: float = 0.9,
        probability_far: float | None = None,
        clutter_per_scan: float = 1.0,
        births_nearest_m: float | None = None,
        births_farthest_m: float | None = None,
        births_rings: int = 4,
        births_sectors: int = 24,
        births_weight: float = 0.001,
        mounting: Mounting | None = None,
    ) -> BearingOnly: ...

@final
class PositionFix:
    def __new__(
        cls,
        *,
        sigma_m: float,
        gate: float | None = None,
        antenna_forward_m: float = 0.0,
        antenna_left_m: float = 0.0,
        watch_patience_s: float | None = None,
        watch_fewest: int = 5,
    ) -> PositionFix: ...

@final
class HeadingFix:
    def __new__(
        cls,
        *,
        sigma_rad: float,
        gate: float | None = None,
        watch_patience_s: float | None = None,
        watch_fewest: int = 5,
    ) -> HeadingFix: ...

@final
class Health:
    @property
    def is_good(self) -> bool: ...
    @property
    def bits(self) -> int: ...
    @property
    def names(self) -> list[str]: ...
    def __contains__(self, condition: str, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class PredictReport:
    @property
    def candidates(self) -> int: ...
    @property
    def rejected(self) -> int: ...
    @property
    def refused(self) -> int: ...
    @property
    def health(self) -> Health: ...

@final
class ScanReport:
    @property
    def measurements(self) -> int: ...
    @property
    def no_birth(self) -> int: ...
    @property
    def refused(self) -> int: ...
    @property
    def candidates(self) -> int: ...
    @property
    def in_view(self) -> int: ...
    @property
    def particles(self) -> int: ...
    @property
    def resampled(self) -> bool: ...
    @property
    def births(self) -> int: ...
    @property
    def merged(self) -> int: ...
    @property
    def lost(self) -> int: ...
    @property
    def pages_used(self) -> int: ...
    @property
    def pages(self) -> int: ...
    @property
    def moving_pages_used(self) -> int: ...
    @property
    def moving_pages(self) -> int: ...
    @property
    def n_eff(self) -> float: ...
    @property
    def ln_evidence(self) -> float: ...
    @property
    def expected_detections(self) -> float: ...
    @property
    def detections(self) -> float: ...
    @property
    def innovation(self) -> float: ...
    @property
    def health(self) -> Health: ...

@final
class JointReport:
    @property
    def measurements(self) -> int: ...
    @property
    def in_view(self) -> int: ...
    @property
    def refused(self) -> int: ...
    @property
    def births(self) -> int: ...
    @property
    def no_birth(self) -> int: ...
    @property
    def dropped(self) -> int: ...
    @property
    def merged(self) -> int: ...
    @property
    def lost(self) -> int: ...
    @property
    def features(self) -> int: ...
    @property
    def hypotheses(self) -> int: ...
    @property
    def share(self) -> float: ...
    @property
    def ln_evidence(self) -> float: ...
    @property
    def expected_detections(self) -> float: ...
    @property
    def detections(self) -> float: ...
    @property
    def innovation(self) -> float: ...
    @property
    def health(self) -> Health: ...

@final
class FixReport:
    @property
    def accepted(self) -> bool: ...
    @property
    def distance(self) -> float: ...
    @property
    def ln_evidence(self) -> float: ...
    @property
    def n_eff(self) -> float: ...
    @property
    def relocated(self) -> bool: ...

@final
class Pose:
    @property
    def x_m(self) -> float: ...
    @property
    def y_m(self) -> float: ...
    @property
    def heading_rad(self) -> float: ...
    @property
    def mean(self) -> NDArray[np.floating[Any]]: ...
    @property
    def covariance(self) -> NDArray[np.floating[Any]]: ...

@final
class Odometry:
    @property
    def speed_scale(self) -> float: ...
    @property
    def turn_scale(self) -> float: ...
    @property
    def turn_offset(self) -> float: ...

@final
class Map:
    def __new__(
        cls,
        positions_m: ArrayLike,
        covariances: ArrayLike,
        weights: ArrayLike | None = None,
        labels: ArrayLike | None = None,
    ) -> Map: ...
    @property
    def labels(self) -> NDArray[np.uint32]: ...
    @property
    def weights(self) -> NDArray[np.floating[Any]]: ...
    @property
    def positions_m(self) -> NDArray[np.floating[Any]]: ...
    @property
    def covariances(self) -> NDArray[np.floating[Any]]: ...
    @property
    def expected_features(self) -> float: ...
    def __len__(self) -> int: ...

@final
class Movers:
    @property
    def labels(self) -> NDArray[np.uint32]: ...
    @property
    def weights(self) -> NDArray[np.floating[Any]]: ...
    @property
    def positions_m(self) -> NDArray[np.floating[Any]]: ...
    @property
    def velocities_mps(self) -> NDArray[np.floating[Any]]: ...
    @property
    def covariances(self) -> NDArray[np.floating[Any]]: ...
    @property
    def expected_features(self) -> float: ...
    def __len__(self) -> int: ...

@final
class Filter:
    def __new__(
        cls,
        vehicle: Unicycle | Ackermann | Holonomic | KnownPose,
        *,
        proposal: Literal["informed", "blind"] = "informed",
        particles: int = 4,
        samples: int = 1,
        memory: Literal["DESK", "PLANE_32X2", "PLANE_INFORMED_4", "PLANE_INFORMED_4_MOVING"] = "DESK",
        **settings: Unpack[_MixtureSettings],
    ) -> Filter: ...
    def reset(self, x_m: float = 0.0, y_m: float = 0.0, heading_rad: float = 0.0, *, seed: int = 0) -> None: ...
    def predict(self, control: ArrayLike, dt_s: float) -> PredictReport: ...
    def scan(self, detector: RangeBearing | BearingOnly, measurements: ArrayLike) -> ScanReport: ...
    def observe(self, fix: PositionFix | HeadingFix, measurement: ArrayLike) -> FixReport: ...
    def estimate(self) -> Pose: ...
    def map(self) -> Map: ...
    def movers(self) -> Movers: ...
    def relocate(self, x_m: float, y_m: float, heading_rad: float, covariance: ArrayLike) -> None: ...
    def scatter(self, covariance: ArrayLike) -> None: ...
    def load_map(self, map: Map) -> None: ...
    def report(self) -> ScanReport | None: ...
    def digest(self) -> int: ...
    def snapshot(self, *, kind: int = 0) -> bytes: ...
    def restore(self, snapshot: bytes, *, kind: int = 0) -> None: ...

@final
class JointFilter:
    def __new__(
        cls,
        vehicle: Unicycle | Ackermann | Holonomic,
        *,
        memory: Literal[
            "DESK",
            "JOINT_40",
            "JOINT_100",
            "JOINT_60_MOVERS",
            "JOINT_100_MOVERS",
            "JOINT_40_ARCHIVE",
            "JOINT_60_LEARNING",
            "JOINT_24_HYPOTHESES",
        ] = "DESK",
        precision: Literal["single", "double"] = "single",
        **settings: Unpack[_JointSettings],
    ) -> JointFilter: ...
    def reset(
        self,
        x_m: float = 0.0,
        y_m: float = 0.0,
        heading_rad: float = 0.0,
        *,
        position_sigma_m: float = 0.0,
        heading_sigma_rad: float = 0.0,
    ) -> None: ...
    def predict(self, control: ArrayLike, dt_s: float) -> PredictReport: ...
    def scan(self, detector: RangeBearing, measurements: ArrayLike) -> JointReport: ...
    def localise(self, detector: RangeBearing, measurements: ArrayLike) -> JointReport: ...
    def observe(self, fix: PositionFix | HeadingFix, measurement: ArrayLike) -> FixReport: ...
    def estimate(self) -> Pose: ...
    def odometry(self) -> Odometry | None: ...
    def map(self) -> Map: ...
    def movers(self) -> Movers: ...
    def relocate(self, x_m: float, y_m: float, heading_rad: float, covariance: ArrayLike) -> None: ...
    def scatter(self, covariance: ArrayLike) -> None: ...
    def load_map(self, map: Map) -> None: ...
    def report(self) -> JointReport | None: ...
    def digest(self) -> int: ...
    def snapshot(self, *, kind: int = 0) -> bytes: ...
    def restore(self, snapshot: bytes, *, kind: int = 0) -> None: ...

def _joint_settings() -> list[tuple[str, str, str, str]]: ...
