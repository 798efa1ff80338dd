"""A ROS 2 node in front of the bridge: publishes the joints of the crane and sends the operator's velocity as sticks.

hydrocrane live tip-vertical-line --bridge udp://127.0.0.1:5005
python ros2_node.py 5005
ros2 topic pub -r 20 /cmd_vel geometry_msgs/msg/Twist "{linear: {z: 0.3}}"
"""

import json
import socket
import struct
import sys

import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import JointState

HEADER = struct.Struct("<4sHHIIdQ")
HELLO, VALUES, DESCRIPTION, SAMPLE, PROBLEM = 1, 2, 17, 18, 19


class Crane(Node):
    def __init__(self, port):
        super().__init__("crane")
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect(("127.0.0.1", port))
        self.socket.settimeout(5.0)
        self.send(HELLO, ())
        told = json.loads(self.next((DESCRIPTION,))[3])
        self.socket.setblocking(False)
        names = [output["name"] for output in told["outputs"]]
        self.joints = [name[6:-2] for name in names if name.startswith("joint.") and name.endswith(".q")]
        self.places = [[names.index(f"joint.{j}.{kind}") for j in self.joints] for kind in ("q", "qd")]
        self.sticks, self.sequence = (0.0, 0.0), 0
        self.publisher = self.create_publisher(JointState, "joint_states", 10)
        self.create_subscription(Twist, "cmd_vel", self.steer, 10)
        self.create_timer(told["period"], self.tick)

    def send(self, kind, values):
        now = self.get_clock().now().nanoseconds * 1e-9
        self.sequence = getattr(self, "sequence", 0) + 1
        header = HEADER.pack(b"HYCB", 1, kind, self.sequence, len(values), now, 0)
        self.socket.send(header + struct.pack(f"<{len(values)}d", *values))

    def next(self, kinds):
        """Kind, time, values and text of the next packet of these kinds."""
        while True:
            data = self.socket.recv(65_535)
            _, _, kind, _, count, time, _ = HEADER.unpack_from(data)
            if kind in kinds:
                text = data[HEADER.size :].decode() if kind != SAMPLE else ""
                values = struct.unpack_from(f"<{count}d", data, HEADER.size) if kind == SAMPLE else ()
                return kind, time, values, text

    def steer(self, twist):
        """Deflections of the stick from -1 to 1: forward and up."""
        self.sticks = tuple(max(-1.0, min(1.0, v)) for v in (twist.linear.x, twist.linear.z))

    def tick(self):
        self.send(VALUES, self.sticks)
        try:
            while True:
                kind, time, values, text = self.next((SAMPLE, PROBLEM))
                if kind == PROBLEM:
                    self.get_logger().warning(text)
                    continue
                state = JointState(name=self.joints)
                state.header.stamp.sec, state.header.stamp.nanosec = int(time), int(time % 1.0 * 1e9)
                state.position, state.velocity = ([values[i] for i in places] for places in self.places)
                self.publisher.publish(state)
        except BlockingIOError:
            pass


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(Crane(int(sys.argv[1])))
