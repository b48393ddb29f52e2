"""Edit tests as tables: the error with a body that no run used carries, beside that of the runs held out."""

from collections.abc import Mapping
from typing import Any

from common import show

from exidyn.identification.fit.edit_test import edit_tests
from exidyn.identification.fit.fit import Fit


def edit_test_table(title: str, fits: Mapping[str, Fit]) -> dict[str, Any]:
    """One row an edit test and one for the runs beside it; gives the residuals [N m] by fit and run.

    Args:
        title: Of the table.
        fits: What was done -> the fit, which has an edit test.
    """
    rows: list[list[Any]] = []
    figures: dict[str, Any] = {}
    for label, fit in fits.items():
        tests = edit_tests(fit)
        kind = "held out" if tests[0].held_out else "used"
        rows.append([label, f"runs {kind}, residual", *tests[0].beside])
        for test in tests:
            rows.append(["", f"{test.run}, residual", *test.residual])
            rows.append(["", "  over torque [%]", *(100.0 * test.relative)])
            figures[f"{label}: {test.run}"] = {
                "residual": test.residual,
                "relative": test.relative,
                "beside": test.beside,
            }
    joints = [f"J{j + 1}" for j in range(next(iter(fits.values())).model.robot.dof)]
    show(title, ["edit", "run [N m]", *joints], rows)
    return figures
