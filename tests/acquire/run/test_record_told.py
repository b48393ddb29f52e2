"""An arm that still moves, or may, is told of in every place: on real sockets, with peers that misbehave."""

import pytest

from ...parts.runs.told import CASES, attempted

pytestmark = pytest.mark.clocked

SHOWN = (
    "UR: clock stands still, arm runs on", "UR: clock is no number", "UR: arm creeps on",
    "UR: connection cut", "KUKA: axis runs on", "CAN: power of a drive lost",
    "CAN: a drive leaves operational",
)  # fmt: skip
"""One of each kind; `benchmarks/record.py --only told` has all."""


@pytest.mark.slow
@pytest.mark.parametrize("case", [case for case in CASES if case.name in SHOWN], ids=lambda case: case.name)
def test_what_the_arm_does_at_the_end_is_told_everywhere(case, tmp_path):
    seen, places, bad, _ = attempted(case, tmp_path)
    assert places == [], seen
    assert bad == [], seen
