"""A sweep over settings and seeds, in one process or on the workers of a Dask cluster, with the same numbers to the last bit.

    python sweep.py                                    # in this process
    python sweep.py --workers 2                        # two workers on this machine
    python sweep.py --cluster tcp://SCHEDULER:8786     # the workers of a cluster, which have scphd and NumPy installed
"""

import argparse
import itertools
import pathlib

import numpy as np

import scphd
import world

#: Shares of the odometry's noise to try.
SHARES = (0.05, 0.1, 0.2, 0.3, 0.5)


def run(task):
    """One filter over one drive: (share, seed) of the task, then position RMSE m, ln of the evidence, and the digest of the end."""
    share, seed, scans = task
    drive = world.drive(seed, scans)
    robot, lidar = world.models(odometry_sigma_ratio=share)
    slam = scphd.JointFilter(robot)
    slam.reset(*drive.start)
    poses, ln_evidence = [], 0.0
    for control, scan in zip(drive.controls, drive.scans):
        slam.predict(control, world.DT_S)
        ln_evidence += slam.scan(lidar, scan).ln_evidence
        poses.append(slam.estimate().mean)
    rmse_m = float(np.sqrt(np.mean(world.errors_m(poses, drive.truth) ** 2)))
    return share, seed, rmse_m, ln_evidence, slam.digest()


def sweep(seeds, shares=SHARES, scans=400, cluster=None):
    """All shares over all seeds, in order. `cluster` is the address of a Dask scheduler; None: this process does the work."""
    tasks = list(itertools.product(shares, seeds, [scans]))
    if cluster is None:
        return [run(task) for task in tasks]
    from dask.distributed import Client

    with Client(cluster) as client:
        # The workers have the package, but not these two files.
        for module in (world, None):
            client.upload_file(str(pathlib.Path(module.__file__ if module else __file__)))
        return client.gather(client.map(run, tasks, pure=False))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cluster", help="address of a Dask scheduler")
    parser.add_argument("--workers", type=int, help="workers to start on this machine")
    parser.add_argument("--seeds", type=int, default=10)
    asked = parser.parse_args()
    if asked.workers:
        from dask.distributed import LocalCluster

        with LocalCluster(n_workers=asked.workers, threads_per_worker=1, dashboard_address=None) as local:
            rows = sweep(range(asked.seeds), cluster=local.scheduler_address)
    else:
        rows = sweep(range(asked.seeds), cluster=asked.cluster)
    print("share   RMSE, m   ln of the evidence a scan")
    for share in SHARES:
        of_share = [row for row in rows if row[0] == share]
        rmse_m, evidence = (np.mean([row[column] for row in of_share]) for column in (2, 3))
        print(f"{share:5.2f}   {rmse_m:7.3f}   {evidence / 400:10.3f}")


if __name__ == "__main__":
    main()
