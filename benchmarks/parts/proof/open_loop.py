"""Position of the EMPS from its recorded force alone, by the published model and by those found here."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.diagnosis.findings.diagnosis import Diagnosis
from exidyn.identification.diagnosis.improved.improved import Arm, as_found, as_nominal
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.identified import identified
from exidyn.identification.recordings.recording import Recording

PUBLISHED = {"M1": 95.1089, "Fv1": 203.5034, "Fc1": 20.3935, "Off1": -3.1648}
"""The EMPS's parameters by its authors [kg, N s/m, N, N]."""


GIVEN, WITH_NAMES = "identified, as given", "identified with what was named"


def worse_position(errors: dict[str, dict[str, float]]) -> str:
    """Whether what was named makes the position of the run held out better or worse."""
    before, after = (list(errors[model].values())[-1] for model in (GIVEN, WITH_NAMES))
    words = "**worse**" if after > before else "better"
    return f"identified as given and with what was named: {before:.2f} → {after:.2f} mm, {words}"


def open_loop(found: Diagnosis, runs: Any) -> dict[str, dict[str, float]]:
    """Error of the position that recorded force gives, model -> run -> root mean square [mm]."""
    assert found.evidence is not None
    plain = as_nominal(found.evidence)
    # Parameters were fitted beside undecided findings too.
    with_it = as_found(found.evidence, (*found.findings, *found.undecided))
    values = np.array([PUBLISHED.get(name, 0.0) for name in plain.model.names])
    fitted = [run for role, run in runs if role != HELD_OUT]
    arms = {
        "published": replace(plain, values=values),
        GIVEN: identified_arm(plain, fitted),
        "diagnosed, with findings": with_it,
        WITH_NAMES: identified_arm(as_found(found.evidence, found.findings), fitted),
    }
    return {name: {run.name: simulated(arm, run) for _, run in runs} for name, arm in arms.items()}


def identified_arm(arm: Arm, runs: Sequence[Recording]) -> Arm:
    """An arm's model as `identify` fits it to the runs."""
    model = identified(identify(runs, model=arm.model))
    return replace(arm, model=model, values=model.nominal_values)


def simulated(arm: Arm, run: Recording) -> float:
    """Root mean square error of the position of a single joint, from recorded force alone [mm].

    Force without acceleration is tabulated over position and velocity, closely around standstill, where dry
    friction reverses; so this holds what depends on these two only. Steps are those of the recording.
    """
    time_, measured = run.signals["position"].time, run.signals["position"].values[:, 0]
    force = np.interp(time_, run.signals["torque"].time, run.signals["torque"].values[:, 0])
    table, inertia, origin, step, slow = _tables(arm, measured)
    position, velocity, path = measured[0], 0.0, np.empty(len(time_))
    for k, seconds in enumerate(np.diff(time_, append=time_[-1])):
        path[k] = position
        row = min(max((position - origin) / step, 0.0), len(table) - 1.001)
        column = min(
            max(np.arcsinh(velocity / slow) / BEND + table.shape[1] // 2, 0.0), table.shape[1] - 1.001
        )
        i, j, u, v = int(row), int(column), row % 1.0, column % 1.0
        near_, far = (
            table[i, j] * (1 - v) + table[i, j + 1] * v,
            table[i + 1, j] * (1 - v) + table[i + 1, j + 1] * v,
        )
        velocity += seconds * (force[k] - near_ * (1 - u) - far * u) / inertia
        position += seconds * velocity
    return 1e3 * float(np.sqrt(np.mean((path - measured) ** 2)))


BEND = 0.02
"""Step of the velocities' scale, the inverse hyperbolic sine of velocity over a slow one."""


def _tables(arm: Arm, measured: np.ndarray) -> tuple[np.ndarray, float, float, float, float]:
    """Force (places, velocities), inertia, first place, step of places, slow velocity."""
    slow = 1e-3
    places = np.linspace(measured.min() - 0.05, measured.max() + 0.05, 200)
    speeds = slow * np.sinh(BEND * np.arange(-350, 351))
    grid = np.array(np.meshgrid(places, speeds, indexing="ij")).reshape(2, -1, 1)

    def force(position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
        motion = Motion.of(np.arange(len(position)) * 1.0, position, velocity, acceleration)
        return arm.model.torque(motion, arm.values)[:, 0]

    table = force(grid[0], grid[1], np.zeros_like(grid[0])).reshape(len(places), len(speeds))
    still, one = np.zeros((2, 1)), np.array([[0.0], [1.0]])
    inertia = float(np.diff(force(still, still, one))[0])
    return table, inertia, float(places[0]), float(places[1] - places[0]), slow
