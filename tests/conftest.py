"""Marks the tests of arithmetic, which `check` runs under a second kernel of the linear algebra library too.

Marks those against the clock as well, which it runs one at a time.
"""

import pytest

NUMERICAL = (
    "align", "base_parameters", "criteria", "cutoffs", "block_likelihood", "diagnosis_prediction",
    "diagnosis_search", "distinction", "effects", "equations", "essential", "estimators",
    "excitation_doubts", "export", "filters", "fit_doubts", "fit_file", "friction_curve", "identify",
    "information", "mdh", "model", "motion_gradient", "noise", "payload", "recorded_velocity",
    "rigid_gradient", "rigid_regressor", "shape_doubt", "shapes", "solve", "spring_balancer", "verdict",
)  # fmt: skip
"""Files test_NAME.py whose results hang on matrices: decompositions, ranks, and decisions made of them."""
FILES = {f"test_{name}.py" for name in NUMERICAL}
SLOW = ("test_instruments_see_through_the_loop", "test_sandwich_is_the_sum_over_lags_of_the_known_colour")
"""Of those files, what takes as long as all others together: many repetitions, of which the mean counts."""

CLOCKED = (
    "brake", "can", "command_help", "confirm", "controllers", "driver", "dynamixel", "escalation", "example",
    "excite_command", "feetech", "host_clock", "jog", "krc", "kuka", "live", "loop", "mock", "parallel",
    "pipe", "player", "read_only", "record", "recover", "rsi", "run_", "serial", "servo", "signs", "stale",
    "start", "stop", "view", "watch",
)  # fmt: skip
"""Beginnings of files whose runs keep to the clock, or have processes of their own."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.name in FILES and not item.name.startswith(SLOW):
            item.add_marker(pytest.mark.numerical)
        if item.path.name.removeprefix("test_").startswith(CLOCKED):
            item.add_marker(pytest.mark.clocked)
