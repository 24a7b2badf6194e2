#!/usr/bin/env python3
"""Judge a run by its trace alone: an independent program that shares no code with baton.

    check_trace.py TRACE.csv --model MODEL.xml --profile PROFILE.toml [--on ideal|sim] [--report R.json]
                   [--script S.jsonl]

TRACE and MODEL are what `baton drive --trace TRACE --save-model MODEL` wrote. Every tick is looked at. Forces follow from
the momentum of the links: their places are taken from MuJoCo's kinematics, everything else is worked out here by
differences in time, so neither MuJoCo's dynamics nor the program's are trusted.

With `--on sim`, measured columns are judged by the states and by the plan, within the tubes below (docs/trace.md):
- forces and ZMP by the rates of momentum, from qpos and qvel (Newton-Euler), means of 50 ms;
- the feet's shares by MuJoCo's contact law, from the depth of each contact;
- the planned COM and ZMP by the planned joints, in the model of the profile;
- COM, ZMP and joints by the planned ones, relative to the sole that stands.

Prints a summary as JSON: `violations` (kind, tick, value, limit, count) and `numbers`, the worst of each quantity; with
the script that was driven also `commands`: how many were given and how many moved what they guide.
Exit 0 without, 1 with violations, 2 for files that cannot be read.
Needs numpy and mujoco.
"""

import argparse
import json
import pathlib
import sys
import tomllib

import mujoco
import numpy as np

SIDES = ("left", "right")
PHASES = ("hold", "double", "single_left", "single_right", "fallen")
FIXED_COLUMNS = ("t", "guide", "segment", "phase")
ON_LIMITS = {
    # what a rounding error, the tolerance of inverse kinematics (0.1 mm) or ten printed digits may spoil
    "ideal": {
        "range": 1e-9,  # [rad] beyond the joint limits
        "speed": 1.0,  # of the profile's share of the no-load speed
        "consistency": 0.35,  # [rad/s] step of qpos against the mean of qvel at its ends
        "slip": 1e-4,  # [m] of a planned sole, within a phase
        "yaw": 0.006,  # [rad] of the soles against each other, beyond their region
        "ground": 3e-4,  # [m] of a planned sole, against the ground
        "swing": 3e-4,  # [m] of a swing sole below the ground
        "gap": 1e-4,  # [m]
        "self": 1e-4,  # [m]
        "com": 5e-4,  # [m] of the planned COM against the true one
        "zmp": 3e-3,  # [m] of the planned ZMP against the one found here
        "rest": 1e-9,  # [rad/s] in hold
        "report_zmp": 5e-4,  # [m] of the report's measured margin; on tilted ground the plane of the ZMP is not that of the soles
        "tilt": 0.02,  # [rad] of the trunk beyond its range
    },
    "sim": {
        "range": 0.02,  # limits are springs
        "speed": 1.0 / 0.85,
        "slip": 0.02,
        "yaw": 0.6,
        "ground": 0.02,
        "swing": 0.01,
        "gap": 0.009,
        "self": 0.004,
        "rest": 0.6,
        "report_zmp": 2e-3,
        "tilt": 0.15,
    },
}


# In physics, tubes around what was measured. An error counts as far as it lasts: the value judged is the largest that it
# does not fall below for PATIENCE. A push (50 ms in all scenarios), of which the trace does not tell, does not last so
# long, even within a moving mean.
WINDOW = 0.05  # [s] of a moving mean: forces are sampled once a tick, and contacts shake
PATIENCE = 0.15  # [s]
LAG_PATIENCE = 0.25  # [s] for lags
SPLIT_WINDOW = 0.5  # [s] of the median of the error of the feet's shares: a contact in motion also has an acceleration
BEGINNING = 0.5  # [s]
FALL = 1.0  # [s] before a fall nothing is judged by these
TUBES = {
    # Lengths [m] are those of a robot with the COM height of mighty, for others in proportion.
    # Honest runs of 12 to 20 s, of --plant model and real and of most scenarios of docs/balance.md, stay inside.
    "newton_force": 0.10,  # [weight] vertical force against the rate of momentum
    "newton_mean": 0.03,  # [weight] the same, mean of the run
    "newton_zmp": 0.012,  # measured ZMP against that of the rates of momentum
    "lag": 0.02,  # [s] between those two, in windows of 1 s
    "lag_least": 0.003,  # rms difference of the two from which a lag is looked for
    "load_split": 0.15,  # share of each foot in the vertical force, against the springs of its contacts
    "plan_step": 0.002,  # jump of a planned standing sole, by planned joints and planned COM, from tick to tick
    "plan_step_between": 0.010,  # the same where motions meet, and the plan is aligned with the soles
    "plan_zmp": 0.012,  # planned ZMP against that of the planned joints, relative to the planned COM
    "place_begin": 0.012,  # standing sole, planned against true, until BEGINNING
    "place": 0.060,  # later, beyond
    "place_share": 0.05,  # this share of the way: odometry drifts
    "com": 0.030,  # COM relative to the standing sole, planned against true
    "com_rms": 0.010,
    "zmp": 0.060,  # ZMP relative to the standing sole, planned against measured
    "zmp_rms": 0.025,
    "joint": 0.25,  # [rad] joint angles, planned against true: a sole may be inclined by 0.2 rad against its plan
    "joint_rms": 0.05,  # [rad]
    "consistency": 0.5,  # [rad/s] change of a joint's angle against its speed, means
}
LONGEST_LAG = 20  # [ticks] looked for
COPIED = 10  # [ticks] for which a measured value may equal a planned one, or an earlier one, while the robot moves

LEAST_LIFT = 0.05  # of the throttle: below, it counts as zero
LEAST_DURATION = 0.5  # [s] of a motion, by the paper's rule

# ---------------------------------------------------------------- reading


class Trace:
    """The columns of a trace: `number[name]` and `word[name]`, a value a tick."""

    def __init__(self, file):
        with open(file) as stream:
            self.names = stream.readline().rstrip("\n").split(",")
            rows = [line.rstrip("\n").split(",") for line in stream]
        for i, row in enumerate(rows):
            if len(row) != len(self.names):
                raise ValueError(f"{file}: row {i + 1} has {len(row)} values, the header {len(self.names)}")
        if len(rows) < 3:
            raise ValueError(f"{file}: {len(rows)} rows")
        self.word = {"guide": [row[1] for row in rows], "phase": [row[3] for row in rows]}
        columns = [i for i, name in enumerate(self.names) if name not in self.word]
        table = np.array([[row[i] for i in columns] for row in rows], dtype=float)
        self.number = {self.names[i]: table[:, k] for k, i in enumerate(columns)}
        self.ticks = len(rows)

    def block(self, prefix):
        """All columns whose names begin with the prefix."""
        names = [name for name in self.names if name.startswith(prefix)]
        return np.stack([self.number[name] for name in names], axis=1)


class Robot:
    """What the checks need of model and profile."""

    def __init__(self, model_file, profile_file):
        self.m = m = mujoco.MjModel.from_xml_path(str(model_file))
        self.profile = tomllib.loads(pathlib.Path(profile_file).read_text())
        roots = [b for b in range(m.nbody) if m.body_dofnum[b] == 6]
        if len(roots) != 1:
            raise ValueError(f"{model_file}: {len(roots)} floating bodies, one wanted")
        self.root = roots[0]
        self.free = m.jnt_qposadr[m.body_jntadr[self.root]]
        self.bodies = np.array([b for b in range(m.nbody) if m.body_rootid[b] == self.root])
        motor = {int(m.actuator_trnid[i, 0]): i for i in range(m.nu)}
        # A hinge without a motor is the compliance of the one before it, about the same axis: the trace has their sum.
        self.hinges = np.array([j for j in range(m.njnt) if j in motor])
        self.qadr = m.jnt_qposadr[self.hinges]
        self.dadr = m.jnt_dofadr[self.hinges]
        self.range = m.jnt_range[self.hinges]
        gear = np.array([m.actuator_gear[motor[j], 0] for j in self.hinges])
        self.stall = np.array([m.actuator_ctrlrange[motor[j], 1] for j in self.hinges]) * gear
        self.damping = m.dof_damping[self.dadr]
        self.armature = m.dof_armature[self.dadr]
        self.no_load = self.stall / self.damping
        self.joint_names = [m.joint(int(j)).name.split("/")[-1] for j in self.hinges]
        self.mass = m.body_mass[self.bodies].sum()
        # subtree[j, b]: whether link b hangs on joint j
        self.subtree = np.zeros((len(self.hinges), len(self.bodies)), bool)
        for k, j in enumerate(self.hinges):
            for i, b in enumerate(self.bodies):
                up = b
                while up not in (0, m.jnt_bodyid[j]):
                    up = m.body_parentid[up]
                self.subtree[k, i] = up == m.jnt_bodyid[j]
        parts = self.profile["parts"]
        self.trunk = self.body(parts["trunk"])
        self.sole_site = [self.site(parts[f"{side}_foot"]) for side in SIDES]
        self.foot_body = [int(m.site_bodyid[s]) for s in self.sole_site]
        self.sole_corners, self.sole_geom = zip(*(self._corners(s) for s in self.sole_site))
        self.pairs = [(int(a), int(b)) for a, b in zip(m.pair_geom1, m.pair_geom2)]
        self.ground = [g for g in range(m.ngeom) if m.geom_bodyid[g] == 0 and m.geom(g).name.split("/")[-1].startswith("ground")]
        self.obstacles = [g for g in range(m.ngeom) if m.geom_bodyid[g] == 0 and m.geom_contype[g] and g not in self.ground]
        self.colliders = [
            g for g in range(m.ngeom) if m.body_rootid[m.geom_bodyid[g]] == self.root and m.geom_contype[g] and g not in self.sole_geom
        ]

    def configurations(self, columns):
        """Configurations of the model: pose of the root, then a value a joint."""
        q = np.zeros((len(columns), self.m.nq))
        q[:, [*range(self.free, self.free + 7), *self.qadr]] = columns
        return q

    def velocities(self, columns):
        v = np.zeros((len(columns), self.m.nv))
        root = self.m.jnt_dofadr[self.m.body_jntadr[self.root]]
        v[:, [*range(root, root + 6), *self.dadr]] = columns
        return v

    def _named(self, kind, count, name):
        found = [i for i in range(count) if kind(i).name.split("/")[-1] == name]
        if len(found) != 1:
            raise ValueError(f"{len(found)} things in the model are called {name}")
        return found[0]

    def hand_has_attitude(self, part):
        """An arm of fewer than six joints only places its hand."""
        body, joints = int(self.m.site_bodyid[self.site(self.profile["parts"][part])]), 0
        while body not in (0, self.trunk):
            joints += self.m.body_dofnum[body]
            body = self.m.body_parentid[body]
        return joints >= 6

    def body(self, name):
        return self._named(self.m.body, self.m.nbody, name)

    def site(self, name):
        return self._named(self.m.site, self.m.nsite, name)

    def _corners(self, site):
        """Corners of the sole in the frame of its body, and its geom: the colliding box whose underside is at the site."""
        m, body = self.m, int(self.m.site_bodyid[site])
        for g in range(m.ngeom):
            if m.geom_bodyid[g] != body or not m.geom_contype[g] or m.geom_type[g] != mujoco.mjtGeom.mjGEOM_BOX:
                continue
            x, y, z = m.geom_size[g]
            if abs(m.geom_pos[g, 2] - z - m.site_pos[site, 2]) < 1e-4:
                corners = np.array([[x, y, -z], [-x, y, -z], [-x, -y, -z], [x, -y, -z]])
                R = np.zeros(9)
                mujoco.mju_quat2Mat(R, m.geom_quat[g])
                return m.geom_pos[g] + corners @ R.reshape(3, 3).T, g
        raise ValueError(f"no sole at site {m.site(site).name}")


# ---------------------------------------------------------------- geometry, for all ticks at once


def cross2(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def hull_margin(points, valid, x):
    """Distance of x to the edge of the hull, negative outside (there, the largest distance to an edge's line).

    points (N, P, 2), valid (N, P) which of them count, x (N, 2)."""
    n, count, _ = points.shape
    points = np.where(valid[..., None], points, 0.0)
    known = np.isfinite(x).all(axis=1)
    x = np.where(known[:, None], x, 0.0)
    margin = np.full(n, np.inf)
    edges = np.zeros(n, int)
    for i in range(count):
        for j in range(count):
            if i == j:
                continue
            along = points[:, j] - points[:, i]
            length = np.hypot(along[:, 0], along[:, 1])
            usable = valid[:, i] & valid[:, j] & (length > 1e-9)
            left = cross2(along[:, None], points - points[:, i, None]) / np.maximum(length, 1e-12)[:, None]
            usable &= np.all((left >= -1e-9) | ~valid, axis=1)
            distance = cross2(along, x - points[:, i]) / np.maximum(length, 1e-12)
            margin = np.where(usable, np.minimum(margin, distance), margin)
            edges += usable
    margin[(edges < 3) | ~known] = -np.inf
    return margin


def _axis_gap(a, b):
    """Largest gap along the normals of polygon a's edges (N, P, 2), counter-clockwise or not; negative: overlap."""
    best = np.full(len(a), -np.inf)
    for i in range(a.shape[1]):
        edge = a[:, (i + 1) % a.shape[1]] - a[:, i]
        normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.maximum(np.linalg.norm(edge, axis=1), 1e-12)[:, None]
        middle = a.mean(axis=1) - a[:, i]
        normal *= -np.sign(np.einsum("nk,nk->n", normal, middle))[:, None]
        best = np.maximum(best, np.einsum("npk,nk->np", b - a[:, i, None], normal).min(axis=1))
    return best


def polygon_gap(a, b):
    """Distance of two convex polygons (N, P, 2); where they overlap, minus the depth."""
    separating = np.maximum(_axis_gap(a, b), _axis_gap(b, a))
    nearest = np.full(len(a), np.inf)
    for p, q in ((a, b), (b, a)):
        for i in range(q.shape[1]):
            start, along = q[:, i], q[:, (i + 1) % q.shape[1]] - q[:, i]
            to = p - start[:, None]
            s = np.clip(np.einsum("npk,nk->np", to, along) / np.maximum((along**2).sum(1), 1e-18)[:, None], 0, 1)
            nearest = np.minimum(nearest, np.linalg.norm(to - s[..., None] * along[:, None], axis=2).min(axis=1))
    return np.where(separating > 0, nearest, separating)


def rotation_vector(R):
    """Logarithm of rotations (…, 3, 3) that are small."""
    skew = np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]], axis=-1) / 2
    sine = np.linalg.norm(skew, axis=-1)
    angle = np.arctan2(sine, (np.trace(R, axis1=-2, axis2=-1) - 1) / 2)
    return skew * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 1.0)[..., None]


class Ground:
    """What may be stood on: planes and upright boxes, or all of them tilted together; `level` turns that back."""

    def __init__(self, robot):
        m = robot.m
        data = mujoco.MjData(m)
        mujoco.mj_kinematics(m, data)
        self.boxes, self.floor, self.level = [], -np.inf, np.eye(3)
        for i, g in enumerate(robot.ground):
            R, p = data.geom_xmat[g].reshape(3, 3), data.geom_xpos[g]
            if i == 0:
                self.level = _turn_upright(R[:, 2])
            R, p = self.level @ R, self.level @ p
            if R[2, 2] < 1 - 1e-9:
                raise ValueError(f"ground {m.geom(g).name} is not parallel to the rest")
            if m.geom_type[g] == mujoco.mjtGeom.mjGEOM_PLANE:
                self.floor = max(self.floor, p[2])
            elif m.geom_type[g] == mujoco.mjtGeom.mjGEOM_BOX:
                x, y, z = m.geom_size[g]
                corners = p[:2] + np.array([[x, y], [-x, y], [-x, -y], [x, -y]]) @ R[:2, :2].T
                self.boxes.append((corners, p[2] + z))
            else:
                raise ValueError(f"ground {m.geom(g).name} is neither a plane nor a box")

    def heights(self, outline):
        """Highest and lowest ground below polygons (N, 4, 2)."""
        highest = np.full(len(outline), self.floor)
        lowest = np.full(len(outline), np.inf)
        samples = self._samples(outline)
        at = np.full(samples.shape[:2], self.floor)
        low, high = outline.min(axis=1), outline.max(axis=1)
        for corners, top in self.boxes:
            first, last = corners.min(axis=0), corners.max(axis=0)
            if (low.min(axis=0) > last).any() or (high.max(axis=0) < first).any():
                continue
            near = np.flatnonzero(((low < last) & (high > first)).all(axis=1))
            if len(near) == 0:
                continue
            touched = polygon_gap(outline[near], np.broadcast_to(corners, (len(near), 4, 2))) < 0
            highest[near] = np.where(touched, np.maximum(highest[near], top), highest[near])
            inside = np.ones((len(near), samples.shape[1]), bool)
            for i in range(4):
                edge = corners[(i + 1) % 4] - corners[i]
                inside &= cross2(edge, samples[near] - corners[i]) >= 0
            at[near] = np.where(inside, np.maximum(at[near], top), at[near])
        lowest = at.min(axis=1)
        return highest, lowest

    @staticmethod
    def _samples(outline, n=9):
        u = (np.arange(n) + 0.5) / n
        s, t = (v.ravel() for v in np.meshgrid(np.r_[0, u, 1], np.r_[0, u, 1]))
        weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
        return np.einsum("kc,ncd->nkd", weights, outline)


# ---------------------------------------------------------------- the motion, from the trace and the model


class Motion:
    """Kinematics of every tick, and what follows from it by differences."""

    def __init__(self, robot, q, v, dt, springs=None):
        m, n = robot.m, len(q)
        data = mujoco.MjData(m)
        bodies = robot.bodies
        self.q, self.v = q, v
        self.place = np.empty((n, m.nbody, 3))  # centre of mass of each link
        turn = np.empty((n, m.nbody, 9))
        origin, attitude = np.empty((n, m.nbody, 3)), np.empty((n, m.nbody, 9))
        self.anchor, self.axis = np.empty((n, m.njnt, 3)), np.empty((n, m.njnt, 3))
        self.self_distance = np.full(n, np.inf)
        self.self_pair = np.zeros(n, int)
        self.world_distance = np.full(n, np.inf)
        self.subtree_momentum = np.full((n, 6), np.nan)  # from qvel: linear, angular about the COM
        reach = 4 * robot.profile["margin"]["self_collision"] + 0.01
        fromto = np.zeros(6)
        links, world = np.array(robot.colliders), np.array(robot.obstacles + robot.ground)
        plane = m.geom_rbound[world] == 0
        far = m.geom_rbound[links][:, None] + m.geom_rbound[world] + reach
        for k in range(n):
            data.qpos[:] = q[k]
            data.qvel[:] = v[k]
            mujoco.mj_kinematics(m, data)
            mujoco.mj_comPos(m, data)
            mujoco.mj_comVel(m, data)
            mujoco.mj_subtreeVel(m, data)
            self.place[k], turn[k] = data.xipos, data.ximat
            origin[k], attitude[k] = data.xpos, data.xmat
            self.anchor[k], self.axis[k] = data.xanchor, data.xaxis
            self.subtree_momentum[k, :3] = robot.mass * data.subtree_linvel[robot.root]
            self.subtree_momentum[k, 3:] = data.subtree_angmom[robot.root]
            if springs is not None:
                mujoco.mj_collision(m, data)
                springs.look(k, data)
            still = k > 0 and np.array_equal(q[k], q[k - 1])
            if still:
                self.self_distance[k], self.self_pair[k] = self.self_distance[k - 1], self.self_pair[k - 1]
                self.world_distance[k] = self.world_distance[k - 1]
                continue
            centre = data.geom_xpos
            for i, (a, b) in enumerate(robot.pairs):
                d = mujoco.mj_geomDistance(m, data, a, b, reach, fromto)
                if d < self.self_distance[k]:
                    self.self_distance[k], self.self_pair[k] = d, i
            lowest, highest = centre[links].min(axis=0), centre[links].max(axis=0)
            near = plane | ((centre[world] + far.max(axis=0)[:, None] > lowest) & (centre[world] - far.max(axis=0)[:, None] < highest)).all(axis=1)
            apart = centre[links][:, None] - centre[world[near]]
            close = np.where(plane[near], apart[..., 2], np.abs(apart).max(axis=2)) <= far[:, near]
            for a, b in zip(links[close.nonzero()[0]], world[near][close.nonzero()[1]]):
                self.world_distance[k] = min(self.world_distance[k], mujoco.mj_geomDistance(m, data, a, b, reach, fromto))
        turn, self.attitude = turn.reshape(n, m.nbody, 3, 3), attitude.reshape(n, m.nbody, 3, 3)
        self.place, turn = self.place[:, bodies], turn[:, bodies]
        self.com = np.einsum("b,nbk->nk", m.body_mass[bodies], self.place) / robot.mass
        self.force, self.moment = link_wrenches(robot, self.place, turn, dt)
        self.total_force, self.total_moment = self.force.sum(axis=1), self.moment.sum(axis=1)

        # The same wrench from qvel, by central differences, as someone else might do it.
        rate = np.zeros((n, 6))
        rate[1:-1] = (self.subtree_momentum[2:] - self.subtree_momentum[:-2]) / (2 * dt)
        self.other_force = rate[:, :3] - robot.mass * m.opt.gravity
        self.other_moment = rate[:, 3:] + np.cross(self.com, self.other_force)

        self.corners = np.stack(
            [
                origin[:, b, None] + np.einsum("nij,cj->nci", self.attitude[:, b], robot.sole_corners[i])
                for i, b in enumerate(robot.foot_body)
            ],
            axis=1,
        )  # (N, side, 4, 3)
        self.trunk = self.attitude[:, robot.trunk]
        sites = np.array(robot.sole_site)
        feet = np.array(robot.foot_body)
        R = np.zeros((2, 9))
        for i, s in enumerate(sites):
            mujoco.mju_quat2Mat(R[i], m.site_quat[s])
        self.sole_turn = self.attitude[:, feet] @ R.reshape(2, 3, 3)
        self.sole = origin[:, feet] + np.einsum("nsij,sj->nsi", self.attitude[:, feet], m.site_pos[sites])


def link_wrenches(robot, place, turn, dt):
    """Force and moment about the origin, of the world and the neighbours, on each link (N, link, 3), without its weight.

    place (N, link, 3): centres of mass; turn (N, link, 3, 3): attitudes of the axes of inertia. At the first and the last
    tick the rate of momentum is left out."""
    weight, inertia = robot.m.body_mass[robot.bodies], robot.m.body_inertia[robot.bodies]
    # Momentum of each link halfway between the ticks, and its rate at the ticks.
    velocity = np.diff(place, axis=0) / dt
    spin = rotation_vector(turn[1:] @ np.swapaxes(turn[:-1], -1, -2)) / dt
    half = turn[:-1] @ _small_rotation(rotation_vector(np.swapaxes(turn[:-1], -1, -2) @ turn[1:]) / 2)
    own = np.einsum("nbij,nbj->nbi", half, inertia * np.einsum("nbji,nbj->nbi", half, spin))
    linear = weight[:, None] * velocity
    angular = own + np.cross((place[1:] + place[:-1]) / 2, linear)
    force, moment = np.zeros_like(place), np.zeros_like(place)
    force[1:-1] = np.diff(linear, axis=0) / dt
    moment[1:-1] = np.diff(angular, axis=0) / dt
    lift = -robot.m.opt.gravity * weight[:, None]
    return force + lift, moment + np.cross(place, lift)


class Posture:
    """Links, soles and COM of every tick, in the world: what the joints alone say, if the root is left at the origin."""

    def __init__(self, robot, q):
        m, n = robot.m, len(q)
        data = mujoco.MjData(m)
        self.place, self.turn = np.empty((n, len(robot.bodies), 3)), np.empty((n, len(robot.bodies), 9))
        self.sole, self.sole_turn = np.empty((n, 2, 3)), np.empty((n, 2, 9))
        for k in range(n):
            data.qpos[:] = q[k]
            mujoco.mj_kinematics(m, data)
            self.place[k], self.turn[k] = data.xipos[robot.bodies], data.ximat[robot.bodies]
            self.sole[k], self.sole_turn[k] = data.site_xpos[robot.sole_site], data.site_xmat[robot.sole_site]
        self.turn, self.sole_turn = self.turn.reshape(n, -1, 3, 3), self.sole_turn.reshape(n, 2, 3, 3)
        self.com = np.einsum("b,nbk->nk", m.body_mass[robot.bodies], self.place) / robot.mass


class Springs:
    """Normal forces of the soles' contacts by MuJoCo's contact law, from the depth r < 0 of each contact and its rate v:
    f = (−b v − k d(r) r) / R, R = A (1 − d) / d, with b, k, d from `solref` and `solimp` and A from `body_invweight0`
    [MuJoCo documentation, Computation, "Constraint model"]. The contact's own acceleration is left out: it has no mean."""

    def __init__(self, robot, n):
        self.robot = robot
        self.feet = np.array(robot.foot_body)
        self.side_of = np.full(robot.m.ngeom + 1, -1)  # the last: no geom
        self.side_of[list(robot.sole_geom)] = 0, 1
        self.tick, self.rows = [], []
        self.velocity, self.about = np.empty((n, 2, 6)), np.empty((n, 3))  # of the feet's bodies, where

    def look(self, k, data):
        contact, m = data.contact, self.robot.m
        self.velocity[k], self.about[k] = data.cvel[self.feet], data.subtree_com[self.robot.root]
        geom = contact.geom
        side = self.side_of[geom]
        which = np.flatnonzero((side.max(axis=1) >= 0) & (m.geom_bodyid[geom] == 0).any(axis=1))
        if len(which):
            sign = np.where(side[which, 1] >= 0, 1.0, -1.0)
            parts = (side[which].max(axis=1), contact.dist[which], sign, contact.pos[which], contact.frame[which, :3])
            self.rows.append(np.column_stack([np.full(len(which), k), *parts, contact.solref[which], contact.solimp[which]]))

    def vertical(self):
        """(N, side) [N]"""
        force = np.zeros((len(self.about), 2))
        if not self.rows:
            return force
        rows = np.concatenate(self.rows)
        k, side = rows[:, 0].astype(int), rows[:, 1].astype(int)
        r, normal, at = rows[:, 2], rows[:, 3, None] * rows[:, 7:10], rows[:, 4:7]
        stiff, damp, d0, dw, width, middle, power = rows[:, 10:].T
        turns, moves = self.velocity[k, side, :3], self.velocity[k, side, 3:]
        v = (normal * (moves + np.cross(turns, at - self.about[k]))).sum(axis=1)
        x = np.clip(-r / width, 0, 1)
        d = d0 + (dw - d0) * np.where(
            x <= middle, x**power / middle ** (power - 1), 1 - (1 - x) ** power / (1 - middle) ** (power - 1)
        )
        with np.errstate(divide="ignore"):
            spring = np.where(stiff > 0, 1 / (dw * stiff * damp) ** 2, -stiff / dw**2)
            damper = np.where(stiff > 0, 2 / (dw * stiff), -damp / dw)
        R = self.robot.m.body_invweight0[self.feet[side], 0] * (1 - d) / d
        np.add.at(force, (k, side), np.maximum(0, -damper * v - spring * d * r) / R * normal[:, 2])
        return force


def _small_rotation(w):
    """Rodrigues, (…, 3) → (…, 3, 3)."""
    angle = np.linalg.norm(w, axis=-1)[..., None, None]
    K = np.zeros((*w.shape[:-1], 3, 3))
    K[..., 0, 1], K[..., 0, 2], K[..., 1, 2] = -w[..., 2], w[..., 1], -w[..., 0]
    K -= np.swapaxes(K, -1, -2)
    safe = np.maximum(angle, 1e-12)
    return np.eye(3) + np.where(angle > 1e-9, np.sin(safe) / safe, 1) * K + np.where(angle > 1e-9, (1 - np.cos(safe)) / safe**2, 0.5) * (K @ K)


def _turn_upright(up):
    """The smallest rotation that makes this unit vector the z axis."""
    w = np.cross(up, [0, 0, 1])
    K = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    return np.eye(3) + K + K @ K / (1 + up[2])


def zmp(force, moment, height):
    """Where the line of force meets the plane z = height."""
    with np.errstate(divide="ignore", invalid="ignore"):
        x = (force[:, 0] * height - moment[:, 1]) / force[:, 2]
        y = (force[:, 1] * height + moment[:, 0]) / force[:, 2]
    return np.where((force[:, 2] > 0)[:, None], np.stack([x, y], axis=1), np.nan)


def support(corners, com, contact):
    """Vertices of the supporting soles, projected centrally from the COM onto the plane of the lower one.

    Returns points (N, 8, 2), which of them count, and the plane's height."""
    height = np.where(contact, corners[..., 2].mean(axis=2), np.inf).min(axis=1)
    flat = corners.reshape(len(corners), 8, 3)
    c = com[:, None]
    share = (com[:, 2] - height)[:, None] / (com[:, 2, None] - flat[..., 2])
    points = (c + (flat - c) * share[..., None])[..., :2]
    return points, np.repeat(contact, 4, axis=1), height


# ---------------------------------------------------------------- the checks


class Findings:
    def __init__(self):
        self.violations, self.numbers = {}, {}

    def add(self, kind, ticks, values, limit):
        """Violations of one kind; the worst is the first given if values have no order, so give excesses."""
        ticks = np.atleast_1d(ticks)
        if len(ticks) == 0:
            return
        values = np.atleast_1d(np.asarray(values, float))
        self.violations[kind] = {"kind": kind, "tick": int(ticks[0]), "value": float(values[0]), "limit": limit, "count": len(ticks)}

    def at_least(self, kind, values, limit, where=None):
        self._bound(kind, np.asarray(values, float), limit, where, lower=True)

    def at_most(self, kind, values, limit, where=None):
        self._bound(kind, np.asarray(values, float), limit, where, lower=False)

    def _bound(self, kind, values, limit, where, lower):
        """A bound at every tick; `where`: ticks that count. Not a number is a violation."""
        ticks = np.arange(len(values)) if where is None else np.flatnonzero(where)
        if len(ticks) == 0:
            self.numbers[kind] = None
            return
        chosen = values[ticks]
        bad = ~(chosen >= limit) if lower else ~(chosen <= limit)
        worst = np.nanargmin(chosen) if lower and not np.isnan(chosen).all() else (0 if np.isnan(chosen).all() else np.nanargmax(chosen))
        self.numbers[kind] = _json(chosen[worst])
        if bad.any():
            k = np.flatnonzero(bad)
            worst = k[np.argmin(chosen[k])] if lower else k[np.argmax(chosen[k])]
            self.violations[kind] = {
                "kind": kind,
                "tick": int(ticks[worst]),
                "value": _json(chosen[worst]),
                "limit": limit,
                "count": int(bad.sum()),
                "first": int(ticks[k[0]]),
            }


def _json(value):
    return float(value) if np.isfinite(value) else str(value)


def check(trace_file, model_file, profile_file, on="ideal", report=None):
    """{"violations": [...], "numbers": {...}}"""
    trace, robot = Trace(trace_file), Robot(model_file, profile_file)
    found = Findings()
    limit = ON_LIMITS[on]
    profile, m = robot.profile, robot.m
    n, dt = trace.ticks, profile["tick"]["period"]
    t, segment = trace.number["t"], trace.number["segment"]
    phase = np.array(trace.word["phase"])
    q, v, target = robot.configurations(trace.block("qpos_")), robot.velocities(trace.block("qvel_")), trace.block("target_")
    expected = [f"target_{name}" for name in robot.joint_names]
    if [name for name in trace.names if name.startswith("target_")] != expected:
        found.add("target_columns", 0, 0, "the joints in the order of the model")

    # -- the table itself
    numbers = [name for name in trace.number if not (name.startswith("zmp_") and on == "sim")]
    finite = np.isfinite(np.stack([trace.number[name] for name in numbers], axis=1)).all(axis=1)
    found.add("not_finite", np.flatnonzero(~finite), np.zeros((~finite).sum()), 0)
    found.at_most("time", np.abs(t - dt * np.arange(n)), 1e-6)
    unknown = ~np.isin(phase, PHASES)
    found.add("phase_word", np.flatnonzero(unknown), np.zeros(unknown.sum()), 0)
    if not finite.all() or unknown.any():
        return _summary(found, trace, on)  # nothing else can be worked out
    fallen = phase == "fallen"
    if fallen.any():
        found.add("fall", np.flatnonzero(fallen), t[fallen], 0)
    up = ~fallen

    springs = Springs(robot, n) if on == "sim" else None
    motion = Motion(robot, q, v, dt, springs)
    contact = np.stack([trace.number[f"contact_{s}"] for s in SIDES], axis=1) > 0.5
    touch = np.stack([trace.number[f"touch_{s}"] for s in SIDES], axis=1) > 0.5
    load = np.stack([trace.number[f"force_{s}"] for s in SIDES], axis=1)
    hold, double = phase == "hold", contact.all(axis=1)

    # -- what is planned fits together
    word = np.where(double, "double", np.where(contact[:, 0], "single_left", "single_right"))
    wrong = (phase != word) & up & ~hold
    found.add("phase_contact", np.flatnonzero(wrong), np.zeros(wrong.sum()), 0)
    found.add("no_contact", np.flatnonzero(~contact.any(axis=1) & up), np.zeros(n), 0)
    wrong = (hold != (segment < 0)) & up
    found.add("segment_hold", np.flatnonzero(wrong), segment[wrong], -1)
    running = segment[segment >= 0]
    steps = np.diff(running)
    wrong = ~np.isin(steps, (0, 1))
    found.add("segment_order", np.flatnonzero(segment >= 0)[1:][wrong], steps[wrong], 1)
    # A sole rises from double support and comes down to it: within a tick not both soles change.
    wrong = (contact[1:] != contact[:-1]).all(axis=1)
    found.add("both_soles_change", np.flatnonzero(wrong) + 1, np.zeros(wrong.sum()), 0)
    wrong = (contact[1:] != contact[:-1]).any(axis=1) & hold[1:] & hold[:-1]
    found.add("hold_contact", np.flatnonzero(wrong) + 1, np.zeros(wrong.sum()), 0)

    # -- joints
    angle, speed = q[:, robot.qadr], v[:, robot.dadr]
    room = np.minimum(angle - robot.range[:, 0], robot.range[:, 1] - angle)
    found.at_least("joint_range", room.min(axis=1), -limit["range"])
    share = np.abs(speed) / robot.no_load
    found.at_most("joint_speed", share.max(axis=1), profile["margin"]["speed"] * limit["speed"] + 1e-6)
    stepwise = np.diff(angle, axis=0) / dt
    found.at_most("joint_step", np.r_[0, (np.abs(stepwise) / robot.no_load).max(axis=1)], profile["margin"]["speed"] * limit["speed"] + 1e-6)
    target_room = np.minimum(target - robot.range[:, 0], robot.range[:, 1] - target)
    found.at_least("target_range", target_room.min(axis=1), -1e-9, up)
    norm = np.abs(np.linalg.norm(q[:, robot.free + 3 : robot.free + 7], axis=1) - 1)
    found.at_most("quaternion", norm, 1e-6)

    # -- positions and speeds belong together, and the COM is where the trace says: that of the profile's model
    com = trace.block("com_")[:, :3]
    nominal = robot if on == "ideal" else Robot(pathlib.Path(profile_file).parent / profile["model"], profile_file)
    own = motion if on == "ideal" else Posture(nominal, nominal.configurations(trace.block("qpos_")))
    found.at_most("com_column", np.linalg.norm(com - own.com, axis=1), 1e-6)
    if on == "ideal":
        found.at_most("consistency", np.r_[0, np.abs(stepwise - (speed[1:] + speed[:-1]) / 2).max(axis=1)], limit["consistency"])
        root = np.diff(q[:, robot.free : robot.free + 3], axis=0) / dt
        mean = (v[1:, :3] + v[:-1, :3]) / 2
        found.at_most("root_consistency", np.r_[0, np.abs(root - mean).max(axis=1)], 0.05 * _length(profile))
        found.at_most("target_followed", np.r_[0, np.abs(angle[1:] - target[:-1]).max(axis=1)], 1e-8)
        found.at_most("momentum_consistency", np.abs(motion.total_force - motion.other_force).max(axis=1) / robot.mass, 4.0)

    # -- forces: nothing pulls, nothing slips, nothing tips
    points, valid, height = support(motion.corners, motion.com, contact)
    inside = np.zeros(n, bool)
    inside[1:-1] = True
    inside &= up
    true_zmp = zmp(motion.total_force, motion.total_moment, height)
    if on == "ideal":
        found.at_least("normal_force", motion.total_force[:, 2] / (robot.mass * 9.80665), 0.1, inside)
        margin = hull_margin(points, valid, true_zmp)
        found.at_least("zmp_inside", margin, 0.0, inside)
        found.at_least("zmp_verified", margin, 0.9 * profile["margin"]["zmp_verify"], inside)
        other = hull_margin(points, valid, zmp(motion.other_force, motion.other_moment, height))
        found.at_least("zmp_from_speeds", other, 0.0, inside)
        # Where phases meet, the ZMP should suit the soles of both.
        meet = contact.copy()
        meet[1:] &= contact[:-1]
        meet[:-1] &= contact[1:]
        strict = hull_margin(points, np.repeat(meet, 4, axis=1), true_zmp)
        found.numbers["zmp_where_phases_meet"] = _json(strict[inside & meet.any(axis=1)].min())
        slide = np.hypot(motion.total_force[:, 0], motion.total_force[:, 1]) / np.maximum(motion.total_force[:, 2], 1e-9)
        found.at_most("friction", slide, profile["margin"]["friction"] + 0.02, inside)
        planned = np.stack([trace.number["zmp_plan_x"], trace.number["zmp_plan_y"]], axis=1)
        # At rest and where motions meet the ZMP may jump; at the very tick of the jump its place is a matter of taste.
        smooth = inside.copy()
        smooth[1:] &= segment[1:] == segment[:-1]
        found.at_most("zmp_plan_column", np.linalg.norm(planned - true_zmp, axis=1), limit["zmp"] * _length(profile), smooth)
        said = np.stack([trace.number["zmp_x"], trace.number["zmp_y"]], axis=1)
        found.numbers["zmp_measured_column"] = _json(np.linalg.norm(said - true_zmp, axis=1)[inside].max())
        found.numbers["force_column"] = _json((np.abs(load.sum(axis=1) - motion.total_force[:, 2]) / (robot.mass * 9.80665))[inside].max())
        _check_torque(found, robot, motion, contact, speed, q, dt, inside)

    plan = trace.block("com_plan_")
    if on == "ideal":
        found.at_most("com_plan_column", np.linalg.norm(plan - motion.com, axis=1), limit["com"] * _length(profile), up)
    else:
        planned = np.r_[target[:1], target[:-1]]  # a target belongs to the next tick
        _check_physics(found, robot, nominal, trace, motion, springs.vertical(), planned, contact, load, height, segment, fallen, dt)

    # -- soles
    ground = Ground(robot)
    _check_soles(found, robot, ground, motion, contact, hold, segment, limit, up, _length(profile))
    least = profile["margin"]["self_collision"]
    found.at_least("self_collision", motion.self_distance, least - limit["self"] * _length(profile), up)
    worst = int(np.argmin(motion.self_distance))
    found.numbers["self_collision_pair"] = " and ".join(m.geom(g).name for g in robot.pairs[motion.self_pair[worst]])
    found.numbers["world_distance"] = _json(motion.world_distance.min())

    # -- posture
    lean = np.arccos(np.clip(motion.trunk[:, 2, 2], -1, 1))
    found.at_most("trunk_inclination", lean, profile["region"]["trunk_inclination"] + limit["tilt"], up)
    mean_height = np.where(contact, motion.corners[..., 2].mean(axis=2), 0).sum(axis=1) / np.maximum(contact.sum(axis=1), 1)
    above = motion.com[:, 2] - mean_height
    lo, hi = profile["region"]["com_height"]
    found.numbers["com_height"] = [_json(above[up].min()), _json(above[up].max())]
    slack = (2e-3 if on == "ideal" else 0.02) * _length(profile)
    found.at_least("com_height_low", above, lo - slack, up & hold)
    found.at_most("com_height_high", above, hi + slack, up & hold)

    # -- at rest
    settled = hold & up
    if on == "ideal":
        still = np.abs(v).max(axis=1)
        settled[1:] &= hold[:-1]
        found.at_most("rest_speed", still, limit["rest"], settled)
        found.at_most("rest_step", np.r_[0, np.abs(np.diff(q, axis=0)).max(axis=1)], 1e-8, settled)
        found.add("touch_contact", np.flatnonzero((touch != contact).any(axis=1) & up), np.zeros(n), 0)
    else:
        quiet = settled & (_since(hold) > int(0.5 / dt))
        found.at_most("rest_speed", np.abs(speed).max(axis=1), limit["rest"], quiet)
        found.numbers["standing_sole_touches"] = _json((touch & contact)[up].sum() / max(contact[up].sum(), 1))
        found.at_least("touches", np.array([(touch & contact)[up].sum() / max(contact[up].sum(), 1)]), 0.8)
        found.numbers["swing_sole_touches"] = _json((touch & ~contact)[up].sum() / max((~contact)[up].sum(), 1))
        found.numbers["force_mean"] = _json(load.sum(axis=1)[up].mean() / (robot.mass * 9.80665))
        found.numbers["tilt_deg"] = _json(np.degrees(lean.max()))
    if report is not None:
        _check_report(found, report, com, t, dt, fallen)
        # The least distance of the measured ZMP from the edge of what is touched.
        said = np.stack([trace.number["zmp_x"], trace.number["zmp_y"]], axis=1)
        stands = touch.any(axis=1) & np.isfinite(said).all(axis=1)
        least = hull_margin(*support(motion.corners[stands], motion.com[stands], touch[stands])[:2], said[stands]).min()
        found.numbers["zmp_measured_inside"] = _json(least)
        found.at_most("report_zmp_margin", np.array([abs(report["zmp_margin_m"]["measured_min"] - least)]), limit["report_zmp"] if ground.level[2, 2] > 1 - 1e-9 else 0.01)
    return _summary(found, trace, on)


def moving_mean(x, ticks):
    """Mean of each value and those before it, `ticks` in all (fewer at the beginning)."""
    total = np.cumsum(x, axis=0)
    total[ticks:] -= total[:-ticks].copy()
    count = np.minimum(np.arange(1, len(x) + 1), ticks)
    return total / count.reshape(-1, *[1] * (x.ndim - 1))


def sustained(error, ticks):
    """Least of each value and those before it, `ticks` in all; 0 where there are fewer."""
    if len(error) < ticks:
        return np.zeros(len(error))
    least = np.lib.stride_tricks.sliding_window_view(error, ticks).min(axis=1)
    return np.r_[np.zeros(ticks - 1), least]


def _check_physics(found, robot, nominal, trace, motion, springs, planned, contact, load, height, segment, fallen, dt):
    number, n = trace.number, trace.ticks
    said = np.stack([number["zmp_x"], number["zmp_y"]], axis=1)
    angle, speed = motion.q[:, robot.qadr], motion.v[:, robot.dadr]
    standing = np.arange(n) < (np.argmax(fallen) if fallen.any() else n) - round(FALL / dt) * fallen.any()
    judge = Measured(found, standing, _length(robot.profile), dt)
    window, up = judge.window, judge.up
    if not up.any():
        return
    _check_forces(judge, robot, motion, load, said, springs, height)
    _check_plan(judge, nominal, trace, motion, planned, contact, said, segment)
    off = angle - planned
    judge.lasting("joint", np.abs(off).max(axis=1))
    judge.whole("joint_rms", np.sqrt((off[up] ** 2).mean()))
    change = np.zeros_like(angle)
    change[window:] = (angle[window:] - angle[:-window]) / (window * dt)
    judge.lasting("consistency", np.abs(change - moving_mean(speed, window)).max(axis=1), np.arange(n) >= window)
    moves = np.abs(speed).max(axis=1) > 0.05
    points = [(number[f"{point}_{axis}"], number[f"{point}_plan_{axis}"]) for point, axes in (("com", "xyz"), ("zmp", "xy")) for axis in axes]
    pairs = {
        "copied": [*points, *zip(angle.T, planned.T)],
        "frozen": [(x, np.r_[np.nan, x[:-1]]) for x, _ in points],
    }
    for kind, columns in pairs.items():
        longest = max(_since((a == b) & moves & up).max() for a, b in columns)
        found.at_most(kind, np.array([float(longest)]), COPIED)
    # A touch is a hundredth of the weight that the profile's model has.
    touch = np.stack([number[f"touch_{side}"] for side in SIDES], axis=1) > 0.5
    threshold = -0.01 * nominal.mass * robot.m.opt.gravity[2]
    wrong = ((touch != (load > threshold)) & (np.abs(load - threshold) > 1e-6 * threshold)).any(axis=1) & up
    found.add("touch_force", np.flatnonzero(wrong), load.min(axis=1)[wrong], threshold)


class Measured:
    """What the checks in physics share: a tube by name, and which ticks count."""

    def __init__(self, found, up, size, dt):
        self.found, self.up, self.size, self.dt = found, up, size, dt
        self.window = round(WINDOW / dt)

    def limit(self, kind):
        is_length = not kind.startswith(("newton_force", "newton_mean", "load", "joint", "consistency")) and kind != "lag"
        return TUBES[kind] * (self.size if is_length else 1)

    def lasting(self, kind, error, where=True, patience=PATIENCE):
        self.found.at_most(kind, sustained(np.where(self.up & where, error, 0), round(patience / self.dt)), self.limit(kind))

    def each(self, kind, error, where=True):
        self.found.at_most(kind, np.where(self.up & where, error, 0), self.limit(kind))

    def whole(self, kind, value):
        self.found.at_most(kind, np.array([value]), self.limit(kind))


def _check_forces(judge, robot, motion, load, said, springs, height):
    """Measured forces and ZMP against the rates of momentum, and each foot's share against the springs of its contacts."""
    n, window = len(load), judge.window
    weight = -robot.mass * robot.m.opt.gravity[2]
    total = load.sum(axis=1)
    loaded = total > 0.05 * weight
    judge.found.add("not_finite", np.flatnonzero(~np.isfinite(said).all(axis=1) & loaded & judge.up), np.zeros(n), 0)
    # Contacts and weight have changed the momentum, here about the world's origin, by their impulse.
    momentum = motion.subtree_momentum.copy()
    momentum[:, 3:] += np.cross(motion.com, momentum[:, :3])
    rate = np.zeros((n, 6))
    rate[window:] = (momentum[window:] - momentum[:-window]) / (window * judge.dt)
    force = rate[:, :3] + [0, 0, weight]
    moment = rate[:, 3:] + moving_mean(np.cross(motion.com, [0, 0, weight]), window)
    known = judge.up & (np.arange(n) >= window)
    measured = moving_mean(total, window)
    excess = (measured - force[:, 2]) / weight
    judge.lasting("newton_force", np.abs(excess), known)
    judge.whole("newton_mean", abs(excess[known].mean()) if known.any() else 0.0)
    centre = moving_mean(np.where(loaded[:, None], total[:, None] * said, 0), window) / np.maximum(measured, 0.05 * weight)[:, None]
    true = zmp(force, moment, moving_mean(height, window))
    judge.lasting("newton_zmp", np.linalg.norm(np.nan_to_num(centre - true), axis=1), known & (measured > 0.1 * weight))
    # Measured later or earlier than it was: then the two agree twice as well when one of them is moved.
    lags = np.arange(-LONGEST_LAG, LONGEST_LAG + 1)
    miss = np.empty((len(lags), n))
    for i, lag in enumerate(lags):
        moved = true[np.clip(np.arange(n) - lag, 0, n - 1)]
        miss[i] = moving_mean(np.where(known, (np.nan_to_num(centre - moved) ** 2).sum(axis=1), 0), round(1 / judge.dt))
    now = miss[LONGEST_LAG]
    shifted = (now > judge.limit("lag_least") ** 2) & (now > 4 * miss.min(axis=0))
    judge.lasting("lag", np.where(shifted, np.abs(lags[miss.argmin(axis=0)]) * judge.dt, 0), patience=LAG_PATIENCE)
    share = []
    for each in (load, springs):
        mean = moving_mean(each, window)
        share.append(mean / np.maximum(mean.sum(axis=1), 0.05 * weight)[:, None])
    # Not what lasts: a forged share that changes sides has no error in between.
    off = np.where(judge.up, np.abs(share[0] - share[1]).max(axis=1), 0)
    ticks = min(round(SPLIT_WINDOW / judge.dt), n)
    middle = np.median(np.lib.stride_tricks.sliding_window_view(off, ticks), axis=1)
    judge.each("load_split", np.r_[np.zeros(ticks - 1), middle])


def _check_plan(judge, robot, trace, motion, planned, contact, said, segment):
    """Planned columns against one another, and measured against planned.

    robot: the one of the profile, not the simulated one, which may deviate from it. Its planned joints give COM and ZMP
    relative to each standing sole, which is level and turned as the true one; with the planned COM they say where the plan
    has that sole."""
    n, up, window = len(contact), judge.up, judge.window
    root = np.tile([0.0, 0, 0, 1, 0, 0, 0], (n, 1))
    plan = Posture(robot, robot.configurations(np.c_[root, planned]))
    com_plan, com = trace.block("com_plan_"), trace.block("com_")[:, :3]
    zmp_plan = trace.block("zmp_plan_")
    # Ticks whose planned joints, and those of the ticks before and after, are of one motion; a target belongs to the next tick.
    same = np.r_[False, segment[1:] == segment[:-1]]
    within = same & np.r_[False, same[:-1]]
    around = within & np.r_[False, within[:-1]] & np.r_[same[1:], False]
    step, off_zmp, place = np.zeros(n), np.zeros(n), np.zeros(n)
    com_error, zmp_error = np.zeros((n, 3)), np.zeros((n, 2))
    for side in range(2):
        # In the frame of this sole.
        R = np.swapaxes(plan.sole_turn[:, side], -1, -2)
        local = lambda x: np.einsum("nij,n...j->n...i", R, x - (plan.sole[:, side] if x.ndim == 2 else plan.sole[:, side, None]))
        centre, other = local(plan.com), local(plan.sole[:, 1 - side])
        lower = np.where(contact[:, 1 - side], np.minimum(other[:, 2], 0), 0)
        force, moment = link_wrenches(robot, local(plan.place), R[:, None] @ plan.turn, judge.dt)
        point = zmp(force.sum(axis=1), moment.sum(axis=1), lower)
        # In the world.
        yaw = np.arctan2(motion.sole_turn[:, side, 1, 0], motion.sole_turn[:, side, 0, 0])
        ahead = np.stack([np.cos(yaw), -np.sin(yaw), np.sin(yaw), np.cos(yaw)], axis=1).reshape(n, 2, 2)
        turned = lambda x: np.einsum("nij,nj->ni", ahead, x)
        arm = np.c_[turned(centre[:, :2]), centre[:, 2]]
        sole = com_plan - arm
        drift = sole - motion.sole[:, side]
        stands = contact[:, side] & up
        stays = stands & np.r_[False, stands[:-1]] & (np.arange(n) > 1)
        step = np.maximum(step, np.where(stays, np.r_[0, np.linalg.norm(np.diff(sole, axis=0), axis=1)], 0))
        off = np.linalg.norm(turned(point - centre[:, :2]) - (zmp_plan - com_plan[:, :2]), axis=1)
        off_zmp = np.where(stays & np.r_[stays[1:], False] & around, np.maximum(off_zmp, off), off_zmp)
        place = np.where(stands, np.maximum(place, np.linalg.norm(drift, axis=1)), place)
        chosen = stands & ((side == 0) | ~contact[:, 0])
        com_error[chosen] = (com - motion.sole[:, side] - arm)[chosen]
        zmp_error[chosen] = (said - zmp_plan + drift[:, :2])[chosen]
    judge.each("plan_step", step, within)
    judge.each("plan_step_between", step)
    judge.each("plan_zmp", off_zmp)
    early = np.arange(n) * judge.dt < BEGINNING
    judge.each("place_begin", place, early)
    way = np.r_[0, np.cumsum(np.linalg.norm(np.diff(motion.sole.mean(axis=1)[:, :2], axis=0), axis=1))]
    judge.each("place", np.maximum(place - TUBES["place_share"] * way, 0))
    low = moving_mean(np.nan_to_num(zmp_error), window)
    for kind, error in (("com", com_error), ("zmp", low)):
        error = np.linalg.norm(error, axis=1)
        judge.lasting(kind, error)
        judge.whole(f"{kind}_rms", np.sqrt((error[up] ** 2).mean()) if up.any() else 0.0)


def _length(profile):
    """Size of the robot against the one that the tolerances are written for."""
    return profile["stance"]["com_height"] / 0.26


def _since(flag):
    """For how many ticks a flag has been up."""
    index = np.arange(len(flag))
    last = np.maximum.accumulate(np.where(~flag, index, -1))
    return index - last


def _check_torque(found, robot, motion, contact, speed, q, dt, inside):
    """Motor torques where they are determined: in single support one sole carries all."""
    acceleration = np.zeros_like(speed)
    angle = q[:, robot.qadr]
    acceleration[1:-1] = (angle[2:] - 2 * angle[1:-1] + angle[:-2]) / dt**2
    single = contact.sum(axis=1) == 1
    subtree = robot.subtree.astype(float)
    force = np.einsum("jb,nbk->njk", subtree, motion.force)
    moment = np.einsum("jb,nbk->njk", subtree, motion.moment)
    for side in range(2):
        place = list(robot.bodies).index(robot.foot_body[side])
        carries = robot.subtree[:, place]
        alone = single & contact[:, side]
        force[:, carries] -= np.where(alone[:, None], motion.total_force, 0)[:, None]
        moment[:, carries] -= np.where(alone[:, None], motion.total_moment, 0)[:, None]
    anchor, axis = motion.anchor[:, robot.hinges], motion.axis[:, robot.hinges]
    rigid = np.einsum("njk,njk->nj", axis, moment - np.cross(anchor, force)) + robot.armature * acceleration
    motor = rigid + robot.damping * speed
    # Arms carry nothing but themselves: their torques are known in double support too.
    legs = robot.subtree[:, [list(robot.bodies).index(b) for b in robot.foot_body]].any(axis=1)
    known = (single[:, None] | ~legs[None]) & inside[:, None]
    found.at_most("motor_torque", np.where(known, np.abs(motor) / robot.stall, 0).max(axis=1), 1.0)
    way_back = (np.abs(rigid) + robot.damping * np.abs(speed)) / robot.stall
    found.at_most("motor_load", np.where(known, way_back, 0).max(axis=1), robot.profile["margin"]["torque"] + 0.02)


def _check_soles(found, robot, ground, motion, contact, hold, segment, limit, up, size):
    n = len(contact)
    corners = motion.corners @ ground.level.T
    slip, off, swing, lifted = np.zeros(n), np.zeros(n), np.full(n, np.inf), np.zeros(n)
    for side in range(2):
        stands = contact[:, side]
        begins = stands & np.r_[True, ~stands[:-1]]
        start = np.maximum.accumulate(np.where(begins, np.arange(n), 0))
        moved = np.linalg.norm(corners[:, side] - corners[start, side], axis=2).max(axis=1)
        slip = np.maximum(slip, np.where(stands, moved, 0))
        outline = corners[:, side, :, :2]
        highest, lowest = ground.heights(outline)
        z = corners[:, side, :, 2]
        off = np.maximum(off, np.where(stands, np.maximum(np.abs(z - highest[:, None]), np.abs(z - lowest[:, None])).max(axis=1), 0))
        swing = np.where(~stands, np.minimum(swing, z.min(axis=1) - highest), swing)
        lifted = np.where(~stands, np.maximum(lifted, z.min(axis=1) - highest), lifted)
    found.at_most("sole_slip", slip, limit["slip"] * size, up)
    found.at_most("sole_off_ground", off, limit["ground"] * size, up)
    found.at_least("swing_above_ground", swing, -limit["swing"] * size, up & ~contact.all(axis=1))
    gap = polygon_gap(corners[:, 0, :, :2], corners[:, 1, :, :2])
    found.at_least("sole_gap", gap, robot.profile["region"]["sole_gap"] - limit["gap"] * size, up)
    # A sole that stays up between two motions is nobody's surprise; one that never rises is.
    apex = []
    for s in np.unique(segment[segment >= 0]):
        part = segment == s
        if (~contact[part]).any() and up[part].all():
            apex.append(lifted[part].max())
    found.numbers["least_apex"] = _json(min(apex)) if apex else None
    # Footholds in their region, when both soles rest.
    region = robot.profile["region"]
    rest = hold & contact.all(axis=1) & up
    site = np.stack([corners[:, side].mean(axis=1) for side in range(2)], axis=1)
    ahead = [corners[:, side, 0] - corners[:, side, 1] for side in range(2)]
    yaw = [np.arctan2(a[:, 1], a[:, 0]) for a in ahead]
    between = np.abs((yaw[1] - yaw[0] + np.pi) % (2 * np.pi) - np.pi)
    found.at_most("foot_yaw", between, region["foot_yaw"] + limit["yaw"], rest)
    # The box's centre is the profile's sole centre plus a constant; distances between the soles are what counts.
    delta = site[:, 0] - site[:, 1]
    found.at_most("feet_apart", np.hypot(delta[:, 0], delta[:, 1]), np.hypot(region["foot_x"][1], region["foot_lateral"][1]) + 0.01 * size, rest)


def _check_report(found, report, com, t, dt, fallen):
    found.at_most("report_duration", np.array([abs(report["duration_s"] - (t[-1] + dt))]), 1e-6)
    if bool(report["falls"]) != bool(fallen.any()):
        found.add("report_falls", len(t) - 1, report["falls"], int(fallen.any()))
    found.at_most("report_com", np.array([np.linalg.norm(np.array(report["final"]["com"]) - com[-1])]), 1e-6)
    given, moved = report["commands"]["given"], report["commands"]["moved"]
    if not 0 <= moved <= given:
        found.add("report_commands", 0, moved, given)


def count_commands(trace_file, model_file, profile_file, script):
    """{"given", "moved"}: script is [(t, guide, axes, lift)]. A command is a maximal interval of constant input that asks
    for something its part can do; it moved if what it guides came at least a quarter of the way asked for, or 5 mm of it,
    between the beginning of its first segment and the end of its last one, which takes `LEAST_DURATION` if it is let."""
    trace, robot = Trace(trace_file), Robot(model_file, profile_file)
    profile, m = robot.profile, robot.m
    dt, segment = profile["tick"]["period"], trace.number["segment"]
    q, data = robot.configurations(trace.block("qpos_")), mujoco.MjData(m)
    site = {p: robot.site(profile["parts"][p]) for p in ("left_foot", "right_foot", "left_hand", "right_hand")}

    def look(tick, part):
        data.qpos[:] = q[min(tick, trace.ticks - 1)]
        mujoco.mj_kinematics(m, data)
        mujoco.mj_comPos(m, data)
        ahead = sum(data.site_xmat[s].reshape(3, 3)[:2, 0] for s in robot.sole_site)
        if part == "trunk":
            return data.subtree_com[robot.root].copy(), data.xmat[robot.trunk].reshape(3, 3).copy(), ahead
        return data.site_xpos[site[part]].copy(), data.site_xmat[site[part]].reshape(3, 3).copy(), ahead

    clean = lambda values, lowest: [0.0 if x is None else min(1.0, max(lowest, x)) for x in values]
    inputs = [(t, guide, clean(axes, -1.0), clean(lift, 0.0)) for t, guide, axes, lift in script]
    kept = [c for i, c in enumerate(inputs) if i == 0 or c[1:] != inputs[i - 1][1:]]
    edges = [int(np.ceil(c[0] / dt - 1e-6)) for c in kept] + [trace.ticks]
    begins = np.flatnonzero((segment >= 0) & (segment != np.r_[-1, segment[:-1]]))
    late = profile["tick"]["lookahead"]
    given = moved = 0
    for (_, guide, axes, lift), first, last in zip(kept, edges, edges[1:]):
        foot = {"left_foot": 0, "right_foot": 1}.get(guide)
        throttle = 0.0 if foot is None or lift[foot] < LEAST_LIFT else lift[foot]
        way, turn = np.array(axes[:3]), np.array(axes[3:]) * profile["reach"]["rotation"]
        way *= profile["reach"]["trunk" if guide == "trunk" else guide.split("_")[1]]
        if foot is not None:
            way[2], turn[:2] = throttle * profile["swing"]["lift"], 0
        elif guide != "trunk" and not robot.hand_has_attitude(guide):
            turn[:] = 0
        wanted, wanted_turn = np.linalg.norm(way), np.linalg.norm(turn)
        if first >= last or not (wanted or wanted_turn):
            continue
        given += 1
        own = begins[(begins >= first + late) & (begins < last + late)]
        if len(own) == 0:
            continue
        ends = np.flatnonzero(segment != segment[own[-1]])
        ends = ends[ends > own[-1]]
        end = max(ends[0] if len(ends) else trace.ticks, own[-1] + round(LEAST_DURATION / dt))
        p, R, ahead = look(own[0], guide)
        yaw = np.arctan2(ahead[1], ahead[0])
        heading = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
        made = made_turn = 0.0
        for tick in range(own[0], min(end, trace.ticks) + 1):
            p1, R1, _ = look(tick, guide)
            made = max(made, heading @ way @ (p1 - p) / wanted if wanted else 0.0)
            made_turn = max(made_turn, heading @ turn @ rotation_vector(R1 @ R.T) / wanted_turn if wanted_turn else 0.0)
        moved += bool(wanted and made >= min(wanted / 4, 5e-3)) or bool(wanted_turn and made_turn >= wanted_turn / 4)
    return {"given": given, "moved": moved}


def _summary(found, trace, on):
    segments = trace.number["segment"]
    segments = segments[np.isfinite(segments)]
    return {
        "on": on,
        "ticks": trace.ticks,
        "segments": int(segments.max()) + 1 if len(segments) else 0,
        "violations": list(found.violations.values()),
        "numbers": found.numbers,
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trace")
    parser.add_argument("--model", required=True)
    parser.add_argument("--profile", required=True)
    parser.add_argument("--on", choices=tuple(ON_LIMITS), default="ideal")
    parser.add_argument("--report")
    parser.add_argument("--script")
    a = parser.parse_args()
    try:
        report = json.loads(pathlib.Path(a.report).read_text()) if a.report else None
        summary = check(a.trace, a.model, a.profile, a.on, report)
        if a.script:
            rows = [json.loads(line) for line in pathlib.Path(a.script).read_text().splitlines()]
            script = [(r["t"], r["guide"], r["axes"], r["lift"]) for r in rows]
            summary["commands"] = count_commands(a.trace, a.model, a.profile, script)
    except (OSError, ValueError, KeyError) as error:
        print(f"check_trace: {error}", file=sys.stderr)
        return 2
    print(json.dumps(summary, indent=1))
    return 1 if summary["violations"] else 0


if __name__ == "__main__":
    sys.exit(main())
