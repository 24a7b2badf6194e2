"""mighty's model and profile against the published facts, the worlds' measures, and the scaled biped's similarity.

Tolerances: 1 mm, 0.1 %. The facts are those of mi-lib/roki, example/model/mighty.ztk (MIT, (c) 2024 T. Sugihara).
"""

import itertools
import pathlib
import re
import subprocess
import sys
import tomllib

import mujoco
import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
MIGHTY = ROOT / "robots" / "mighty"
TUNED = ROOT / "tests" / "robots" / "tuned"  # its profile with all keys
SCALE = 1.7

MM = 1e-3
PERMILLE = 1e-3
DEG = np.pi / 180
SIDES = {"left": 1, "right": -1}

# motor: stall torque [N m], no-load speed [rad/s], reflected inertia [kg m2], equivalent damping [N m s/rad]
MOTORS = {
    "RE-max17": (1.31, 11.06, 0.00469, 0.119),
    "RE-max21": (2.79, 9.49, 0.00597, 0.294),
    "RE-max21-belt": (3.34, 7.91, 0.01047, 0.423),
    "RE-max24-belt": (6.62, 6.65, 0.01333, 0.996),
}
# Left side; right: y mirrored.
# link: parent, joint origin relative to the parent's [m], axis, limits [deg], mass [kg], COM [m],
#       inertia about the COM xx yy zz xy xz yz [kg m2], motor
LEFT_LINKS = {
    "shoulder_flexion": ("body", (0.03900, 0.07201, 0.08514), (0, -0.70711, -0.70711), (-90, 90), 0.11972440,
        (-0.002545, 0.032857, 0.023915), (9.8280e-05, 5.5110e-05, 8.8940e-05, 5.43e-06, -7.54e-06, -2.901e-05), "RE-max21-belt"),
    "shoulder_abduction": ("shoulder_flexion", (-0.00500, 0.05818, 0.02828), (1, 0, 0), (0, 90), 0.10555682,
        (0.000889, 0.002157, -0.036335), (1.6365e-04, 1.7376e-04, 4.4860e-05, -4.12e-06, -1.489e-05, -5.3e-06), "RE-max21-belt"),
    "elbow_rotation": ("shoulder_abduction", (0.00500, 0, -0.07600), (0, 0, 1), (-90, 90), 0.05282283,
        (-0.000373, -0.000017, -0.032060), (2.7960e-05, 3.0340e-05, 9.79e-06, 0, 5e-08, 4e-08), "RE-max17"),
    "elbow_flexion": ("elbow_rotation", (0, 0, -0.04400), (-1, 0, 0), (0, 90), 0.14803517,
        (-0.005970, 0.002054, -0.033106), (1.4628e-04, 1.6848e-04, 5.1760e-05, -1.5e-06, -1.352e-05, -5.95e-06), "RE-max21-belt"),
    "hip_flexion": ("body", (0.03900, 0.02800, -0.05500), (0, -1, 0), (-30, 90), 0.08925132,
        (-0.005037, 0.024826, 0.000050), (6.5720e-05, 4.2890e-05, 7.37e-05, -7.09e-06, 5.31e-06, -9.17e-06), "RE-max24-belt"),
    "hip_abduction": ("hip_flexion", (-0.01100, 0.04050, 0), (1, 0, 0), (-30, 90), 0.33325766,
        (0.010245, -0.006527, -0.042846), (3.2982e-04, 3.6033e-04, 1.6523e-04, -1.62e-06, 9.44e-06, 7.451e-05), "RE-max24-belt"),
    "knee_rotation": ("hip_abduction", (0.01100, -0.02500, -0.09700), (0, 0, 1), (-90, 90), 0.06166437,
        (-0.000042, 0.006889, -0.036659), (4.3990e-05, 3.4370e-05, 1.7110e-05, -2e-08, -6e-08, -7.22e-06), "RE-max21"),
    "knee_flexion": ("knee_rotation", (0, 0.00500, -0.04400), (0, 1, 0), (0, 100), 0.34825999,
        (-0.003554, -0.002080, -0.046264), (5.5979e-04, 5.0774e-04, 1.9449e-04, -3.81e-06, 5.499e-05, 8.57e-06), "RE-max24-belt"),
    "ankle_flexion": ("knee_flexion", (-0.00500, 0, -0.11300), (0, -1, 0), (-20, 90), 0.07703362,
        (-0.000390, -0.000579, 0.002843), (3.5750e-05, 3.0110e-05, 3.1690e-05, 1.8e-07, 1.4e-07, 5.92e-06), "RE-max24-belt"),
    "ankle_abduction": ("ankle_flexion", (-0.04400, -0.00650, 0), (1, 0, 0), (-90, 20), 0.30739413,
        (0.029852, 0.000006, -0.035014), (2.0824e-04, 5.2020e-04, 5.1501e-04, -9e-08, -1.0098e-04, 4e-08), "RE-max24-belt"),
}  # fmt: skip
# COM z, body z, hip, knee, ankle flexion; feet at +-0.042, COM above the sole centres, arms at home
STANDING = [
    (0.28, 0.3485, 15.4, 41.0, 25.6),
    (0.27, 0.3353, 22.0, 55.2, 33.2),
    (0.26, 0.3220, 27.2, 66.8, 39.6),
    (0.25, 0.3088, 31.6, 76.9, 45.2),
    (0.24, 0.2956, 35.5, 86.0, 50.5),
]
SOLE = ((-0.0426, -0.036, 0.0), (0.0564, 0.036, 0.0092))  # box in the foot frame
ARM_HOME = {"shoulder_flexion": -20, "shoulder_abduction": 15, "elbow_rotation": 70, "elbow_flexion": 60}


def near(value, tolerance=MM):
    return pytest.approx(value, abs=tolerance)


def about(value, floor=1e-12):
    return pytest.approx(value, rel=PERMILLE, abs=floor)


def links():
    for (side, sign), (link, facts) in itertools.product(SIDES.items(), LEFT_LINKS.items()):
        parent, origin, axis, limits, mass, com, inertia, motor = facts
        # Mirrored in y: vectors (x, -y, z), rotation axes (-x, y, -z), products of inertia xy and yz.
        vector = np.array([1, sign, 1])
        yield (side + "_" + link, parent if parent == "body" else side + "_" + parent, vector * origin,
               np.array([sign, 1, sign]) * axis, limits, mass, vector * com,
               np.array([1, 1, 1, sign, 1, sign]) * inertia, motor)  # fmt: skip


LINKS = list(links())
link_cases = pytest.mark.parametrize("link", LINKS, ids=[link[0] for link in LINKS])


@pytest.fixture(scope="module")
def model():
    return mujoco.MjModel.from_xml_path(str(MIGHTY / "mighty.xml"))


@pytest.fixture(scope="module")
def profile():
    return tomllib.loads((TUNED / "profile.toml").read_text())


def posed(model, qpos=None, key=None):
    data = mujoco.MjData(model)
    data.qpos[:] = model.key(key).qpos if key else qpos
    mujoco.mj_forward(model, data)
    return data


def com(model, data):
    return data.subtree_com[model.jnt_bodyid[0]]


def qpos_of(model, joints_deg, body=(0, 0, 0)):
    qpos = np.zeros(model.nq)
    qpos[:4] = *body, 1
    for joint, angle in joints_deg.items():
        qpos[model.joint(joint).qposadr[0]] = angle * DEG
    return qpos


def pair_distances(model, data):
    return {model.pair(i).name: mujoco.mj_geomDistance(model, data, model.pair_geom1[i], model.pair_geom2[i], 1.0, None)
            for i in range(model.npair)}  # fmt: skip


# ---------------------------------------------------------------- the model


def test_whole_body(model):
    assert model.nu == 20 and model.njnt == 21 and model.nkey == 2
    assert model.body_mass.sum() == about(5.531)
    assert model.body("body").mass[0] == about(2.2450703)
    for side in SIDES:
        masses = {name: model.body(name).mass[0] for name, *_ in LINKS if name.startswith(side)}
        arm = sum(m for name, m in masses.items() if "shoulder" in name or "elbow" in name)
        assert arm == near(0.426, 5e-4)
        assert sum(masses.values()) - arm == near(1.217, 5e-4)


def test_com_at_zero(model):
    data = posed(model, key="zero")
    assert com(model, data) - data.body("body").xpos == near([0.02962, 0.00031, -0.07384], 1e-5)
    assert com(model, data)[2] == near(0.293)


def test_trunk(model):
    body = model.body("body")
    assert body.ipos == near([0.024687, 0.000755, 0.038351], 1e-7)
    assert inertia(model, body.id) == about(
        np.array([1.1088e-02, 1.0851e-02, 7.1110e-03, 1.5e-07, -7.2768e-04, 4.2e-06]), 1e-8
    )


def inertia(model, body):
    """About the COM, in the body's axes: xx yy zz xy xz yz."""
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, model.body_iquat[body])
    R = R.reshape(3, 3)
    full = R @ np.diag(model.body_inertia[body]) @ R.T
    return np.array([full[0, 0], full[1, 1], full[2, 2], full[0, 1], full[0, 2], full[1, 2]])


@link_cases
def test_link(model, link):
    name, parent, origin, axis, limits, mass, com_link, inertia_link, _ = link
    body, joint = model.body(name), model.joint(name)
    assert model.body(body.parentid[0]).name == parent
    assert body.pos == near(origin, 1e-6)
    assert joint.pos == near(np.zeros(3), 1e-9)
    assert joint.range / DEG == near(np.array(limits), 1e-4)
    assert body.mass[0] == about(mass)
    assert body.ipos == near(com_link, 1e-7)
    assert inertia(model, body.id) == about(inertia_link, 2e-9)
    data = posed(model, key="zero")
    assert data.joint(name).xaxis == near(axis, 1e-4)
    assert data.body(name).xmat == near(np.eye(3).ravel(), 1e-9)


@link_cases
def test_motor(model, link):
    name, motor = link[0], link[-1]
    stall, no_load, armature, damping = MOTORS[motor]
    joint, actuator = model.joint(name), model.actuator(name)
    assert actuator.trnid[0] == joint.id and actuator.gear[0] == 1
    assert actuator.ctrlrange == about(np.array([-stall, stall]))
    assert model.jnt_actfrcrange[joint.id] == about(np.array([-stall, stall]))
    assert joint.armature[0] == about(armature) and joint.damping[0] == about(damping)
    assert joint.frictionloss[0] == 0
    # the torque-speed line ends at the no-load speed
    assert stall / damping == pytest.approx(no_load, rel=0.006)


@pytest.mark.parametrize("side", SIDES)
def test_leg_lengths_and_sole(model, side):
    data = posed(model, key="zero")
    hip, knee, ankle, foot = (
        data.joint(f"{side}_{j}").xanchor for j in ("hip_flexion", "knee_flexion", "ankle_flexion", "ankle_abduction")
    )
    sole = data.site(f"{side}_sole")
    assert [hip[2] - knee[2], knee[2] - ankle[2], foot[2] - sole.xpos[2]] == near([0.141, 0.113, 0.0577])
    assert sole.xpos == near([0.034, SIDES[side] * 0.042, 0], 1e-6)
    assert sole.xmat == near(np.eye(3).ravel(), 1e-9)
    geom = model.geom(f"{side}_sole_col")
    centre = data.geom(geom.id).xpos - sole.xpos
    assert geom.type[0] == mujoco.mjtGeom.mjGEOM_BOX
    assert (centre - geom.size, centre + geom.size) == (near(SOLE[0], 1e-6), near(SOLE[1], 1e-6))
    assert geom.condim[0] == 4 and geom.priority[0] == 1 and geom.friction[0] == 0.8
    assert list(geom.solref) == [0.005, 1] and list(geom.solimp[:3]) == [0.9, 0.99, 0.001]


@pytest.mark.parametrize("side", SIDES)
def test_arm(model, side):
    data = posed(model, key="zero")
    shoulder, hand = data.body(f"{side}_shoulder_abduction").xpos, data.site(f"{side}_hand").xpos
    assert shoulder - data.body("body").xpos == near([0.034, SIDES[side] * 0.1302, 0.1134], 1e-4)
    assert np.linalg.norm(hand - shoulder) == near(0.194)
    home = {f"{side}_{joint}": angle for joint, angle in ARM_HOME.items()}
    data = posed(model, qpos_of(model, home))
    assert data.site(f"{side}_hand").xpos == near([0.045, SIDES[side] * 0.158, -0.052])


@pytest.mark.parametrize("row", STANDING, ids=[f"com_{row[0]}" for row in STANDING])
def test_standing_pose(model, row):
    com_z, body_z, hip, knee, ankle = row
    angles = {"hip_flexion": hip, "knee_flexion": knee, "ankle_flexion": ankle, **ARM_HOME}
    pose = {f"{side}_{joint}": a for side, (joint, a) in itertools.product(SIDES, angles.items())}
    data = posed(model, qpos_of(model, pose, (0, 0, body_z)))
    soles = [data.site(f"{side}_sole") for side in SIDES]
    for sole in soles:
        assert sole.xpos[2] == near(0)
        assert sole.xmat.reshape(3, 3)[:, 2] == near([0, 0, 1], 0.2 * DEG)
    assert com(model, data)[2] == near(com_z)
    centre = np.mean([sole.xpos + [0.0069, 0, 0] for sole in soles], axis=0)
    assert com(model, data)[:2] == near(centre[:2])  # 0.1 deg in the table is 0.5 mm here


def test_stand_key(model, profile):
    data = posed(model, key="stand")
    assert com(model, data) == near([0, 0, 0.26], 1e-6)
    for side, sign in SIDES.items():
        sole = data.site(f"{side}_sole")
        assert sole.xpos + [0.0069, 0, 0] == near([0, sign * profile["stance"]["width"] / 2, 0], 1e-6)
        assert sole.xmat == near(np.eye(3).ravel(), 1e-6)
    for joint, angle in profile["home_deg"].items():
        assert data.joint(joint).qpos[0] / DEG == near(angle, 1e-3)
    assert data.qpos[3:7] == near([1, 0, 0, 0], 1e-9)


# ---------------------------------------------------------------- collision


def test_every_collision_geom_has_a_name_and_meets_only_the_world(model):
    own = [g for g in range(model.ngeom) if model.geom_contype[g] or model.geom_conaffinity[g]]
    assert all(re.fullmatch(r"(left|right)_\w+_col|(trunk|pelvis)_col", model.geom(g).name) for g in own)
    for a, b in itertools.product(own, own):
        assert not model.geom_contype[a] & model.geom_conaffinity[b]
    assert all((1 & model.geom_conaffinity[g]) or (model.geom_contype[g] & 1) for g in own)  # a world geom: 1, 1
    assert all(model.geom_conaffinity[g] & 1 for g in own)


def test_pairs(model):
    pairs = {frozenset((model.geom(a).name, model.geom(b).name)) for a, b in zip(model.pair_geom1, model.pair_geom2)}
    wanted = [("left_thigh", "right_thigh"), ("left_shin", "right_shin"), ("left_sole", "right_sole"),
              ("left_sole", "right_shin"), ("left_shin", "right_sole"), ("left_hand", "right_hand")]  # fmt: skip
    for side in SIDES:
        wanted += [(f"{side}_{part}", "trunk") for part in ("upper_arm", "forearm", "hand")]
        wanted += [(f"{side}_{part}", f"{side}_thigh") for part in ("forearm", "hand")]
        wanted += [(f"{side}_thigh", "pelvis")]
    for a, b in wanted:
        assert frozenset((a + "_col", b + "_col")) in pairs
    for side, other in (("left", "right"), ("right", "left")):  # what one side has, the other has
        mirrored = {frozenset(g.replace(side, "X").replace(other, side).replace("X", other) for g in p) for p in pairs}
        assert mirrored == pairs


@pytest.mark.parametrize("key", ["stand", "zero"])
def test_no_self_contact(model, profile, key):
    data = posed(model, key=key)
    distances = pair_distances(model, data)
    assert min(distances.values()) > 2 * profile["margin"]["self_collision"], distances
    assert data.ncon == 0


@pytest.mark.parametrize("side", SIDES)
def test_no_hip_angle_brings_a_thigh_to_the_trunk(model, profile, side):
    """The pelvis fills the lower part of what is drawn of the trunk, so this holds for the robot, not for a box alone."""
    drawn = [g for g in model.body("body").geomadr + np.arange(model.body("body").geomnum[0])
             if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_BOX and not model.geom_contype[g]]  # fmt: skip
    pelvis = model.geom("pelvis_col")
    lowest = min(drawn, key=lambda g: model.geom_pos[g][2] - model.geom_size[g][2])
    assert (pelvis.pos - pelvis.size <= model.geom_pos[lowest] - model.geom_size[lowest] + 1e-9).all()
    ranges = [np.rad2deg(model.joint(f"{side}_hip_{way}").range) for way in ("flexion", "abduction")]
    pair = f"{side}_thigh__pelvis"
    for flexion, abduction in itertools.product(*(np.linspace(*r, 25) for r in ranges)):
        pose = {f"{side}_hip_flexion": flexion, f"{side}_hip_abduction": abduction}
        distance = pair_distances(model, posed(model, qpos_of(model, pose)))[pair]
        assert distance > profile["margin"]["self_collision"], pose


def test_self_contact_is_seen(model):
    """Legs pulled together, arms folded in: the pairs notice."""
    pose = {"left_hip_abduction": -6, "right_hip_abduction": -6}
    names = contact_names(model, posed(model, qpos_of(model, pose)))
    assert any("sole" in a and "sole" in b for a, b in names)
    pose = {"left_shoulder_flexion": 60, "left_elbow_rotation": 90, "left_elbow_flexion": 90}
    names = contact_names(model, posed(model, qpos_of(model, pose)))
    assert any("trunk_col" in pair for pair in names)


def contact_names(model, data):
    return {tuple(sorted(model.geom(g).name for g in c.geom)) for c in data.contact}


# ---------------------------------------------------------------- the worlds


def composed(world, robot=MIGHTY / "mighty.xml"):
    """The robot in the world, and its qpos in the keyframe moved to the site start."""
    spec, child = (mujoco.MjSpec.from_file(str(path)) for path in (ROOT / "worlds" / f"{world}.xml", robot))
    spec.worldbody.add_frame().attach_body(child.worldbody.first_body(), "robot/", "")
    model = spec.compile()
    alone = mujoco.MjModel.from_xml_path(str(robot))
    qpos = alone.key("stand").qpos.copy()
    qpos[:3] += posed(model, qpos).site("start").xpos
    return model, qpos


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("world", ["flat", "room"])
def test_world_alone(world):
    model = mujoco.MjModel.from_xml_path(str(ROOT / "worlds" / f"{world}.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.site("start").xmat == near(np.eye(3).ravel(), 1e-9)
    assert model.nbody == 1 and model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET
    for g in range(model.ngeom):
        assert (model.geom_contype[g], model.geom_conaffinity[g]) in ((0, 0), (1, 1))
        if model.geom_contype[g]:
            assert model.geom(g).name
    grounds = [model.geom(g).name for g in range(model.ngeom) if model.geom(g).name.startswith("ground")]
    assert grounds == (["ground_floor"] if world == "flat" else ["ground_floor", "ground_stage", "ground_tread"])


def test_room_measures():
    model = mujoco.MjModel.from_xml_path(str(ROOT / "worlds" / "room.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)

    def box(name):
        geom = model.geom(name)
        return geom.pos - geom.size, geom.pos + geom.size

    start, door_b = data.site("start").xpos, data.site("door_B").xpos
    (stage_lo, stage_hi), (tread_lo, tread_hi) = box("ground_stage"), box("ground_tread")
    door_lo, door_hi = box("door")
    assert start == near([0, 0, 0.030], 1e-9)
    assert (stage_lo[2], stage_hi[2], tread_lo[2], tread_hi[2]) == near((0, 0.030, 0, 0.015), 1e-9)
    assert 0.10 <= stage_hi[0] - start[0] <= 0.15
    assert tread_lo[0] == near(stage_hi[0], 1e-9) and tread_hi[0] - tread_lo[0] == near(0.12, 1e-9)
    assert (stage_lo[1], stage_hi[1]) == near((tread_lo[1], tread_hi[1]), 1e-9)
    assert door_b - start == near([0.90, 0.40, 0.33], 1e-9)
    assert door_b[2] == near(0.36, 1e-9)
    # in front of the door, over the panel, with room for the end of the arm
    assert door_lo[0] - door_b[0] == near(0.045, 1e-9)
    assert door_lo[1] < door_b[1] < door_hi[1] and door_lo[2] < door_b[2] < door_hi[2]


@pytest.mark.parametrize("world", ["flat", "room"])
def test_mighty_stands(world, profile):
    """Joint servos and the constant torques of standing, 1 s: it keeps still, on its soles alone."""
    model, start = composed(world)
    data = posed(model, start)
    grounds = {"flat": "ground_floor", "room": "ground_stage"}
    kp, kd = np.zeros(model.nu), np.zeros(model.nu)
    for gains in profile["drive"]["gains"]:
        for joint in gains["joints"]:
            kp[model.actuator("robot/" + joint).id], kd[model.actuator("robot/" + joint).id] = gains["kp"], gains["kd"]
    torque = data.qfrc_bias.copy()
    weight = model.body_mass.sum() * 9.80665
    for side in SIDES:
        sole = model.site(f"robot/{side}_sole")
        jacobian = np.zeros((3, model.nv))
        point = data.site(sole.id).xpos + [0.0069, 0, 0]
        mujoco.mj_jac(model, data, jacobian, None, point, sole.bodyid[0])
        torque -= jacobian.T @ [0, 0, weight / 2]
    assert torque[:6] == near(np.zeros(6), 1e-3)  # the COM is above the middle of the soles

    touched = set()
    for _ in range(1000):
        data.ctrl[:] = kp * (start[7:] - data.qpos[7:]) - kd * data.qvel[6:] + torque[6:]
        mujoco.mj_step(model, data)
        touched |= contact_names(model, data)
    assert touched == {(grounds[world], f"robot/{side}_sole_col") for side in SIDES}
    assert data.qpos[:3] == near(start[:3], 1e-4)
    assert not any(w.number for w in data.warning)


# ---------------------------------------------------------------- the profile


def check_profile(model, profile):
    """Every name resolves, every motor has gains, and the figures are in order."""
    parts = profile["parts"]
    for part in ("trunk", "left_shoulder", "right_shoulder"):
        model.body(parts[part])
    for part in ("left_foot", "right_foot", "left_hand", "right_hand", "imu"):
        model.site(parts[part])
    joints = [model.joint(model.actuator(i).trnid[0]).name for i in range(model.nu)]
    with_gains = [joint for gains in profile["drive"]["gains"] for joint in gains["joints"]]
    assert sorted(with_gains) == sorted(joints)
    for joint, angle in profile["home_deg"].items():
        lo, hi = model.joint(joint).range
        assert lo <= angle * DEG <= hi
    region, margin, phases = profile["region"], profile["margin"], profile["phases"]
    assert region["com_height"][0] <= profile["stance"]["com_height"] <= region["com_height"][1]
    assert region["foot_lateral"][0] <= profile["stance"]["width"] <= region["foot_lateral"][1]
    assert margin["zmp_verify"] < margin["zmp_plan"] < margin["stand_on"]
    for name in ("step", "lift", "lower"):
        assert sum(phases[name]) == pytest.approx(1)
    assert len(phases["weights"]) == len(phases["step"]) + 1


def test_profile(model, profile):
    assert profile["name"] == "mighty" and (TUNED / profile["model"]).resolve() == MIGHTY / "mighty.xml"
    check_profile(model, profile)


# ---------------------------------------------------------------- the scaled biped


@pytest.fixture(scope="module")
def biped(tmp_path_factory):
    out = tmp_path_factory.mktemp("biped")
    script = [sys.executable, ROOT / "scripts" / "scale_robot.py", TUNED, out, "--scale", str(SCALE), "--seed", "1"]
    subprocess.run(list(map(str, script)), check=True)
    return out


@pytest.fixture(scope="module")
def biped_model(biped):
    return mujoco.MjModel.from_xml_path(str(biped / "model.xml"))


@pytest.fixture(scope="module")
def biped_profile(biped):
    return tomllib.loads((biped / "profile.toml").read_text())


@pytest.fixture(scope="module")
def twin(model, profile, biped_model, biped_profile):
    """mighty's joint -> (the biped's joint, its body): walked down from the parts that the profile names."""
    found = {}
    for part in ("left_foot", "right_foot", "left_hand", "right_hand"):
        body = model.site(profile["parts"][part]).bodyid[0]
        other = biped_model.site(biped_profile["parts"][part]).bodyid[0]
        while model.body_dofnum[body] == 1:
            found[int(model.body_jntadr[body])] = int(biped_model.body_jntadr[other])
            body, other = model.body_parentid[body], biped_model.body_parentid[other]
        assert biped_model.body_dofnum[other] == 6
    assert len(found) == model.nu
    return found


def test_biped_profile(biped_model, biped_profile):
    assert biped_profile["name"] == "biped-1.7" and biped_profile["model"] == "model.xml"
    check_profile(biped_model, biped_profile)


def test_biped_profile_is_scaled(profile, biped_profile):
    s = SCALE
    ratio = lambda table, key: biped_profile[table][key] / profile[table][key]
    assert ratio("stance", "com_height") == about(s) and ratio("reach", "foot") == about(s)
    assert ratio("reach", "rotation") == 1 and ratio("margin", "torque") == 1
    assert ratio("tick", "period") == 1
    for key in profile["duration"]:
        tick = profile["tick"]["period"]
        scaled = biped_profile["duration"][key]
        assert scaled == pytest.approx(profile["duration"][key] * s**0.5, abs=tick / 2 + 1e-9)
        assert scaled / tick == near(round(scaled / tick), 1e-6)
    for ours, theirs in zip(profile["drive"]["gains"], biped_profile["drive"]["gains"]):
        assert theirs["kp"] == about(ours["kp"] * s**4) and theirs["kd"] == about(ours["kd"] * s**4.5)


def test_biped_shares_no_name(biped):
    def names(folder, file):
        text = (folder / file).read_text()
        return set(re.findall(r'(?:name|class|joint|geom[12]|material|site|model)="([^"]+)"', text))

    ours, theirs = names(MIGHTY, "mighty.xml"), names(biped, "model.xml")
    assert not ours & theirs
    assert not any(a in b or b in a for a in ours for b in theirs if len(b) > 3 and len(a) > 3)
    text = (biped / "model.xml").read_text() + (biped / "profile.toml").read_text().split("[stance]")[0].split("[home_deg]")[1]
    assert not re.search(r"left|right|shoulder|elbow|hip|knee|ankle|mighty", text)


def test_biped_names_do_not_link_body_joint_and_motor(biped_model):
    kinds = ("body", "joint", "geom", "site", "actuator", "sensor")
    counts = (biped_model.nbody, biped_model.njnt, biped_model.ngeom, biped_model.nsite, biped_model.nu, biped_model.nsensor)
    names = [getattr(biped_model, kind)(i).name for kind, n in zip(kinds, counts) for i in range(n)]
    names = [name for name in names if name]
    assert len(names) == len(set(names))


def test_biped_order_is_another(twin, biped_model):
    hinges = sorted(twin)
    order = [twin[j] for j in hinges]
    assert order != hinges and order != sorted(order)
    motors = [int(biped_model.actuator(i).trnid[0]) for i in range(biped_model.nu)]
    assert motors != sorted(motors)  # motors are not in the order of the joints


def test_biped_is_similar(model, biped_model, twin):
    s = SCALE
    assert biped_model.body_mass.sum() == about(model.body_mass.sum() * s**3)
    assert biped_model.opt.timestep == about(model.opt.timestep * s**0.5)
    assert list(biped_model.opt.gravity) == list(model.opt.gravity)
    motor = {int(biped_model.actuator(i).trnid[0]): i for i in range(biped_model.nu)}
    for ours, theirs in twin.items():
        a, b = model.jnt_bodyid[ours], biped_model.jnt_bodyid[theirs]
        assert biped_model.body_mass[b] == about(model.body_mass[a] * s**3)
        assert biped_model.body_pos[b] == near(model.body_pos[a] * s, 1e-8)
        assert biped_model.body_ipos[b] == near(model.body_ipos[a] * s, 1e-8)
        assert inertia(biped_model, b) == about(inertia(model, a) * s**5, 1e-8)
        assert biped_model.jnt_axis[theirs] == near(model.jnt_axis[ours], 1e-9)
        assert biped_model.jnt_range[theirs] == near(model.jnt_range[ours], 1e-9)
        dof, other = model.jnt_dofadr[ours], biped_model.jnt_dofadr[theirs]
        assert biped_model.dof_armature[other] == about(model.dof_armature[dof] * s**5)
        assert biped_model.dof_damping[other] == about(model.dof_damping[dof] * s**4.5)
        stall = model.actuator(model.joint(ours).name).ctrlrange[1]
        assert biped_model.actuator_ctrlrange[motor[theirs]] == about(np.array([-stall, stall]) * s**4)
        assert biped_model.jnt_actfrcrange[theirs] == about(np.array([-stall, stall]) * s**4)


def test_biped_poses_and_pairs(model, biped_model, twin):
    """Keyframe by keyframe the same pose and the same distances, in the other unit of length."""
    assert biped_model.npair == model.npair and biped_model.nkey == model.nkey
    for k in range(model.nkey):
        ours = posed(model, model.key(k).qpos)
        theirs = posed(biped_model, biped_model.key(k).qpos)
        assert com(biped_model, theirs) == near(com(model, ours) * SCALE, 1e-6)
        for a, b in twin.items():
            assert theirs.xanchor[b] == near(ours.xanchor[a] * SCALE, 1e-6)
        distances = [sorted(pair_distances(m, d).values()) for m, d in ((model, ours), (biped_model, theirs))]
        assert distances[1] == near(np.array(distances[0]) * SCALE, 1e-6)
        assert theirs.ncon == 0


def test_biped_moves_alike(model, biped_model, twin):
    """The same fall, in the other unit of time: 0.2 s limp from the standing pose, above the floor."""
    ours, theirs = posed(model, key="stand"), posed(biped_model, biped_model.key(0).qpos)
    for data, m in ((ours, model), (theirs, biped_model)):
        for _ in range(200):
            mujoco.mj_step(m, data)
    assert theirs.time == about(ours.time * SCALE**0.5)
    assert theirs.qpos[:3] == near(ours.qpos[:3] * SCALE, 1e-5)
    for a, b in twin.items():
        assert theirs.qpos[biped_model.jnt_qposadr[b]] == near(ours.qpos[model.jnt_qposadr[a]], 1e-5)
        speed = ours.qvel[model.jnt_dofadr[a]] * SCALE**-0.5
        assert theirs.qvel[biped_model.jnt_dofadr[b]] == near(speed, 1e-4)


def test_a_short_profile_is_scaled_and_what_it_leaves_out_stays_out(tmp_path):
    script = [sys.executable, ROOT / "scripts" / "scale_robot.py", MIGHTY, tmp_path, "--scale", str(SCALE)]
    subprocess.run([*map(str, script), "--seed", "1"], check=True)
    short = tomllib.loads((MIGHTY / "profile.toml").read_text())
    scaled = tomllib.loads((tmp_path / "profile.toml").read_text())
    assert scaled.keys() == short.keys()
    assert scaled["stance"]["com_height"] == about(SCALE * short["stance"]["com_height"])
    assert scaled["reach"].keys() == {"hand"}


def test_scale_robot_is_reproducible(biped, tmp_path):
    script = [sys.executable, ROOT / "scripts" / "scale_robot.py", TUNED, tmp_path, "--scale", str(SCALE)]
    subprocess.run([*map(str, script), "--seed", "1"], check=True)
    for file in ("model.xml", "profile.toml"):
        assert (tmp_path / file).read_text() == (biped / file).read_text()
    subprocess.run([*map(str, script), "--seed", "2"], check=True)
    assert (tmp_path / "model.xml").read_text() != (biped / "model.xml").read_text()
