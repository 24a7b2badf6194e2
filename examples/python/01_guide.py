"""Guides mighty by one body part after the other, and prints what happens.

    python examples/python/01_guide.py [robot]
"""

import sys

import baton


def advance(run, seconds):
    for event in run.advance(seconds):
        print(f"  {event!r}")
        if isinstance(event, baton.Refused):
            print(f"  refused: {event.refusal}")


run = baton.Run(baton.Robot(sys.argv[1] if len(sys.argv) > 1 else "mighty"), seed=1)
start = run.truth.q[:3].copy()

print("a step of the left foot")
run.guide("left_foot", [1, 0, 0, 0, 0, 0])
advance(run, 0.5)
run.release()
advance(run, 2.0)

print("a walk, guided by the trunk: the feet step by themselves")
run.guide("trunk", [1, 0, 0, 0, 0, 0])
advance(run, 6.0)
run.release()
advance(run, 3.0)

print("a reach, until it is refused or the arm is long")
before = run.pose("left_hand")[:3, 3]
run.guide("left_hand", [0, 0, 1, 0, 0, 0])
advance(run, 4.0)
run.release()
advance(run, 2.0)

way = run.truth.q[:3] - start
rise = run.pose("left_hand")[2, 3] - before[2]
print(f"{way[0]:.2f} m ahead, the hand {100 * rise:.0f} cm higher, {'fallen' if run.fallen else 'on its feet'}")
sys.exit(int(run.fallen))
