"""The filter as a plain Gaussian-mixture PHD tracker beside that of Stone Soup, on the same simulated targets.

Both get the same scans (range and bearing from a mast whose pose is known), the same models of motion, noise, detection, clutter and
survival, the same thresholds for pruning and merging, births where the last scan was measured, and give components of weight 0.5 and
more. scphd computes in single precision, Stone Soup in double.

    python stone_soup.py            # 20 runs of 100 scans each: some minutes
"""

import argparse
import datetime
import time

import numpy as np
from scipy.optimize import linear_sum_assignment

import scphd

DT_S, RANGE_MAX_M = 0.5, 40.0
RANGE_SIGMA_M, BEARING_SIGMA_RAD = 0.3, 0.01
PROBABILITY, CLUTTER_PER_SCAN = 0.95, 5.0
ACCELERATION_PSD, LIFETIME_S, VELOCITY_SIGMA_MPS = 0.1, 100.0, 2.0
BIRTHS_PER_SCAN, PRUNE_WEIGHT, MERGE_DISTANCE, EXTRACTION_WEIGHT = 0.1, 1e-5, 4.0, 0.5
MEASURE = RANGE_MAX_M * 2.0 * np.pi
#: Targets and estimates are scored as far as this, m: beyond the view nobody can know of them.
SCORED_M = RANGE_MAX_M - 1.0
#: The distance at which a target is no target any more, m, and the order of the metric.
CUT_OFF_M, ORDER = 2.0, 1


def case(seed, scans=100, targets=5):
    """Scans of shape (k, 2), range m and bearing rad, and for each the true positions of the targets there are, of shape (n, 2)."""
    draws = np.random.default_rng(seed)
    first = draws.integers(0, scans // 3, targets)
    last = draws.integers(2 * scans // 3, scans, targets)
    angle = draws.uniform(-np.pi, np.pi, targets)
    start = (draws.uniform(8.0, 25.0, targets) * np.stack([np.cos(angle), np.sin(angle)])).T
    velocity = draws.normal(0.0, 1.0, (targets, 2))
    root = np.linalg.cholesky(ACCELERATION_PSD * np.array([[DT_S**3 / 3, DT_S**2 / 2], [DT_S**2 / 2, DT_S]]))
    states = np.stack([start, velocity])
    seen, truth = [], []
    for step in range(scans):
        drawn = np.tensordot(root, draws.normal(size=(2, targets, 2)), axes=1)
        states = np.stack([states[0] + DT_S * states[1], states[1]]) + drawn
        places = states[0][(first <= step) & (step <= last)]
        places = places[np.hypot(*places.T) < RANGE_MAX_M]
        scan = np.stack([np.hypot(*places.T), np.arctan2(places[:, 1], places[:, 0])], axis=1)
        scan = scan[draws.uniform(size=len(scan)) < PROBABILITY]
        scan = scan + draws.normal(0.0, [RANGE_SIGMA_M, BEARING_SIGMA_RAD], scan.shape)
        false = draws.uniform([0.0, -np.pi], [RANGE_MAX_M, np.pi], (draws.poisson(CLUTTER_PER_SCAN), 2))
        scan = draws.permutation(np.concatenate([scan, false]))
        scan[:, 1] = (scan[:, 1] + np.pi) % (2.0 * np.pi) - np.pi
        seen.append(scan)
        truth.append(places)
    return seen, truth


def by_scphd(scans):
    """The estimated positions after each scan, and seconds of the processor a scan."""
    radar = scphd.RangeBearing(
        range_sigma_m=RANGE_SIGMA_M, bearing_sigma_rad=BEARING_SIGMA_RAD, range_max_m=RANGE_MAX_M,
        probability=PROBABILITY, clutter_per_scan=CLUTTER_PER_SCAN, births_still=0.0,
        births_moving=BIRTHS_PER_SCAN / MEASURE,
    )
    tracker = scphd.Filter(
        scphd.KnownPose(), proposal="blind", particles=1, prune_weight=PRUNE_WEIGHT, merge_distance=MERGE_DISTANCE,
        moving_velocity_sigma_mps=VELOCITY_SIGMA_MPS, moving_acceleration_psd=ACCELERATION_PSD,
        moving_lifetime_s=LIFETIME_S, moving_extraction_weight=EXTRACTION_WEIGHT, moving_spread_max_m=20.0,
    )
    tracker.reset()
    estimates, begun = [], time.process_time()
    for scan in scans:
        tracker.predict((0.0, 0.0, 0.0), DT_S)
        tracker.scan(radar, scan)
        estimates.append(tracker.movers().positions_m)
    return estimates, (time.process_time() - begun) / len(scans)


def by_stone_soup(scans):
    """The same by the parts of Stone Soup that its tutorial on the GM-PHD filter puts together, with an extended Kalman updater."""
    from stonesoup.hypothesiser.distance import DistanceHypothesiser
    from stonesoup.hypothesiser.gaussianmixture import GaussianMixtureHypothesiser
    from stonesoup.measures import Mahalanobis
    from stonesoup.mixturereducer.gaussianmixture import GaussianMixtureReducer
    from stonesoup.models.measurement.nonlinear import CartesianToBearingRange
    from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
    from stonesoup.predictor.kalman import KalmanPredictor
    from stonesoup.types.angle import Bearing
    from stonesoup.types.array import CovarianceMatrix, StateVector
    from stonesoup.types.detection import Detection
    from stonesoup.types.state import TaggedWeightedGaussianState
    from stonesoup.updater.kalman import ExtendedKalmanUpdater
    from stonesoup.updater.pointprocess import PHDUpdater

    each = ConstantVelocity(ACCELERATION_PSD)
    measured = CartesianToBearingRange(
        ndim_state=4, mapping=(0, 2), noise_covar=np.diag([BEARING_SIGMA_RAD**2, RANGE_SIGMA_M**2])
    )
    kalman = ExtendedKalmanUpdater(measured)
    updater = PHDUpdater(
        kalman, clutter_spatial_density=CLUTTER_PER_SCAN / MEASURE, prob_detection=PROBABILITY,
        prob_survival=np.exp(-DT_S / LIFETIME_S),
    )
    predictor = KalmanPredictor(CombinedLinearGaussianTransitionModel([each, each]))
    base = DistanceHypothesiser(predictor, kalman, Mahalanobis(), missed_distance=5)
    hypothesiser = GaussianMixtureHypothesiser(base, order_by_detection=True)
    reducer = GaussianMixtureReducer(prune_threshold=PRUNE_WEIGHT, pruning=True, merge_threshold=MERGE_DISTANCE, merging=True)

    def born(scan, now):
        """A component where each measurement was."""
        components = []
        for distance, bearing in scan:
            sine, cosine = np.sin(bearing), np.cos(bearing)
            turned = np.array([[cosine, -distance * sine], [sine, distance * cosine]])
            spread = turned @ np.diag([RANGE_SIGMA_M**2, BEARING_SIGMA_RAD**2]) @ turned.T
            covariance = np.diag([0.0, VELOCITY_SIGMA_MPS**2, 0.0, VELOCITY_SIGMA_MPS**2])
            covariance[np.ix_([0, 2], [0, 2])] = spread
            components.append(
                TaggedWeightedGaussianState(
                    StateVector([distance * cosine, 0.0, distance * sine, 0.0]), CovarianceMatrix(covariance),
                    weight=BIRTHS_PER_SCAN / len(scan), tag=TaggedWeightedGaussianState.BIRTH, timestamp=now,
                )
            )
        return components

    start = datetime.datetime(2026, 1, 1)
    estimates, components, births, begun = [], [], [], time.process_time()
    for step, scan in enumerate(scans):
        now = start + datetime.timedelta(seconds=DT_S * (step + 1))
        detections = {
            Detection(StateVector([Bearing(bearing), distance]), timestamp=now, measurement_model=measured)
            for distance, bearing in scan
        }
        if components or births:
            hypotheses = hypothesiser.hypothesise(components + births, detections, now)
            components = list(reducer.reduce(updater.update(hypotheses)))
        births = born(scan, now)
        estimates.append(
            np.array([
                [float(component.mean[0]), float(component.mean[2])]
                for component in components
                if component.weight >= EXTRACTION_WEIGHT
            ]).reshape(-1, 2)
        )
    return estimates, (time.process_time() - begun) / len(scans)


def ospa_m(estimate, truth):
    """OSPA distance of two sets of positions, m (Schuhmacher, Vo and Vo 2008)."""
    count = max(len(estimate), len(truth))
    if count == 0:
        return 0.0
    apart = np.minimum(np.hypot(*(estimate[:, None, :] - truth[None, :, :]).transpose(2, 0, 1)), CUT_OFF_M) ** ORDER
    matched = apart[linear_sum_assignment(apart)].sum()
    return float(((matched + CUT_OFF_M**ORDER * (count - min(len(estimate), len(truth)))) / count) ** (1.0 / ORDER))


def score(estimates, truth):
    """Mean OSPA, m, mean error of the number of targets, and RMSE of what lies within the cut-off, m."""
    estimates, truth = ([one[np.hypot(*one.T) < SCORED_M] for one in of_all] for of_all in (estimates, truth))
    distances = [ospa_m(estimate, places) for estimate, places in zip(estimates, truth)]
    counts = [abs(len(estimate) - len(places)) for estimate, places in zip(estimates, truth)]
    near = []
    for estimate, places in zip(estimates, truth):
        if len(estimate) and len(places):
            apart = np.hypot(*(estimate[:, None, :] - places[None, :, :]).transpose(2, 0, 1))
            pairs = apart[linear_sum_assignment(np.minimum(apart, CUT_OFF_M))]
            near.extend(pairs[pairs < CUT_OFF_M])
    return np.mean(distances), np.mean(counts), np.sqrt(np.mean(np.square(near)))


def compare(seeds, scans=100):
    """For either tracker, rows of (OSPA m, error of the number, RMSE m, seconds of the processor a scan), one for each seed."""
    rows = {"scphd": [], "Stone Soup": []}
    for seed in seeds:
        seen, truth = case(seed, scans)
        for name, tracker in (("scphd", by_scphd), ("Stone Soup", by_stone_soup)):
            estimates, seconds = tracker(seen)
            rows[name].append((*score(estimates, truth), seconds))
    return {name: np.array(of_tracker) for name, of_tracker in rows.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    rows = compare(range(100, 100 + parser.parse_args().seeds))
    print("            OSPA, m   number   RMSE, m   ms a scan")
    for name, of_tracker in rows.items():
        ospa, count, rmse, seconds = of_tracker.mean(axis=0)
        print(f"{name:<10}  {ospa:7.3f}   {count:6.3f}   {rmse:7.3f}   {1e3 * seconds:9.3f}")
    ours, theirs = rows["scphd"], rows["Stone Soup"]
    print(f"OSPA: scphd lower in {np.sum(ours[:, 0] < theirs[:, 0])} of {len(ours)} runs; RMSE: in {np.sum(ours[:, 2] < theirs[:, 2])}")


if __name__ == "__main__":
    main()
