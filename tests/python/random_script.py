#!/usr/bin/env python3
"""Stick scripts at random, as JSON Lines for `baton drive --input script:FILE`.

    random_script.py --seed 7 --seconds 30 [--style mixed] > file

Styles:
    mixed     everything that a hand, a child or a broken device may do: long held commands, hectic ones, full stick,
              single and all axes, guide changes at any time, feet lifted, values beyond ±1, nulls, denormals
    uniform   all six axes at random, a new command every 0.5-2 s
    friendly  an operator who means it: one clear command, held 2-4 s
    hectic    a new command every 0.1-0.5 s

The stick is away from the centre for at least 70 % of the time. The same seed gives the same script.
Standard library only.
"""

import argparse
import json
import random
import sys

GUIDES = ("left_foot", "right_foot", "left_hand", "right_hand", "trunk")
STYLES = ("mixed", "uniform", "friendly", "hectic")
LEAST_DEFLECTED = 0.7
# A broken device: JSON null is NaN; the rest is clamped or tiny.
STRANGE = (None, 1e300, -1e300, 7.0, -3.0, 5e-324, -5e-324, 2.2e-308, 1e-9, -0.0)


def _sign(rng):
    return rng.choice((-1.0, 1.0))


def _axes(rng, kind):
    """Six axes of one kind of deflection."""
    axes = [0.0] * 6
    if kind == "single_full":
        axes[rng.randrange(6)] = _sign(rng)
    elif kind == "single":
        axes[rng.randrange(6)] = round(rng.uniform(-1, 1), 3)
    elif kind == "plane":  # the stick itself: two axes
        axes[0], axes[1] = round(rng.uniform(-1, 1), 3), round(rng.uniform(-1, 1), 3)
    elif kind == "all":
        axes = [round(rng.uniform(-1, 1), 3) for _ in range(6)]
    elif kind == "corner":
        axes = [_sign(rng) for _ in range(6)]
    elif kind == "some":
        for i in rng.sample(range(6), rng.randint(2, 4)):
            axes[i] = round(rng.uniform(-1, 1), 3)
    elif kind == "strange":
        axes = [rng.choice(STRANGE) if rng.random() < 0.5 else round(rng.uniform(-1, 1), 3) for _ in range(6)]
    return axes


def _lift(rng):
    value = lambda: rng.choice((0.0, 0.0, 0.5, 1.0, round(rng.random(), 3)))
    kind = rng.random()
    if kind < 0.45:
        return [0.0, 0.0]
    if kind < 0.55:  # both throttles at once
        return [rng.choice((0.5, 1.0)), rng.choice((0.5, 1.0))]
    if kind < 0.62:
        return [rng.choice((None, -1.0, 3.0, 0.04, 0.051, 5e-324, 1e300)) for _ in range(2)]
    return [value(), value()]


def _mixed(rng, state):
    """One stretch: a list of (hold, guide, axes, lift)."""
    out = []
    kind = rng.choices(("held", "normal", "hectic", "switch", "throttle", "centre"), (22, 30, 16, 14, 12, 8))[0]
    deflection = lambda: _axes(rng, rng.choices(("single_full", "single", "plane", "all", "corner", "some", "strange"), (22, 14, 18, 14, 8, 16, 8))[0])
    if rng.random() < 0.5:
        state["guide"] = rng.choice(GUIDES)
    if rng.random() < 0.4:
        state["lift"] = _lift(rng)
    if kind == "held":
        out.append((rng.uniform(2, 6), state["guide"], deflection(), state["lift"]))
    elif kind == "normal":
        for _ in range(rng.randint(1, 3)):
            out.append((rng.uniform(0.5, 2), state["guide"], deflection(), state["lift"]))
    elif kind == "hectic":
        until = rng.uniform(1, 3)
        while until > 0:
            hold = rng.uniform(0.1, 0.5)
            until -= hold
            if rng.random() < 0.3:
                state["guide"] = rng.choice(GUIDES)
            out.append((hold, state["guide"], deflection(), state["lift"]))
    elif kind == "switch":  # the stick is held, what it guides changes
        axes = deflection()
        for _ in range(rng.randint(2, 4)):
            state["guide"] = rng.choice(GUIDES)
            out.append((rng.uniform(0.3, 2.5), state["guide"], axes, state["lift"]))
    elif kind == "throttle":  # up, perhaps somewhere, perhaps down again, perhaps another part meanwhile
        foot = rng.choice(GUIDES[:2])
        up = rng.choice((0.5, 1.0, round(rng.random(), 3)))
        lift = [up, 0.0] if foot == "left_foot" else [0.0, up]
        state["guide"] = foot
        out.append((rng.uniform(0.5, 2), foot, [0.0] * 6, lift))
        for _ in range(rng.randint(0, 2)):
            out.append((rng.uniform(0.5, 2), foot, deflection(), lift))
        if rng.random() < 0.6:
            lift = [0.0, 0.0]
            out.append((rng.uniform(0.3, 1.5), foot, deflection() if rng.random() < 0.5 else [0.0] * 6, lift))
        state["lift"] = lift
    else:
        out.append((rng.uniform(0.1, 1.5), state["guide"], [0.0] * 6, state["lift"]))
    return out


def _friendly(rng, state):
    guide = rng.choices(GUIDES, (1, 1, 1, 1, 2))[0]
    axes, lift = [0.0] * 6, [0.0, 0.0]
    if guide == "trunk":
        kind = rng.choices(("plane", "height", "turn", "lean"), (6, 1, 2, 1))[0]
        if kind == "plane":
            axes[0], axes[1] = rng.choice(((1, 0), (-1, 0), (0, 1), (0, -1), (0.7, 0.7), (0.7, -0.7), (-0.7, 0.7), (-0.7, -0.7)))
        else:
            axes[{"height": 2, "turn": 5, "lean": rng.choice((3, 4))}[kind]] = _sign(rng)
    elif guide in GUIDES[:2]:
        kind = rng.choices(("step", "turn", "lift"), (6, 1, 2))[0]
        if kind == "lift":
            lift = [1.0, 0.0] if guide == "left_foot" else [0.0, 1.0]
        elif kind == "turn":
            axes[5] = _sign(rng)
        else:
            axes[rng.randrange(2)] = _sign(rng) * rng.choice((0.5, 1.0))
    else:
        axes[rng.randrange(3)] = _sign(rng) * rng.choice((0.5, 1.0))
    out = [(rng.uniform(2, 4), guide, [float(a) for a in axes], lift)]
    if rng.random() < 0.3:
        out.append((rng.uniform(0.3, 1), guide, [0.0] * 6, [0.0, 0.0]))
    return out


def _stretch(rng, style, state):
    if style == "mixed":
        return _mixed(rng, state)
    if style == "friendly":
        return _friendly(rng, state)
    hold = rng.uniform(0.5, 2) if style == "uniform" else rng.uniform(0.1, 0.5)
    return [(hold, rng.choice(GUIDES), _axes(rng, "all"), _lift(rng))]


def _number(value):
    return 0.0 if value is None else float(value)


def deflected(guide, axes, lift):
    """Whether a command asks for anything: NaN counts as centred."""
    foot = {"left_foot": 0, "right_foot": 1}.get(guide)
    return any(_number(a) != 0.0 for a in axes) or (foot is not None and _number(lift[foot]) > 0.0)


def commands(seed, seconds=30.0, style="mixed"):
    """[(t, guide, axes, lift)], t in whole milliseconds."""
    rng = random.Random(f"{style} {seed}")
    while True:
        state = {"guide": rng.choice(GUIDES), "lift": [0.0, 0.0]}
        out, t, active = [], 0.0, 0.0
        while t < seconds:
            for hold, guide, axes, lift in _stretch(rng, style, state):
                if t >= seconds:
                    break
                hold = min(round(hold, 3), seconds - t)
                out.append((round(t, 3), guide, axes, list(lift)))
                active += hold * deflected(guide, axes, lift)
                t += hold
        if active >= LEAST_DEFLECTED * seconds:
            return out


def lines(seed, seconds=30.0, style="mixed"):
    return [json.dumps({"t": t, "guide": g, "axes": a, "lift": l}) for t, g, a, l in commands(seed, seconds, style)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--seconds", type=float, default=30.0, help="(default %(default)s)")
    parser.add_argument("--style", choices=STYLES, default="mixed", help="(default %(default)s)")
    arguments = parser.parse_args()
    sys.stdout.write("".join(line + "\n" for line in lines(arguments.seed, arguments.seconds, arguments.style)))


if __name__ == "__main__":
    main()
