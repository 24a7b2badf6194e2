#!/usr/bin/env python3
"""Make a second biped out of a robot: another size, the same dynamics, and not one name or order in common.

    python3 scripts/scale_robot.py robots/mighty OUTDIR --scale 1.7 --seed 1

reads profile.toml and the model it names, and writes OUTDIR/profile.toml and OUTDIR/model.xml. The second robot shows
that the program takes everything about a robot from its profile and model:

- dynamically similar (the same motion, under the same gravity, in another unit of length): lengths grow by s, times by
  sqrt(s), masses by s^3, hence inertia s^5, torque and kp s^4, joint damping and kd s^4.5, speeds of joints s^-0.5;
- every name is another, and body, joint and motor of one link no longer share it;
- right and left, arms and legs, motors and sensors come in another order.

The control period stays: it belongs to the computer, not to the robot. Durations are whole control periods.
Standard library only.
"""

import argparse
import math
import pathlib
import random
import tomllib
import xml.etree.ElementTree as ET

# Powers of the scale.
LENGTH, TIME, MASS, INERTIA, TORQUE, DAMPING, NONE = 1.0, 0.5, 3.0, 5.0, 4.0, 4.5, 0.0

# MJCF: (elements, attribute) -> powers of its numbers; one number stands for all, None leaves the number alone.
SCALED_ATTRIBUTES = {
    ("body geom site camera light inertial joint", "pos"): LENGTH,
    ("geom site", "size"): LENGTH,
    ("geom site", "fromto"): LENGTH,
    ("geom pair", "margin"): LENGTH,
    ("geom pair", "gap"): LENGTH,
    ("geom", "friction"): [NONE, LENGTH, LENGTH],  # sliding; torsional and rolling are lengths
    ("pair", "friction"): [NONE, NONE, LENGTH, LENGTH, LENGTH],
    ("geom pair", "solref"): [TIME, NONE],
    ("geom pair", "solimp"): [NONE, NONE, LENGTH, NONE, NONE],
    ("inertial", "mass"): MASS,
    ("inertial", "fullinertia"): INERTIA,
    ("inertial", "diaginertia"): INERTIA,
    ("joint", "armature"): INERTIA,
    ("joint", "damping"): DAMPING,
    ("joint", "frictionloss"): TORQUE,
    ("joint", "stiffness"): TORQUE,
    ("joint", "actuatorfrcrange"): TORQUE,
    ("motor", "ctrlrange"): TORQUE,
    ("motor", "forcerange"): TORQUE,
    ("option", "timestep"): TIME,
    ("statistic", "center"): LENGTH,
    ("statistic", "extent"): LENGTH,
}
UNSUPPORTED = {"include", "mesh", "hfield", "skin", "flexcomp", "composite", "replicate", "frame", "tendon", "equality", "exclude"}

# MJCF: what a reference refers to.
REFERENCES = {
    "class": "class", "childclass": "class", "material": "material", "texture": "texture", "joint": "joint",
    "site": "site", "geom": "geom", "geom1": "geom", "geom2": "geom", "body": "body", "body1": "body", "body2": "body",
    "target": "body",
}  # fmt: skip

# Profile: key -> power of the scale. A key that is not here is an error: a silent guess would spoil the similarity.
PROFILE = {
    "stance": {"width": LENGTH, "com_height": LENGTH},
    "reach": {"foot": LENGTH, "trunk": LENGTH, "hand": LENGTH, "rotation": NONE},
    "region": {"foot_x": LENGTH, "stride": LENGTH, "foot_lateral": LENGTH, "foot_yaw": NONE, "sole_gap": LENGTH, "com_height": LENGTH,
               "trunk_inclination": NONE, "trunk_yaw": NONE, "hand_distance": LENGTH},
    "swing": {"clearance": LENGTH, "lift": LENGTH, "time": TIME},
    "ground": {"flatness": LENGTH, "tilt_deg": NONE},
    "duration": {"default": TIME, "step": TIME, "max": TIME},
    "phases": {"step": NONE, "lift": NONE, "lower": NONE, "flow": NONE, "weights": NONE},
    "margin": {"zmp_plan": LENGTH, "zmp_outward": LENGTH, "zmp_verify": LENGTH, "zmp_feedback": LENGTH, "stand_on": LENGTH, "joint": NONE,
               "speed": NONE, "torque": NONE, "acceleration": -1.0, "friction": NONE, "self_collision": LENGTH, "edge": LENGTH},
    "ik": {"position": LENGTH, "rotation": NONE, "hand": LENGTH},
    "tick": {"period": NONE, "lookahead": NONE},
    "stabiliser": {"k_dcm": NONE},
}  # fmt: skip
GAINS = {"kp": TORQUE, "kd": DAMPING}
HEAT = {"continuous": NONE, "winding": NONE, "winding_time": TIME, "housing_time": TIME}
PARTS = {
    "trunk": "body", "left_foot": "site", "right_foot": "site", "left_hand": "site", "right_hand": "site",
    "left_shoulder": "body", "right_shoulder": "body", "imu": "site",
}  # fmt: skip


class Names:
    """One new word for each (kind, old name)."""

    def __init__(self, rng):
        self.rng, self.words = rng, {}

    def __call__(self, kind, old):
        key = (kind, old)
        while key not in self.words:
            word = "".join(self.rng.choice("bdfgklmnprstvz") + self.rng.choice("aeiou") for _ in range(2))
            word += f"{self.rng.randrange(100):02d}"
            if word not in self.words.values():
                self.words[key] = word
        return self.words[key]


def scaled(value, power, s):
    """A number, or a list of numbers, times s to the power; to nine digits."""
    if isinstance(value, list):
        return [scaled(v, power, s) for v in value]
    return value if power == NONE else float(f"{value * s**power:.9g}")


def scale_text(text, powers, s):
    numbers = text.split()
    powers = powers if isinstance(powers, list) else [powers] * len(numbers)
    return " ".join(f"{scaled(float(n), p, s):.9g}" if p else n for n, p in zip(numbers, powers))


def kind_of(element, section):
    """The name space that an element's name belongs to."""
    if section in ("actuator", "sensor"):
        return section
    return {"freejoint": "joint", "default": "class"}.get(element.tag, element.tag)


def rename(root, names):
    root.set("model", names("model", root.get("model")))
    for section in root:
        for element in section.iter():
            for attribute, value in list(element.attrib.items()):
                if element.tag == "default" and attribute == "class" and value == "main":
                    continue
                if attribute == "name":
                    element.set(attribute, names(kind_of(element, section.tag), value))
                elif attribute in ("objname", "refname"):
                    kind = element.get(attribute[:3] + "type")
                    element.set(attribute, names("body" if kind == "xbody" else kind, value))
                elif attribute in REFERENCES and section.tag != "visual":
                    element.set(attribute, names(REFERENCES[attribute], value))


def scale_model(root, s):
    rules = {(tag, attribute): p for (tags, attribute), p in SCALED_ATTRIBUTES.items() for tag in tags.split()}
    for element in root.iter():
        if element.tag in UNSUPPORTED:
            raise SystemExit(f"scale_robot: <{element.tag}> is not supported")
        for attribute, value in element.attrib.items():
            if (element.tag, attribute) in rules:
                element.set(attribute, scale_text(value, rules[element.tag, attribute], s))


def qpos_layout(root):
    """The joints in the order of qpos, with their number of coordinates."""
    sizes = {"free": 7, "ball": 4, "slide": 1, "hinge": 1}
    joints = [j for b in root.find("worldbody").iter("body") for j in b if j.tag in ("joint", "freejoint")]
    return [(j, sizes["free" if j.tag == "freejoint" else j.get("type", "hinge")]) for j in joints]


def split_qpos(key, layout):
    numbers, out, at = key.get("qpos").split(), {}, 0
    for joint, size in layout:
        out[joint] = numbers[at : at + size]
        at += size
    if at != len(numbers):
        raise SystemExit(f"scale_robot: key {key.get('name')} has {len(numbers)} numbers, the model {at} coordinates")
    return out


def reorder(root, s, rng):
    """Branches of the tree in reverse, motors, sensors and pairs shuffled; keyframes follow, and their lengths scale."""
    before = qpos_layout(root)
    poses = [(key, split_qpos(key, before)) for key in root.iter("key")]
    for body in root.find("worldbody").iter("body"):
        branches = body.findall("body")
        for branch in branches:
            body.remove(branch)
        body.extend(reversed(branches))
    for section in ("actuator", "sensor", "contact"):
        for element in root.findall(section):
            children = list(element)
            rng.shuffle(children)
            element[:] = children
    for key, pose in poses:
        numbers = []
        for joint, size in qpos_layout(root):
            lengths = 3 if size == 7 else int(joint.get("type") == "slide")
            numbers += [scale_text(n, LENGTH if i < lengths else NONE, s) for i, n in enumerate(pose[joint])]
        key.set("qpos", " ".join(numbers))


def scale_profile(profile, s, names):
    out = {"name": f"biped-{s:g}", "model": "model.xml"}
    out["parts"] = {part: names(PARTS[part], name) for part, name in profile["parts"].items()}
    out["home_deg"] = {names("joint", joint): angle for joint, angle in reversed(profile["home_deg"].items())}
    for table, rules in PROFILE.items():
        for key in profile.get(table, {}):
            if key not in rules:
                raise SystemExit(f"scale_robot: no scaling rule for [{table}] {key}; add one to PROFILE")
        if table in profile:  # else derived
            out[table] = {key: scaled(value, rules[key], s) for key, value in profile[table].items()}
    for table in profile:
        if table not in out and table != "drive":
            raise SystemExit(f"scale_robot: no scaling rule for [{table}]; add one to PROFILE")
    if "duration" in out:
        tick = out["tick"]["period"]
        out["duration"] = {key: round(math.floor(t / tick + 0.5) * tick, 9) for key, t in out["duration"].items()}
    out["drive"] = {key: value for key, value in profile["drive"].items() if key != "gains"}
    out["drive"]["gains"] = [
        {key: [names("joint", j) for j in reversed(value)] if key == "joints"
         else {k: scaled(v, HEAT[k], s) for k, v in value.items()} if key == "heat"
         else scaled(value, GAINS[key], s)
         for key, value in gains.items()}
        for gains in profile["drive"].get("gains", [])
    ]  # fmt: skip
    return out


def toml(table, path=""):
    """As much of TOML as a profile needs."""

    def literal(value):
        if isinstance(value, bool):
            return str(value).lower()
        if isinstance(value, str):
            return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
        if isinstance(value, list):
            return "[" + ", ".join(map(literal, value)) + "]"
        return repr(value)

    def is_tables(value):
        return isinstance(value, list) and bool(value) and isinstance(value[0], dict)

    lines = [f"{key} = {literal(v)}" for key, v in table.items() if not isinstance(v, dict) and not is_tables(v)]
    for key, value in table.items():
        name = f"{path}{key}"
        if isinstance(value, dict):
            lines += ["", f"[{name}]", *toml(value, name + ".")]
        elif is_tables(value):
            for row in value:
                lines += ["", f"[[{name}]]", *toml(row, name + ".")]
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robot", type=pathlib.Path, help="folder with a profile.toml")
    parser.add_argument("out", type=pathlib.Path, help="folder to write to")
    parser.add_argument("--scale", type=float, default=1.7, help="of lengths (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of names and orders (default %(default)s)")
    arguments = parser.parse_args()
    s = arguments.scale
    if not (math.isfinite(s) and s > 0):
        parser.error(f"--scale must be positive, not {s}")

    profile = tomllib.loads((arguments.robot / "profile.toml").read_text())
    root = ET.parse(arguments.robot / profile["model"]).getroot()
    rng = random.Random(arguments.seed)
    names = Names(rng)

    reorder(root, s, rng)
    scale_model(root, s)
    rename(root, names)
    profile = scale_profile(profile, s, names)

    arguments.out.mkdir(parents=True, exist_ok=True)
    ET.indent(root)
    (arguments.out / "model.xml").write_text(ET.tostring(root, encoding="unicode") + "\n")
    (arguments.out / "profile.toml").write_text("\n".join(toml(profile)) + "\n")


if __name__ == "__main__":
    main()
