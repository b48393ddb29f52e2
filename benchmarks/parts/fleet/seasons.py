"""Half a year of weekly check runs of many arms, without files.

The motion is the same each week, so that its regressor is formed once an arm; currents, their noise, filter
and identification are each run's own.
"""

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from exidyn.identification.effects import Payload
from exidyn.identification.fit.base_parameters import BaseParameters
from exidyn.identification.fit.equations import Equations, assemble, decimated_regressor
from exidyn.identification.fleet.kind import Kind, fleet_model
from exidyn.identification.fleet.runs import Run
from exidyn.identification.fleet.summary import held, reduced
from exidyn.identification.model import Model
from exidyn.identification.preparation.prepare import Prepared, prepare
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import simulate

from .arms import Arm
from .recordings import PART, SECONDS, motion, weather


class CheckRun(NamedTuple):
    """A type's check run, with the part or without.

    Attributes:
        kind: The type.
        prepared: Its motion.
        equations: Of the nominal arm.
    """

    kind: Kind
    prepared: Prepared
    equations: Equations


@lru_cache
def check_run(name: str, carries: bool) -> CheckRun:
    """From a recording of the nominal arm."""
    nominal, payload = read_model(name), PART if carries else None
    plant = nominal + Payload(PART.name, PART.known) if carries else nominal
    recording = simulate(
        plant, plant.nominal_values, nominal.robot.drive_gain, motion(name), nominal, payload=payload
    )
    kind = check_run(name, False).kind if carries else Kind.of(recording)
    model = fleet_model(nominal)
    model = model + Payload(PART.name, PART.known) if carries else model
    prepared = prepare(replace(recording, model=model), kind.filtering)
    return CheckRun(kind, prepared, held(assemble(model, kind.base, [prepared]), kind, True))


def season(name: str, arm: Arm, weeks: int, begin: float) -> list[Run]:
    """Runs of an arm whose wear begins in week `begin`."""
    columns = {carries: _columns(name, arm, carries) for carries in (False, True)}
    return [_run(name, arm, week, begin, columns) for week in range(weeks)]


Columns = dict[bool, tuple[np.ndarray, np.ndarray]]


def _run(name: str, arm: Arm, week: int, begin: float, columns: Columns) -> Run:
    random = np.random.default_rng([week, *arm.name.encode()])
    day, worn, temperature = weather(arm, week, begin, random)
    carries = bool(random.uniform() < 0.25)
    own, (regressor, known) = check_run(name, carries), columns[carries]
    exact = (regressor @ arm.values(temperature, worn, random) + known) / arm.gains(worn)
    full = random.normal(size=own.prepared.current.shape) * arm.noise * np.sqrt(np.mean(exact**2, axis=0))
    current = exact + own.prepared.decimation.apply(full)
    payload = PART.name if carries else ""
    said = reduced(replace(own.equations, current=current), temperature, payload, True, SECONDS)
    return Run(f"{arm.name} {week}", day, said)


def _columns(name: str, arm: Arm, carries: bool) -> tuple[np.ndarray, np.ndarray]:
    """Regressor of the arm as it is, all its parameters, and known torque, behind the filter."""
    model: Model = arm.built + Payload(PART.name, PART.known) if carries else arm.built
    prepared, count = check_run(name, carries).prepared, len(arm.built.names)
    every = BaseParameters(tuple(model.parameters), np.arange(count), np.eye(count), (1.0, 0.0))
    exact = replace(motion(name), payload=PART.name if carries else "")
    first = round(prepared.motion.time[0] * prepared.decimation.rate)
    return decimated_regressor(model, every, prepared, exact[first : first + len(prepared.motion)])
