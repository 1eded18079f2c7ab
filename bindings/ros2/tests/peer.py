"""Another implementation of DDS as the peer of the node: every pose that it receives is that of a replay, to the bit.

    python peer.py PROGRAMS FOLDER SOURCE...

PROGRAMS is the folder of the programs, FOLDER takes files; a SOURCE is a log or a scenario, with `@RATE` behind it where it is played faster.
The last line says what was found, or, with exit code 77, why nothing can be.
"""

import csv
import dataclasses
import os
import random
import statistics
import subprocess
import sys
import time
import types
from pathlib import Path

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl import types as idl
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

SKIPPED = 77
STORE = get_typestore(Stores.ROS2_HUMBLE)
NUMBERS = {
    "bool": bool, "byte": idl.uint8, "char": idl.uint8, "string": str,
    "float32": idl.float32, "float64": idl.float64,
    **{f"{sign}int{bits}": getattr(idl, f"{sign}int{bits}") for sign in ("", "u") for bits in (8, 16, 32, 64)},
}
CLASSES = {}


def message(name):
    """The class of a type, as in `geometry_msgs/msg/Pose`, made of what rosbags knows of it."""
    if name not in CLASSES:
        def kind(node):
            what, of = node
            if what == Nodetype.BASE:
                return NUMBERS[of[0]]
            if what == Nodetype.NAME:
                return message(of)
            if what == Nodetype.ARRAY:
                return idl.array[kind(of[0]), of[1]]
            return idl.sequence[kind(of[0])]

        package, _, short = name.split("/")
        fields = {field: kind(node) for field, node in STORE.fielddefs[name][1]}
        body = {"__annotations__": fields, "__module__": __name__}
        made = types.new_class(short, (IdlStruct,), {"typename": f"{package}::msg::dds_::{short}_"}, lambda ns: ns.update(body))
        CLASSES[name] = dataclasses.dataclass(made)
    return CLASSES[name]


RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepAll)
BEST_EFFORT = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(1000))


class Peer:
    def __init__(self):
        self.domain = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))

    def reader(self, topic, kind, qos=RELIABLE):
        return DataReader(self.domain, Topic(self.domain, f"rt{topic}", message(kind), qos=qos), qos=qos)

    def writer(self, topic, kind, qos=RELIABLE):
        return DataWriter(self.domain, Topic(self.domain, f"rt{topic}", message(kind), qos=qos), qos=qos)


def matched(entity, seconds=20.0):
    """Waits until a reader or writer has found another."""
    count = entity.get_matched_publications if isinstance(entity, DataReader) else entity.get_matched_subscriptions
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if count():
            return True
        time.sleep(0.02)
    return False


def taken_of(reader):
    """The messages that have come; a writer that leaves sends one without content."""
    return [sample for sample in reader.take(N=100) if sample.sample_info.valid_data]


def memory(process):
    """Resident memory, MB."""
    return int(Path(f"/proc/{process.pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def pose_of(sample):
    """What the table of a replay has of a pose."""
    p, q, c = sample.pose.pose.position, sample.pose.pose.orientation, sample.pose.covariance
    return [sample.header.stamp.sec, sample.header.stamp.nanosec, p.x, p.y, q.z, q.w, c[0], c[1], c[5], c[7], c[11], c[35]]


def replayed(path):
    with open(path) as file:
        rows = list(csv.reader(file))[1:]
    return [[int(row[0]), int(row[1]), *map(float, row[2:])] for row in rows]


def play(node, publish, folder, source):
    """Plays a source through the node. How many poses came, and the times that they took, s."""
    source, _, rate = source.partition("@")
    name = Path(source).name
    params, table = folder / f"{name}.yaml", folder / f"{name}.csv"
    subprocess.run([publish, source, "--params", params, "--poses", table, "--no-play"], check=True)
    peer = Peer()
    poses = peer.reader("/scphd/pose", "geometry_msgs/msg/PoseWithCovarianceStamped")
    diagnostics = peer.reader("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    scans = [peer.reader(topic, "sensor_msgs/msg/PointCloud2") for topic in topics(params)]
    words = [node, "--ros-args", "--params-file", params]
    if len(scans) > 1:
        # Topics may overtake each other: by so much at this speed.
        words += ["-p", f"order.wait_s:={0.05 * float(rate or 1)}"]
    running = subprocess.Popen(words)
    try:
        if not matched(poses):
            print("the node and the peer do not find each other: no multicast over loopback?")
            sys.exit(SKIPPED)
        player = subprocess.Popen([publish, source, "--rate", rate or "1"])
        sent, came, taken, ended, state = {}, [], [], None, {}
        while ended is None or time.monotonic() < ended + 1.5:
            idle = True
            for reader in scans:
                for sample in taken_of(reader):
                    idle = False
                    sent.setdefault((sample.header.stamp.sec, sample.header.stamp.nanosec), sample.sample_info.source_timestamp)
            for sample in taken_of(poses):
                idle = False
                came.append(pose_of(sample))
                at = sent.get(tuple(came[-1][:2]))
                if at is not None:
                    taken.append((time.time_ns() - at) / 1e9)
            for sample in taken_of(diagnostics):
                state = {value.key: value.value for value in sample.status[0].values} | {"said": sample.status[0].message}
            if ended is None and player.poll() is not None:
                assert player.returncode == 0, "publishing failed"
                ended = time.monotonic()
            if idle:
                time.sleep(0.0002)
    finally:
        running.terminate()
        running.wait()
    expected = replayed(table)
    assert len(came) == len(expected), f"{source}: {len(came)} poses of {len(expected)}; {state}"
    for k, (pose, right) in enumerate(zip(came, expected)):
        assert pose == right, f"{source}: pose {k} is {pose}, not {right}"
    middle = 1e3 * statistics.median(taken) if taken else float("nan")
    print(f"{source} x{rate or 1}: {len(came)} poses are those of a replay, none is missing; median {middle:.2f} ms")
    return taken


def topics(params):
    """The topics of detections in a file of parameters."""
    words = [line.split(": ") for line in params.read_text().splitlines() if ".topic: " in line]
    return [value.strip().strip("'") for name, value in words if name.strip().startswith("sensor")]


def main():
    programs, folder, *sources = sys.argv[1:]
    node, publish = (Path(programs) / name for name in ("scphd-node", "scphd-publish"))
    os.environ.setdefault("ROS_DOMAIN_ID", str(random.randint(100, 200)))
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    taken = [seconds for source in sources for seconds in play(node, publish, folder, source)]
    print(f"{len(sources)} sources; median of a scan {1e3 * statistics.median(taken):.2f} ms")


if __name__ == "__main__":
    main()
