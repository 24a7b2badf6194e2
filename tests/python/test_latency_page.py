"""The measurement of bench/latency_page.py finds what became of each change of the stick; how long it takes is not judged."""

import os
import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BATON = pathlib.Path(os.environ.get("BATON", ROOT / "build" / "release" / "baton"))
sys.path.insert(0, str(ROOT / "bench"))

import latency_page  # noqa: E402

pytestmark = pytest.mark.skipif(
    not BATON.is_file() or not (ROOT / "web" / "dist" / "index.html").is_file(), reason="no program or no page: make build"
)


def test_every_change_arrives_and_is_accounted_for(tmp_path):
    changes, report, lags = latency_page.measure(BATON, "mighty", 3, 7, tmp_path)
    assert sum(change.deflected for change in changes) == 3
    ticks = [change.tick for change in changes]
    assert ticks == sorted(ticks) and len(set(ticks)) == len(ticks)
    answered = [change for change in changes if change.response is not None]
    assert answered and all(change.response - change.tick >= 6 for change in answered)
    assert all(change.latency > 0 and change.situation in latency_page.SITUATIONS.values() for change in answered)
    assert report["loop"]["dropped"] >= 0 and report["segments"]["committed"] >= len({change.response for change in answered})
    assert min(lags) == 0
    assert "above 150" in latency_page.row("all", changes)
    assert f"late {report['loop']['late']}," in latency_page.loop_lines(report, lags)
