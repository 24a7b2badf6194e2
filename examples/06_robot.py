#!/usr/bin/env python3
"""A robot's end of a connection (docs/protocol.md), without dependencies: joints that are where they were told to be.

    python3 examples/06_robot.py 7448
    baton drive --on tcp://127.0.0.1:7448 --world flat --state torques

A real one does the same: where this one takes the target as its measurement, it writes to its motors and reads its
encoders, IMU and motor currents. And it is not as trusting: it judges targets, goes on by its clock, and can be damped.
"""

import json
import math
import random
import socket
import struct
import sys

HELLO, WELCOME, REFUSAL, START, TRUTH, MEASUREMENT, TARGET, REJECTED, DAMP, BYE = range(1, 11)
PERIOD = 0.005  # of a tick [s]
SIDE = {"shoulder_flexion": -0.349, "shoulder_abduction": 0.262, "elbow_rotation": 1.222, "elbow_flexion": 1.047,
        "hip_flexion": 0.475, "hip_abduction": 0.0, "knee_rotation": 0.0, "knee_flexion": 1.165, "ankle_flexion": 0.69,
        "ankle_abduction": 0.0}  # fmt: skip
STANCE = {f"{side}_{joint}": angle for side in ("left", "right") for joint, angle in SIDE.items()}  # of mighty [rad]
N = len(STANCE)
UPRIGHT = [1, 0, 0, 0, 1, 0, 0, 0, 1]  # attitude of the IMU, row by row
UNKNOWN = [math.nan] * 12  # no force sensors under the soles
BATTERY = 0.9  # charge, 0 to 1; math.nan: unknown


def send(connection, kind, body):
    body = json.dumps(body).encode() if isinstance(body, dict) else body
    connection.sendall(struct.pack("<IB", len(body), kind) + body)


def receive(connection):
    def exactly(size):
        data = connection.recv(size, socket.MSG_WAITALL)
        if len(data) < size:
            raise ConnectionError("the driver is gone")
        return data

    size, kind = struct.unpack("<IB", exactly(5))
    return kind, exactly(size)


def serve(connection):
    hello = json.loads(receive(connection)[1])
    if hello["baton"] != 1:
        return send(connection, REFUSAL, {"reason": "version", "text": "this robot speaks version 1"})
    if hello.get("role", "drive") != "drive":
        return send(connection, REFUSAL, {"reason": "protocol", "text": "this robot has nothing to damp"})
    send(connection, WELCOME, {"baton": 1, "robot": "example", "joints": list(STANCE), "period": PERIOD,
                               "lock_step": True, "on": "real"})  # fmt: skip
    receive(connection)  # start: the gains kp and kd of the servos
    q, dq, tau = list(STANCE.values()), [0.0] * N, [0.0] * N
    tick = 0
    while True:
        gravity = random.gauss(9.81, 0.02)  # a sensor that always says the same is doubted
        numbers = [tick * PERIOD, 0.0, BATTERY, *q, *dq, *tau, *UPRIGHT, 0, 0, 0, 0, 0, gravity, *UNKNOWN]
        send(connection, MEASUREMENT, struct.pack(f"<QII{len(numbers)}d", tick, 0, 0, *numbers))
        kind, body = receive(connection)
        if kind != TARGET:  # handed back
            return f"driven for {tick} ticks; left hip flexion at {q[4]:.2f} rad"
        sequence, *target = struct.unpack(f"<Q{3 * N}d", body)
        assert sequence == tick
        q, dq, tau = target[:N], target[N : 2 * N], target[2 * N :]  # a real one: to the motors, and back
        tick += 1


if __name__ == "__main__":
    with socket.create_server(("127.0.0.1", int(sys.argv[1]))) as listener:
        print(f"listening on port {listener.getsockname()[1]}", flush=True)
        while (driven := serve(listener.accept()[0])) is None:
            pass  # refused: the next one
        print(driven)
