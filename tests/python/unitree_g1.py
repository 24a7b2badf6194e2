"""A Unitree G1 in MuJoCo, on DDS as the robot is: the maker's SDK (far-unitree-sdk) publishes rt/lowstate, reads
rt/lowcmd, and answers its motion switcher. In real time.

    unitree_g1.py [--interface lo] [--gantry HEIGHT] [--switcher]

The robot hangs in a gantry, which holds its pelvis at HEIGHT. What is typed, a line each:

    height H      the gantry goes there, at 0.1 m/s
    free          the gantry lets go
    freeze, thaw  its states stay as they are, or go on
    mute, speak   no states are published, or they are again
    look          prints a line of JSON: how it is
    end
"""

import argparse
import json
import os
import pathlib
import select
import sys
import time

import mujoco
import numpy as np
import unitree_interface as sdk

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODEL = ROOT / "robots" / "g1" / "model" / "g1.xml"
STEP = 0.001  # of the physics [s]
PERIOD = 0.002  # of the states [s]
MOTORS = 29


def world():
    """The robot on a floor, without actuators: its motors are torques here. Its links pass through each other."""
    spec = mujoco.MjSpec.from_file(str(MODEL))
    spec.option.timestep = STEP
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for key in list(spec.keys):
        spec.delete(key)
    for geom in spec.geoms:
        if geom.contype:
            geom.contype, geom.conaffinity = 1, 0
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], contype=0, conaffinity=1)
    return spec.compile()


class Robot:
    def __init__(self, height):
        self.model = world()
        self.data = mujoco.MjData(self.model)
        self.pelvis = self.model.body("pelvis").id
        self.joints = range(1, 1 + MOTORS)  # after the free joint; in the order of the motors
        self.limit = np.array([self.model.jnt_actfrcrange[j, 1] for j in self.joints])
        self.gantry = height  # None: free
        self.gantry_goal = height
        self.noise = np.random.default_rng(1)
        self.torque = np.zeros(MOTORS)
        self.data.qpos[2] = height
        mujoco.mj_forward(self.model, self.data)

    def _pull(self):
        """The gantry: a spring and a damper on the pelvis, upwards and upright."""
        force = self.data.xfrc_applied[self.pelvis]
        force[:] = 0.0
        if self.gantry is None:
            return
        step = 0.1 * STEP
        self.gantry += np.clip(self.gantry_goal - self.gantry, -step, step)
        at, velocity = self.data.xpos[self.pelvis], self.data.qvel
        # A rope only pulls upwards; what keeps the robot from swinging and tilting are a helper's hands.
        force[2] = max(0.0, 5000.0 * (self.gantry - at[2]) - 500.0 * velocity[2])
        if force[2] == 0.0:
            return
        force[:2] = -400.0 * at[:2] - 100.0 * velocity[:2]
        tilt = np.zeros(3)
        mujoco.mju_quat2Vel(tilt, self.data.xquat[self.pelvis], 1.0)
        turning = self.data.xmat[self.pelvis].reshape(3, 3) @ velocity[3:6]
        force[3:] = -300.0 * tilt - 30.0 * turning

    def step(self, command):
        """Motors as they are: stiffness, damping, torque, up to what they can do."""
        q, dq = self.data.qpos[7:], self.data.qvel[6:]
        kp, kd = np.array(command.kp), np.array(command.kd)
        wanted = kp * (np.array(command.q_target) - q) + kd * (np.array(command.dq_target) - dq)
        self.torque = np.clip(wanted + np.array(command.tau_ff), -self.limit, self.limit)
        self.data.qfrc_applied[6:] = self.torque
        self._pull()
        mujoco.mj_step(self.model, self.data)

    def state(self, tick):
        state = sdk.LowState(MOTORS)
        state.tick, state.mode_machine = tick, 5
        state.motor.q, state.motor.dq = self.data.qpos[7:].tolist(), self.data.qvel[6:].tolist()
        state.motor.tau_est = self.torque.tolist()
        state.imu.quat = self.data.xquat[self.pelvis].tolist()
        gyro = self.data.sensor("imu-pelvis-angular-velocity").data
        force = self.data.sensor("imu-pelvis-linear-acceleration").data
        state.imu.omega = (gyro + self.noise.normal(0.0, 0.001, 3)).tolist()
        state.imu.accel = (force + self.noise.normal(0.0, 0.02, 3)).tolist()
        return state


def typed(rest):
    """The words of each line that has been typed. `rest` keeps what is no whole line yet."""
    while select.select([sys.stdin], [], [], 0)[0]:
        some = os.read(sys.stdin.fileno(), 4096)
        if not some:
            yield ["end"]
            return
        *lines, rest[:] = (bytes(rest) + some).split(b"\n")
        yield from (words for line in lines if (words := line.decode().split()))


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--interface", default="lo")
    options.add_argument("--gantry", type=float, default=0.85)
    options.add_argument("--switcher", action="store_true")
    o = options.parse_args()
    network = sdk.create_robot(o.interface, sdk.RobotType.G1, sdk.MessageType.HG)
    if o.switcher:
        network.enable_motion_switcher_responder()
    robot = Robot(o.gantry)
    frozen = muted = False
    tick = 0
    lost = worst = 0.0  # time in which nothing was simulated, as the computer was too slow [s]
    state = robot.state(tick)
    unfinished = bytearray()
    begin = due = time.monotonic()
    while True:
        for word, *rest in typed(unfinished):
            if word == "height":
                robot.gantry_goal = float(rest[0])
            elif word == "free":
                robot.gantry = None
            elif word in ("freeze", "thaw"):
                frozen = word == "freeze"
            elif word in ("mute", "speak"):
                muted = word == "mute"
            elif word == "look":
                command = network.read_incoming_command()
                at = robot.data.xpos[robot.pelvis]
                up = robot.data.xmat[robot.pelvis].reshape(3, 3)[2, 2]
                print(json.dumps({
                    "t": robot.data.time, "height": at[2], "x": at[0], "y": at[1], "upright": up,
                    "kp": max(command.kp), "kd": min(command.kd), "speed": float(np.abs(robot.data.qvel).max()),
                    "hand": robot.data.body("left_wrist_yaw_link").xpos.tolist(),
                    "torque": float(np.abs(robot.torque).max()), "lost": lost, "worst": worst,
                    "real": time.monotonic() - begin,
                }), flush=True)  # fmt: skip
            elif word == "end":
                return
        command = network.read_incoming_command()
        for _ in range(round(PERIOD / STEP)):
            robot.step(command)
        tick += round(1000 * PERIOD)
        if not frozen:
            state = robot.state(tick)
        if not muted:
            network.publish_low_state(state)
        due += PERIOD
        late = time.monotonic() - due
        if late > 0.02:  # too slow: time is left out, as nothing else can be done
            lost, worst, due = lost + late, max(worst, late), due + late
        elif late < 0.0:
            time.sleep(-late)


if __name__ == "__main__":
    main()
