"""Rehearsal: the run on a simulated arm, by the same path, before the real one moves."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from exidyn.drivers import Arm, create
from exidyn.identify.model import Model
from exidyn.identify.simulation.plant import typical_plant

from .errors import NotAllowed
from .perform import Job, Outcome, perform


def rehearse(job: Job, model: Model, cycle: float, payload: str = "") -> Outcome:
    """Play the job on the mock, which is the arm as believed and stands where the motion begins.

    Args:
        job: What to do.
        model: The arm as believed, with its payload.
        cycle: Of the controller that is rehearsed for [s].
        payload: Name of the body that it carries; empty for none.

    Raises:
        NotAllowed: The simulated arm had to be stopped.
    """
    start = job.motion.state_at(0.0).position
    limits = model.robot.limits
    arm = Arm(
        model.robot.joints,
        limits.position_lower,
        limits.position_upper,
        limits.velocity,
        lambda: typical_plant(model, start, payload=payload),
    )
    settings: Mapping[str, Any] = {"cycle": cycle, "clock": "stepped"}
    watch = replace(job.watch, temperature=float("inf"))  # how warm the real arm is, nobody knows
    outcome = perform(create("mock", settings, arm), replace(job, settle=cycle, watch=watch))
    if outcome.stop is not None:
        raise NotAllowed(
            f"in a rehearsal on the simulated arm the run was stopped: {outcome.stop.text}. Look at the "
            "limits and drive gains of the robot file, or play it slower with --speed"
        )
    return outcome
