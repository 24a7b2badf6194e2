"""A robot of one's own: mighty in a plain MuJoCo loop that is not baton's, guided forward and back again.

    python examples/python/03_own_simulator.py

`Mine` is all that baton wants of a robot. On hardware `read` asks the drivers, and `write` tells the servos and waits for
the next tick. Here the sensors are exact, and the model's forces under the soles are left out: motor torques do.
"""

import sys

import mujoco
import numpy as np

import baton


class Mine:
    def __init__(self, robot, world):
        self.robot = robot
        self.start = robot.standing(world)
        self.model = mujoco.MjModel.from_xml_string(robot.mjcf(world))
        self.data = mujoco.MjData(self.model)
        joints = [self.model.joint(joint.name) for joint in robot.joints]
        self.q = np.array([joint.qposadr[0] for joint in joints])
        self.dq = np.array([joint.dofadr[0] for joint in joints])
        driven = [int(np.flatnonzero(self.model.actuator_trnid[:, 0] == joint.id)[0]) for joint in joints]
        self.motor = np.array(driven)
        self.limit = np.array([joint.torque for joint in robot.joints])
        self.imu = self.model.site("imu").id
        self.reset()

    def reset(self):
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = self.start
        mujoco.mj_forward(self.model, self.data)
        self.velocity = np.zeros(3)
        self.acceleration = -self.model.opt.gravity
        self.torque = np.zeros(len(self.limit))

    def imu_velocity(self):
        """Angular velocity in the IMU's frame, and linear velocity in the world."""
        six = np.zeros(6)
        mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_SITE, self.imu, six, 1)
        return six[:3], self.data.site_xmat[self.imu].reshape(3, 3) @ six[3:]

    def read(self):
        attitude = self.data.site_xmat[self.imu].reshape(3, 3)
        return baton.Measurement(
            t=self.data.time,
            q=self.data.qpos[self.q],
            dq=self.data.qvel[self.dq],
            attitude=attitude,
            rate=self.imu_velocity()[0],
            acceleration=attitude.T @ self.acceleration,
            torque=self.torque,
        )

    def write(self, target):
        steps = round(self.robot.period / self.model.opt.timestep)
        total = np.zeros(len(self.limit))
        for step in range(steps):
            q, dq, tau = self.robot.servo_command(target, self.robot.period - step * self.model.opt.timestep)
            error = q - self.data.qpos[self.q]
            torque = tau + self.robot.kp * error + self.robot.kd * (dq - self.data.qvel[self.dq])
            self.data.ctrl[self.motor] = np.clip(torque, -self.limit, self.limit)
            total += self.data.ctrl[self.motor]
            mujoco.mj_step(self.model, self.data)
        mujoco.mj_forward(self.model, self.data)
        velocity = self.imu_velocity()[1]
        self.acceleration = (velocity - self.velocity) / self.robot.period - self.model.opt.gravity
        self.velocity = velocity
        self.torque = total / steps


robot = baton.Robot("mighty")
mine = Mine(robot, "flat")
run = baton.Run(robot, "flat", on=mine, state="torques")
run.guide("trunk", [1, 0, 0, 0, 0, 0])
run.advance(8.0)
way = mine.data.qpos[0] - mine.start[0]
run.retrace()
run.advance(20.0)
off = mine.data.qpos[:2] - mine.start[:2]
print(f"{way:.2f} m ahead; then {1000 * np.hypot(*off):.0f} mm beside the start, "
      f"{'fallen' if run.fallen else 'on its feet'}")  # fmt: skip
sys.exit(int(run.fallen or way < 0.2))
