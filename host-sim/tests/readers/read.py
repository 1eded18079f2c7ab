"""Reads the folder of a run with rosbags and evo, with --all with rerun too, and compares what they find with the run's own tables."""

import collections
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import zipfile

import numpy
from rosbags.highlevel import AnyReader

out = pathlib.Path(sys.argv[1])
summary = json.loads((out / "run.json").read_text())


def table(name):
    with open(out / name, newline="") as file:
        return list(csv.DictReader(file))


scans, features = table("scans.csv"), table("map.csv")
axes = ["x_m", "y_m"] + (["z_m"] if "z_m" in scans[0] else [])

# rosbags, with the definitions in the file.
messages = collections.defaultdict(list)
with AnyReader([out / "run.mcap"]) as reader:
    told = {connection.topic: connection.msgcount for connection in reader.connections}
    for connection, time, data in reader.messages():
        messages[connection.topic].append((time, reader.deserialize(data, connection.msgtype)))
counts = {topic: len(all_of_it) for topic, all_of_it in messages.items()}
assert counts == {topic: count for topic, count in told.items() if count}, (counts, told)

for topic in ["/scphd/estimate", "/scphd/odometry", "/tf"]:
    assert counts[topic] == len(scans) == summary["scans"], (topic, counts)
for row, (time, estimate), (_, odometry), (_, frames) in zip(
    scans, messages["/scphd/estimate"], messages["/scphd/odometry"], messages["/tf"]
):
    assert time == round(float(row["t_s"]) * 1e9)
    stamp = estimate.header.stamp
    assert stamp.sec * 10**9 + stamp.nanosec == time and estimate.header.frame_id == "map"
    place = numpy.array([getattr(estimate.pose.position, axis[0]) for axis in axes])
    # To the last bit.
    assert place.tolist() == [float(row[axis]) for axis in axes]
    assert odometry.pose.pose == estimate.pose
    covariance = odometry.pose.covariance.reshape(6, 6)
    assert covariance[0, 1] == float(row["cov_x_y_m2"]) == covariance[1, 0]
    heading = "heading" if "heading_rad" in row else "yaw"
    assert covariance[5, 5] == float(row[f"cov_{heading}_{heading}_rad2"])
    # From the map to the vehicle, whatever is between.
    at, turn = numpy.zeros(2), 0.0
    for link in frames.transforms:
        shift, rotation = link.transform.translation, link.transform.rotation
        c, s = numpy.cos(turn), numpy.sin(turn)
        at = at + [c * shift.x - s * shift.y, s * shift.x + c * shift.y]
        turn += 2 * numpy.arctan2(rotation.z, rotation.w)
    assert numpy.abs(at - place[:2]).max() < 1e-9, (at, place)
    assert abs(numpy.exp(1j * turn) - numpy.exp(1j * float(row[f"{heading}_rad"]))) < 1e-9

detections = [cloud for topic in messages if topic.startswith("/scphd/detections") for _, cloud in messages[topic]]
assert [cloud.width for cloud in detections] == [int(row["measurements"]) for row in scans]


def numbers(cloud, name):
    field = next(field for field in cloud.fields if field.name == name)
    kind = numpy.dtype({7: "<f4", 8: "<f8"}[field.datatype])
    points = cloud.data.reshape(cloud.width, cloud.point_step)
    return points[:, field.offset : field.offset + kind.itemsize].copy().view(kind).ravel()


last = messages["/scphd/map"][-1][1]
assert last.width == len(features)
assert numbers(last, "id").tolist() == [float(row["id"]) for row in features]
assert numbers(last, "weight").tolist() == [float(row["weight"]) for row in features]
assert numbers(last, "x").tolist() == [float(numpy.float32(row["x_m"])) for row in features]
markers = messages["/scphd/features"][-1][1].markers
ellipses = [marker for marker in markers if marker.ns == "static" and marker.type == 2]
assert markers[0].action == 3 and len(ellipses) == len(features) > 0
assert counts["/scphd/features"] == counts["/scphd/map"] == min(len(scans), 400)
for marker, row in zip(ellipses, features):
    # The ellipse's volume is that of the covariance.
    names = [f"cov_{a[0]}_{b[0]}_m2" for k, a in enumerate(axes) for b in axes[k:]]
    square = numpy.zeros((len(axes), len(axes)))
    square[numpy.triu_indices(len(axes))] = [float(row[name]) for name in names]
    square = square + square.T - numpy.diag(numpy.diag(square))
    gate = {2: 5.991, 3: 7.815}[len(axes)]
    size = sorted([marker.scale.x, marker.scale.y, marker.scale.z])
    if len(axes) == 2:
        size.remove(min(size, key=lambda length: abs(length - 0.05)))
    found = numpy.prod([(length / 2) ** 2 / gate for length in size])
    assert abs(found / numpy.linalg.det(square) - 1) < 1e-6, (found, square)

moving = [marker for _, array in messages["/scphd/features"] for marker in array.markers if marker.ns == "moving"]
print(f"rosbags: {sum(counts.values())} messages, {len(moving)} ellipses of moving features")

# evo, as its command.
truth = [row for row in scans if row["true_x_m"]]
for name, rows in [("estimate", scans), ("truth", truth)]:
    assert len((out / f"{name}.tum").read_text().splitlines()) == 1 + len(rows), name
with tempfile.TemporaryDirectory() as folder:
    results = pathlib.Path(folder) / "results.zip"
    ape = pathlib.Path(sys.executable).with_name("evo_ape")
    command = [ape, "tum", out / "truth.tum", out / "estimate.tum", "--save_results", results]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    with zipfile.ZipFile(results) as file:
        rmse = json.loads(file.read("stats.json"))["rmse"]
assert abs(rmse - summary["position_rmse_m"]) < 1e-6, (rmse, summary["position_rmse_m"])
print(f"evo: RMSE {rmse:.9f} m, {abs(rmse - summary['position_rmse_m']):.1e} m from ours")

if "--all" in sys.argv:
    import rerun.chunk

    times, parts = collections.defaultdict(set), collections.defaultdict(set)
    for chunk in rerun.chunk.McapReader(str(out / "run.mcap")).stream():
        batch = chunk.to_record_batch()
        parts[chunk.entity_path].update(name.split(":")[0] for name in batch.schema.names)
        if "message_log_time" in batch.schema.names:
            times[chunk.entity_path].update(batch.column("message_log_time").cast("int64").to_pylist())
    for topic, all_of_it in messages.items():
        assert times[topic] == {time for time, _ in all_of_it}, topic
    # What it draws.
    assert "Transform3D" in parts["/tf"] and "InstancePoses3D" in parts["/scphd/estimate"]
    assert "Points3D" in parts["/scphd/map"]
    print(f"rerun: {sum(map(len, times.values()))} times of {len(times)} entities")
