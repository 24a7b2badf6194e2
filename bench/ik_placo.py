"""Inverse kinematics beside that of placo: the same robot and the same targets, one after the other in one process.

`make bench-placo` (ARGS="--robot talos"; default: g1). baton_bench solves and writes the targets of each tick of a walk
and a reach; placo then solves them, from the same first guesses and by as many steps as it needs to come as near. What
remains is computed by placo's kinematics for both.
"""

import argparse
import json
import math
import pathlib
import subprocess
import tempfile
import time
import xml.etree.ElementTree as xml

import numpy as np
import placo

MOST_STEPS = 3  # of a solve, as baton's
TOLERANCE = 1e-7  # of soles and COM at which it ends, as baton's [m], [rad]


def rotation(quat_wxyz):
    w, x, y, z = quat_wxyz
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def transform(pose):
    matrix = np.eye(4)
    matrix[:3, :3] = rotation(pose["quat_wxyz"])
    matrix[:3, 3] = pose["p"]
    return matrix


def angle_between(a, b):
    return 2.0 * math.asin(min(1.0, np.linalg.norm(a - b) / (2.0 * math.sqrt(2.0))))


def urdf(robot):
    """The robot without its shapes. Inertias do not matter to inverse kinematics."""
    root = xml.Element("robot", name="robot")

    def add(name, parent, pose, joint=None, body=None):
        link = xml.SubElement(root, "link", name=name)
        if body is not None:
            inertial = xml.SubElement(link, "inertial")
            xml.SubElement(inertial, "origin", xyz=numbers(body["com"]), rpy="0 0 0")
            xml.SubElement(inertial, "mass", value=repr(body["mass"]))
            xml.SubElement(inertial, "inertia", ixx="1", ixy="0", ixz="0", iyy="1", iyz="0", izz="1")
        if parent is None:
            return
        kind = "revolute" if joint else "fixed"
        element = xml.SubElement(root, "joint", name=joint["name"] if joint else f"to_{name}", type=kind)
        xml.SubElement(element, "parent", link=parent)
        xml.SubElement(element, "child", link=name)
        R = rotation(pose["quat_wxyz"])
        rpy = math.atan2(R[2, 1], R[2, 2]), -math.asin(max(-1.0, min(1.0, R[2, 0]))), math.atan2(R[1, 0], R[0, 0])
        xml.SubElement(element, "origin", xyz=numbers(pose["p"]), rpy=numbers(rpy))
        if joint:
            low, high = joint["range"]
            xml.SubElement(element, "axis", xyz=numbers(joint["axis"]))
            xml.SubElement(element, "limit", lower=repr(low), upper=repr(high), effort="1000", velocity="1000")

    for body in robot["bodies"]:
        add(body["name"], body.get("parent"), body, body.get("joint"), body)
    for kind in ("soles", "hands"):
        for at, frame in enumerate(robot[kind]):
            add(f"{kind}_{at}", frame["body"], frame)
    return xml.tostring(root, encoding="unicode")


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


class Placo:
    def __init__(self, robot):
        self.described = robot
        self.joints = robot["joints"]
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "robot.urdf"
            file.write_text(urdf(robot))
            self.robot = placo.RobotWrapper(str(file), placo.Flags.ignore_collisions)
        self.solver = None

    def set(self, q):
        """Configuration as baton's: root position, root quaternion wxyz, joints."""
        root = np.eye(4)
        root[:3, :3] = rotation(q[3:7])
        root[:3, 3] = q[:3]
        self.robot.set_T_world_fbase(root)
        for name, angle in zip(self.joints, q[7:]):
            self.robot.set_joint(name, angle)
        self.robot.update_kinematics()

    def begin(self, targets, home):
        """Tasks of a motion: soles and COM exactly, trunk, hands and all other joints as well as that allows."""
        self.solver = solver = placo.KinematicsSolver(self.robot)
        self.soles = [solver.add_frame_task(f"soles_{at}", np.eye(4)) for at in range(2)]
        for task in self.soles:
            task.configure("sole", "hard", 1.0, 1.0)
        self.com = solver.add_com_task(np.zeros(3))
        self.com.configure("com", "hard", 1.0)
        self.trunk = solver.add_orientation_task(self.described["trunk"], np.eye(3))
        self.trunk.configure("trunk", "soft", 10.0)
        self.hands = {}
        held = {}
        for at, hand in enumerate(targets["hands"]):
            if hand is not None:
                self.hands[at] = solver.add_frame_task(f"hands_{at}", np.eye(4))
                turns = 1.0 if self.described["hand_has_attitude"] else 0.0
                self.hands[at].configure("hand", "soft", 1.0, turns)
        free = {self.joints[j] for at, arm in enumerate(self.described["arms"]) if at not in self.hands for j in arm}
        for name, angle in zip(self.joints, home):
            if name in free:
                held[name] = angle
        self.arms = sorted(held)
        self.posture = solver.add_joints_task()
        self.posture.set_joints(held)
        self.posture.configure("arms", "soft", 1.0)
        solver.add_regularization_task(1e-6)

    def aim(self, targets):
        for at, task in enumerate(self.soles):
            task.T_world_frame = transform(targets["soles"][at])
        self.com.target_world = np.array(targets["com"])
        self.trunk.R_world_frame = rotation(targets["trunk"]["quat_wxyz"])
        for at, task in self.hands.items():
            task.T_world_frame = transform(targets["hands"][at])
        angles = dict(zip(self.joints, targets["arms"]))
        self.posture.set_joints({name: angles[name] for name in self.arms})

    def solve(self, targets):
        """CPU time [us] of the steps alone, and how many there were."""
        self.aim(targets)
        us = 0.0
        for step in range(1, MOST_STEPS + 1):
            before = time.thread_time()
            self.solver.solve(True)
            self.robot.update_kinematics()
            us += 1e6 * (time.thread_time() - before)
            if max(self.residuals(targets)[:2]) < TOLERANCE:
                break
        return us, step

    def residuals(self, targets):
        """Largest errors of soles and COM [m], of soles [rad], of the trunk [rad], of the hands [m]."""
        at = [self.robot.get_T_world_frame(f"soles_{k}") for k in range(2)]
        to = [transform(sole) for sole in targets["soles"]]
        place = max(np.linalg.norm(a[:3, 3] - b[:3, 3]) for a, b in zip(at, to))
        place = max(place, np.linalg.norm(self.robot.com_world() - targets["com"]))
        turn = max(angle_between(a[:3, :3], b[:3, :3]) for a, b in zip(at, to))
        trunk = self.robot.get_T_world_frame(self.described["trunk"])[:3, :3]
        trunk = angle_between(trunk, rotation(targets["trunk"]["quat_wxyz"]))
        hands = [
            np.linalg.norm(self.robot.get_T_world_frame(f"hands_{k}")[:3, 3] - hand["p"])
            for k, hand in enumerate(targets["hands"])
            if hand is not None
        ]
        return place, turn, trunk, max(hands, default=0.0)

    def state(self):
        root = self.robot.get_T_world_fbase()
        return root, np.array([self.robot.get_joint(name) for name in self.joints])


def guess(previous, before):
    """As baton's: joints and root position go on as in the tick before."""
    (root, q), (root_before, q_before) = previous, before
    root = root.copy()
    root[:3, 3] += root[:3, 3] - root_before[:3, 3]
    return root, 2.0 * q - q_before


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="g1")
    parser.add_argument("--bench", default="build/release/baton_bench")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "targets.json"
        command = [options.bench, "ik", "--robot", options.robot, "--ik-targets", str(file)]
        subprocess.run(command, check=True)
        robot = json.loads(file.read_text())
    other = Placo(robot)
    rows = {}
    for motion in robot["motions"]:
        other.begin(motion["ticks"][0]["targets"], motion["from"][7:])
        other.set(motion["from"])
        previous = before = other.state()
        row = rows.setdefault(motion["row"], {"baton": [], "placo": []})
        for tick in motion["ticks"]:
            targets = tick["targets"]
            root, q = guess(previous, before)
            other.robot.set_T_world_fbase(root)
            for name, angle in zip(other.joints, q):
                other.robot.set_joint(name, angle)
            other.robot.update_kinematics()
            us, steps = other.solve(targets)
            row["placo"].append([us, steps, *other.residuals(targets)])
            before, previous = previous, other.state()
        for tick in motion["ticks"]:
            other.set(tick["q"])
            row["baton"].append([tick["us"], math.nan, *other.residuals(tick["targets"])])
    print(f"\n{'':<28} {'median':>8} {'p99':>8} us  {'steps':>5}   worst: soles, COM; soles; trunk; hands")
    for name, row in rows.items():
        for who, values in row.items():
            if not values:
                continue
            us, steps, *rest = np.array(values).T
            median, p99 = np.quantile(us, [0.5, 0.99])
            worst = ", ".join(f"{r.max():.1e} {unit}" for r, unit in zip(rest, ("m", "rad", "rad", "m")))
            print(f"{name + ', ' + who:<28} {median:8.1f} {p99:8.1f}     {np.mean(steps):5.1f}   {worst}")
        if row["baton"] and row["placo"]:
            ratio = np.median(np.array(row["baton"])[:, 0]) / np.median(np.array(row["placo"])[:, 0])
            print(f"{name}: {ratio:.3f} of placo's time")


if __name__ == "__main__":
    main()
