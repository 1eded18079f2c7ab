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

import numpy
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl import types as idl
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

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


TYPES = [
    "ackermann_msgs/msg/AckermannDriveStamped", "diagnostic_msgs/msg/DiagnosticArray", "geometry_msgs/msg/PoseArray",
    "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped", "nav_msgs/msg/Odometry",
    "sensor_msgs/msg/Imu", "sensor_msgs/msg/JointState", "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/NavSatFix",
    "sensor_msgs/msg/PointCloud2", "tf2_msgs/msg/TFMessage", "visualization_msgs/msg/MarkerArray",
    "vision_msgs/msg/Detection3DArray", "radar_msgs/msg/RadarScan",
]


def invented(draw, name):
    """A message of a type with random content."""
    def value(node):
        what, of = node
        if what == Nodetype.NAME:
            return invented(draw, of)
        if what == Nodetype.BASE:
            kind = of[0]
            if kind == "string":
                return "".join(draw.choice("abc/_ é") for _ in range(draw.randrange(9)))
            if kind == "bool":
                return draw.random() < 0.5
            if kind.startswith("float"):
                number = draw.choice([0.0, -0.0, float("inf"), draw.gauss(0, 1e3)])
                return float(numpy.float32(number)) if kind == "float32" else number
            if kind == "byte":
                return draw.randrange(128)
            limits = numpy.iinfo(kind)
            return draw.randint(int(limits.min), int(limits.max))
        inner, length = of
        count = length if what == Nodetype.ARRAY else draw.randrange(4)
        values = [value(inner) for _ in range(count)]
        if inner[0] == Nodetype.BASE and inner[1][0] not in ("string", "bool"):
            return numpy.array(values, dtype=inner[1][0])
        return values

    return STORE.types[name](*(value(node) for _, node in STORE.fielddefs[name][1]))


def definitions(reencode, messages=100):
    """Every type is defined as rosbags has it, and read and written with its bytes."""
    draw, lines, expected = random.Random(1), [], []
    for name in TYPES:
        if name not in STORE.fielddefs:
            # What ROS itself does not come with: as the node defines it.
            said = subprocess.run([reencode], input=f"{name}\n", capture_output=True, text=True, check=True).stdout
            known = get_types_from_msg(said.strip().replace("|", "\n"), name)
            STORE.register({kind: of for kind, of in known.items() if kind not in STORE.fielddefs})
        lines += [name]
        expected += [None]
        for _ in range(messages):
            raw = bytes(STORE.serialize_cdr(invented(draw, name), name)).hex()
            lines += [f"{name} {raw}"]
            expected += [raw]
    done = subprocess.run([reencode], input="\n".join(lines) + "\n", capture_output=True, text=True, check=True)
    answers = done.stdout.splitlines()
    assert len(answers) == len(lines), f"{len(answers)} answers to {len(lines)} messages"
    for line, right, answer in zip(lines, expected, answers):
        if right is not None:
            assert answer == right, f"{line[:200]}: {answer[:200]}"
            continue
        for kind, (_, fields) in get_types_from_msg(answer.replace("|", "\n"), line).items():
            assert list(fields) == list(STORE.fielddefs[kind][1]), f"{line}: {kind} is {fields}"
    print(f"{len(TYPES)} types, {messages} messages of each: definitions and bytes are those of rosbags")


def trigger(peer, name):
    """Calls a service as rmw_cyclonedds does: 16 bytes that say whose call it is, then the request. Its answer."""
    def made(suffix, **fields):
        body = {"__annotations__": {"guid": idl.uint64, "number": idl.int64, **fields}, "__module__": __name__}
        typename = f"std_srvs::srv::dds_::Trigger_{suffix}_"
        return dataclasses.dataclass(types.new_class(suffix, (IdlStruct,), {"typename": typename}, lambda ns: ns.update(body)))

    request, response = made("Request", dummy=idl.uint8), made("Response", success=bool, message=str)
    answers = DataReader(peer.domain, Topic(peer.domain, f"rr{name}Reply", response, qos=RELIABLE), qos=RELIABLE)
    calls = DataWriter(peer.domain, Topic(peer.domain, f"rq{name}Request", request, qos=RELIABLE), qos=RELIABLE)
    assert matched(calls) and matched(answers), f"{name}: no such service"
    time.sleep(0.2)
    calls.write(request(7, 1, 0))
    end = time.monotonic() + 10.0
    while time.monotonic() < end:
        for answer in taken_of(answers):
            return answer.success, answer.message
        time.sleep(0.01)
    raise AssertionError(f"{name}: no answer")


def services(node, publish, folder):
    """A map is saved by a service, and the vehicle finds its place in it."""
    params, name = folder / "survey.yaml", "survey"
    subprocess.run([publish, name, "--params", params, "--no-play"], check=True)
    peer, environment = Peer(), {**os.environ, "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}
    words = [node, "--ros-args", "--params-file", params, "-p", f"map:={folder / 'map.scphd'}"]
    running = subprocess.Popen(words, env=environment)
    poses = peer.reader("/scphd/pose", "geometry_msgs/msg/PoseWithCovarianceStamped")
    try:
        assert matched(poses)
        subprocess.run([publish, name, "--rate", "16"], check=True, stdout=subprocess.DEVNULL)
        success, message = trigger(peer, "/scphd/save_map")
        assert success and "features saved" in message, message
        for service in ("reset", "load_map", "locate"):
            success, message = trigger(peer, f"/scphd/{service}")
            assert success, f"{service}: {message}"
        trigger(peer, "/scphd/reset")
    finally:
        running.terminate()
        running.wait()
    print("services: reset, save_map, load_map and locate answer")


def soak(node, publish, folder, restarts=6, seconds=2.0):
    """Publisher and peer are killed and come again: the node goes on, and its memory does not grow."""
    params = folder / "survey.yaml"
    subprocess.run([publish, "survey", "--params", params, "--no-play"], check=True)
    running, sizes, counts = subprocess.Popen([node, "--ros-args", "--params-file", params]), [], []
    try:
        for _ in range(restarts):
            peer = Peer()
            poses = peer.reader("/scphd/pose", "geometry_msgs/msg/PoseWithCovarianceStamped")
            player = subprocess.Popen([publish, "survey", "--rate", "16"], stdout=subprocess.DEVNULL)
            assert matched(poses)
            end, count = time.monotonic() + seconds, 0
            while time.monotonic() < end or (count == 0 and time.monotonic() < end + 20.0):
                count += len(taken_of(poses))
                time.sleep(0.01)
            player.kill()
            player.wait()
            # Neither says that it leaves.
            del poses, peer
            assert running.poll() is None, "the node has ended"
            sizes.append(memory(running))
            counts.append(count)
        assert min(counts) > 0, f"poses: {counts}"
        assert sizes[-1] < sizes[1] + 3.0, f"memory, MB: {sizes}"
    finally:
        running.terminate()
        running.wait()
    print(f"{restarts} restarts: poses {counts}, memory {sizes[1]:.1f} MB after the second, {sizes[-1]:.1f} MB after the last")


def main():
    programs, folder, *sources = sys.argv[1:]
    node, publish = (Path(programs) / name for name in ("scphd-node", "scphd-publish"))
    os.environ.setdefault("ROS_DOMAIN_ID", str(random.randint(100, 200)))
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    definitions(Path(programs) / "examples" / "reencode")
    taken = [seconds for source in sources for seconds in play(node, publish, folder, source)]
    services(node, publish, folder)
    soak(node, publish, folder)
    print(f"{len(sources)} sources; median of a scan {1e3 * statistics.median(taken):.2f} ms")


if __name__ == "__main__":
    main()
