"""Marks the tests of arithmetic, which `check` runs under a second kernel of the linear algebra library too.

Marks those against the clock as well, of which it runs two at a time at most, and slow ones, which
`check --fast` leaves out.
"""

import pytest

NUMERICAL = (
    "align", "base_parameters", "criteria", "cutoffs", "block_likelihood", "diagnosis_amplitude",
    "diagnosis_prediction", "diagnosis_search", "distinction", "effects", "equations", "essential",
    "estimators", "excitation_warnings", "export", "filters", "fit_warnings", "fit_file",
    "friction_curve", "identify",
    "experiment", "mdh", "model", "motion_gradient", "noise", "payload", "recorded_velocity",
    "rigid_gradient", "rigid_regressor", "shape_uncertainty", "shapes", "solve", "spring_balancer", "verdict",
)  # fmt: skip
"""Files test_NAME.py whose results hang on matrices: decompositions, ranks, and decisions made of them."""
FILES = {f"test_{name}.py" for name in NUMERICAL}
SLOW = ("test_instruments_see_through_the_loop", "test_sandwich_is_the_sum_over_lags_of_the_known_colour")
"""Of those files, what takes as long as all others together: many repetitions, of which the mean counts."""

LENGTHY = (
    "api", "bad_input", "belief", "chirp", "command_line", "compare", "concealed_cases",
    "concealed_effects", "concealed_plant", "concealed_scores", "coverage", "diagnose_command",
    "diagnose_real", "diagnosis_budget", "diagnosis_coupling", "diagnosis_delay", "diagnosis_link_encoders",
    "diagnosis_ripple", "diagnosis_search", "diagnosis_states", "diagnosis_tilt", "diagnosis_toy",
    "discriminate", "estimators", "excite", "fuzz", "identify", "improved", "kernels", "kinds", "moves",
    "notebooks", "plan_view", "planner", "plant", "plant_parts", "report_command", "shrink",
    "simulate_command", "single_joint", "static_poses", "sweeps", "run_with_leads",
)  # fmt: skip
"""Files test_NAME.py of more than some seconds, which `check --fast` leaves out."""

CLOCKED = (
    "brake", "can", "command_help", "confirm", "controllers", "driver", "dynamixel", "escalation", "example",
    "excite_command", "feetech", "franka", "host_clock", "jog", "krc", "kuka", "live", "loop", "mock",
    "parallel", "pipe", "player", "read_only", "record", "recover", "rsi", "run_gone", "run_head", "run_log",
    "serial", "servo", "signs", "stale", "start", "stop", "ur_", "view", "watch",
)  # fmt: skip
"""Beginnings of files whose runs keep to the clock, or have processes of their own."""
PATIENT = (
    "command_help", "example", "excite_command", "jog", "kuka_probe", "live", "parallel", "player", "recover",
    "run_gone", "run_head", "run_log", "signs", "stale", "view",
)  # fmt: skip
"""Of those, what bears cycles that a busy machine misses: it runs beside another one of them or of the rest,
of which one runs at a time."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.name in FILES and not item.name.startswith(SLOW):
            item.add_marker(pytest.mark.numerical)
        if item.path.stem.removeprefix("test_") in LENGTHY:
            item.add_marker(pytest.mark.slow)
        name = item.path.name.removeprefix("test_")
        if name.startswith(CLOCKED):
            item.add_marker(pytest.mark.clocked)
            item.add_marker(pytest.mark.xdist_group(name if name.startswith(PATIENT) else "clock"))
