"""pymavlink as the peer of scphd-mavlink: `read` and `write` for single messages, `drive PORT` for a vehicle over UDP."""

import math
import os
import random
import socket
import sys

os.environ["MAVLINK20"] = "1"
from pymavlink.dialects.v20 import common as mavlink  # noqa: E402


def fields(message):
    """Name and numbers of a message, in the order of its definition."""
    numbers = []
    for name in message.fieldnames:
        value = getattr(message, name)
        numbers.extend(value if isinstance(value, (list, tuple)) else [value])
    return " ".join([message.get_type(), *(repr(number) for number in numbers)])


def read():
    """Lines of bytes become lines of fields."""
    parser = mavlink.MAVLink(None)
    for line in sys.stdin:
        for message in parser.parse_buffer(bytes.fromhex(line)) or []:
            assert message.get_srcSystem() == 7 and message.get_srcComponent() == 197
            print(fields(message))


def write():
    """Messages of random numbers: their bytes, then their fields."""
    draws = random.Random(5)
    mav = mavlink.MAVLink(None, srcSystem=3, srcComponent=1)

    def some(count, size=100.0):
        return [draws.uniform(-size, size) for _ in range(count)]

    def tell(message):
        # Read back: fields are then in single precision.
        frame = message.pack(mav)
        print(frame.hex(), fields(mavlink.MAVLink(None).parse_buffer(bytearray(frame))[0]))

    for k in range(200):
        time = draws.randrange(2**63)
        turned = some(4)
        length = math.sqrt(sum(number * number for number in turned))
        turned = [number / length for number in turned]
        covariances = [[math.nan] * 21 if draws.random() < 0.2 else some(21) for _ in range(2)]
        twist = some(6) if draws.random() < 0.8 else [math.nan] * 6
        frame = draws.choice([mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_LOCAL_FRD])
        tell(
            mavlink.MAVLink_odometry_message(
                time, frame, mavlink.MAV_FRAME_BODY_FRD, *some(3), turned, *twist, *covariances, k, 2, 50
            )
        )
        placed = draws.randrange(2)
        tell(
            mavlink.MAVLink_landing_target_message(
                time, k, 12, *some(2, 1.4), abs(some(1)[0]), 0.1, 0.1, *some(3), [1, 0, 0, 0], 2, placed
            )
        )
        tell(
            mavlink.MAVLink_gps_raw_int_message(
                time, draws.randrange(7), *[draws.randrange(-(10**9), 10**9) for _ in range(3)], 1, 2, 3, 4, 9, 0, k * 10
            )
        )
        tell(mavlink.MAVLink_timesync_message(draws.randrange(-(2**62), 2**62), draws.randrange(2**62)))


class Vehicle:
    """A vehicle on a circle among landmarks, whose odometry turns too far while it sees none of them."""

    RADIUS, SPEED = 10.0, 2.0
    MARKS = [(14 * math.cos(k), 10 + 14 * math.sin(k)) for k in range(6)] + [(6 * math.cos(k), 10 + 6 * math.sin(k)) for k in range(6)]

    def __init__(self, port):
        self.line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.line.connect(("127.0.0.1", port))
        self.line.settimeout(5)
        self.mav = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self.parser = mavlink.MAVLink(None)
        self.draws = random.Random(1)
        self.seen = []

    def send(self, *messages):
        # Two messages to a datagram, or one in two.
        data = b"".join(message.pack(self.mav) for message in messages)
        cut = self.draws.randrange(len(data))
        self.line.send(data[:cut] or b"\0")
        self.line.send(data[cut:])

    def await_of(self, *names):
        found = {}
        while len(found) < len(names):
            for message in self.parser.parse_buffer(self.line.recv(2048)) or []:
                self.seen.append(message.get_type())
                if message.get_type() in names:
                    found[message.get_type()] = message
        return [found[name] for name in names]

    def at(self, time):
        turned = self.SPEED / self.RADIUS * time
        return self.RADIUS * math.sin(turned), self.RADIUS * (1 - math.cos(turned)), turned

    def targets(self, time):
        x, y, heading = self.at(time)
        for k, (mx, my) in enumerate(self.MARKS):
            distance = math.hypot(mx - x, my - y)
            bearing = math.remainder(math.atan2(my - y, mx - x) - heading, math.tau)
            if distance > 12:
                continue
            distance += self.draws.gauss(0, 0.05)
            bearing += self.draws.gauss(0, 0.01)
            stamp = int(time * 1e6)
            if abs(bearing) < 1.2 and k % 2:
                # By angles, to the right and down.
                yield mavlink.MAVLink_landing_target_message(stamp, k, 12, -bearing, 0.0, distance, 0, 0)
            else:
                place = distance * math.cos(bearing), -distance * math.sin(bearing), 0.0
                yield mavlink.MAVLink_landing_target_message(
                    stamp, k, 12, 0, 0, 0, 0, 0, *place, [1, 0, 0, 0], 2, 1
                )

    def drive(self):
        """Two rounds with landmarks, one without, and one with them again."""
        self.send(mavlink.MAVLink_timesync_message(0, 12345))
        (answer,) = self.await_of("TIMESYNC")
        assert answer.ts1 == 12345 and answer.tc1 > 0, answer
        around = math.tau * self.RADIUS / self.SPEED
        blind = range(int(2 * around * 20), int(3 * around * 20))
        last, resets, worst = None, [], 0.0
        for sample in range(int(3.3 * around * 20)):
            time = sample / 20
            # Turn rates are to the right; without landmarks they are a little too small.
            rate = self.SPEED / self.RADIUS * (0.985 if sample in blind else 1.0)
            twist = self.SPEED + self.draws.gauss(0, 0.02), 0.0, 0.0, 0.0, 0.0, -rate + self.draws.gauss(0, 0.01)
            odometry = mavlink.MAVLink_odometry_message(
                int(time * 1e6), 20, 12, 0, 0, 0, [1, 0, 0, 0], *twist, [math.nan] * 21, [math.nan] * 21
            )
            self.send(*(self.targets(time) if sample % 4 == 0 and sample not in blind else ()), odometry)
            pose, vision = self.await_of("ODOMETRY", "VISION_POSITION_ESTIMATE")
            print(fields(pose))
            print(fields(vision))
            assert (pose.frame_id, pose.child_frame_id, pose.estimator_type) == (20, 12, 2), pose
            assert (pose.time_usec, pose.reset_counter) == (vision.usec, vision.reset_counter)
            x, y, heading = self.at(time)
            error = math.hypot(pose.x - x, -pose.y - y)
            yaw = 2 * math.atan2(pose.q[3], pose.q[0])
            assert abs(math.remainder(yaw - vision.yaw, math.tau)) < 1e-4
            if sample not in blind:
                worst = max(worst, error)
                # Four standard deviations, and what the landmarks' map may have come to.
                assert error < 4 * math.sqrt(pose.pose_covariance[0] + pose.pose_covariance[6]) + 0.3, (sample, error)
            if last is not None:
                # What lies between two poses and is not a step of the odometry is a jump.
                jump = math.hypot(pose.x - last.x, pose.y - last.y) - self.SPEED / 20
                turn = abs(math.remainder(yaw - last_yaw, math.tau)) - self.SPEED / self.RADIUS / 20
                changed = pose.reset_counter != last.reset_counter
                if changed:
                    resets.append(sample)
                assert changed or (jump < 0.5 and turn < 0.1), (sample, jump, turn)
                assert not changed or jump > 0.25 or turn > 0.05, (sample, jump, turn)
            last, last_yaw = pose, yaw
        assert resets and min(resets) >= blind.stop and last.reset_counter == len(resets), resets
        assert worst < 0.5 and "HEARTBEAT" in self.seen, worst


if __name__ == "__main__":
    if sys.argv[1] == "drive":
        Vehicle(int(sys.argv[2])).drive()
    else:
        {"read": read, "write": write}[sys.argv[1]]()
