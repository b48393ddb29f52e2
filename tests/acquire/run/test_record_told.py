"""An arm that still moves, or may, is told of in every place: on real sockets, with peers that misbehave."""

import pytest

from ...parts.runs.told import CASES, attempted

pytestmark = pytest.mark.clocked

SHOWN = (
    "UR: clock stands still, arm runs on", "UR: clock is no number", "UR: arm creeps on",
    "UR: connection cut", "KUKA: axis runs on", "CAN: power of a drive lost",
    "CAN: a drive leaves operational",
)  # fmt: skip
"""One of each kind; `./check --long` runs all."""
ALL = [
    pytest.param(case, marks=[pytest.mark.long] * (case.name not in SHOWN), id=case.name) for case in CASES
]


@pytest.mark.slow
@pytest.mark.parametrize("case", ALL)
def test_what_the_arm_does_at_the_end_is_told_everywhere(case, tmp_path):
    seen, places, bad, _ = attempted(case, tmp_path)
    assert places == [], seen
    assert bad == [], seen
