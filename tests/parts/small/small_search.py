"""A two-joint arm that has more than its model, and what a search finds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.diagnosis.questions.block_answer import Answer
from exidyn.identification.diagnosis.runs.usable import usable
from exidyn.identification.diagnosis.search.beliefs import with_tolerance
from exidyn.identification.diagnosis.search.problem import Problem
from exidyn.identification.diagnosis.search.ranking import ranked
from exidyn.identification.diagnosis.search.search import SearchResult, search
from exidyn.identification.effects import Effect, JointSpring, NonlinearViscousFriction
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.simulation.simulate import simulate
from exidyn.trajectories.random_motion import random_fourier

from . import two_joints
from .small_diagnosis import TRUE, nominal_model

LENGTHS = {"identify": 16.0, "validate": 8.0}
ROLES = ("identify", "identify", "validate")
TICK = 0.004

Change = Callable[[str, Motion, np.ndarray], np.ndarray]
"""Role, motion and current (t, n) [A] of a run -> its current."""


def record(
    effects: Sequence[Effect] = (),
    values: Mapping[str, float] | None = None,
    roles: Sequence[str] = ROLES,
    model: Model | None = None,
    change: Change | None = None,
    only: str = "",
) -> list[tuple[str, Recording]]:
    """Runs of an arm with further effects, whose parameters are given by name.

    The effects are in the arm and not in the model, in runs of the role `only`; by default in all.
    """
    model = nominal_model() if model is None else model
    runs = []
    for seed, role in enumerate(roles):
        own = effects if only in ("", role) else ()
        plant = replace(model, effects=(*model.effects, *own))
        given = TRUE | dict(values or {})
        true = np.array([given.get(n, b) for n, b in zip(plant.names, plant.nominal_values, strict=True)])
        path = random_fourier(model.robot.limits, LENGTHS[role], period=5.0, seed=seed)
        motion = path.at(np.arange(0.0, LENGTHS[role], TICK))
        made = simulate(plant, true, two_joints.GAIN, motion, model, name=f"{role}{seed}", seed=seed)
        if change is not None:
            current = made.signals["current"]
            now = change(role, motion, current.values)
            made = replace(made, signals={**made.signals, "current": Signal(current.time, now)})
        runs.append((role, replace(made, settings={**made.settings, "role": role})))
    return runs


def problem(runs: Sequence[tuple[str, Recording]], model: Model | None = None) -> Problem:
    model = nominal(nominal_model() if model is None else model)
    return Problem.of(model, usable(model, runs)[0])


def nominal(model: Model) -> Model:
    """The model with free bodies, unless their tolerance is stated."""
    return model if model.robot.inertias_stated else with_tolerance(model, None)


def searched(runs: Sequence[tuple[str, Recording]], model: Model | None = None) -> SearchResult:
    return search(problem(runs, model))


def alone(found: SearchResult) -> list[Answer]:
    """Every hypothesis as the only finding, the most probable first."""
    return ranked(found.problem, found.without_findings, [], {})


SPRING, SOFT = JointSpring(("elbow",)), {"Ks2": 4.0}
DRAG, THICK = NonlinearViscousFriction(("elbow",), 1.7), {"Fn2": 1.5}


@cache
def spring_search() -> SearchResult:
    """What is found on an arm with a soft spring; tests share it and do not change it."""
    return searched(record([SPRING], SOFT))


@cache
def drag_search() -> SearchResult:
    """What is found on an arm with nonlinear viscous friction."""
    return searched(record([DRAG], THICK))


@cache
def drag_and_spring_search() -> SearchResult:
    return searched(record([DRAG, SPRING], THICK | SOFT))


@cache
def sound_problem(runs: int = 1) -> Problem:
    """Fitted runs of an arm that is as its model states."""
    return problem(record(roles=("identify",) * runs))


def names(found: SearchResult) -> list[tuple[str, tuple[int, ...]]]:
    return [(one.answer.candidate.effect, one.answer.candidate.joints) for one in found.selected]
