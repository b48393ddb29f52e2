"""Rehearsal: the run on a simulated arm, by the same path, before the real one moves."""

from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial

from exidyn.identify.model import Model

from .arms import make_driver, simulated_arm
from .errors import NotAllowed
from .perform import Job, Outcome, perform
from .pipe.frames import END, text_frame
from .pipe.pipe_sink import Nobody, Sink


def rehearse(job: Job, model: Model, cycle: float, payload: str = "", shown: Sequence[Sink] = ()) -> Outcome:
    """Play the job on the mock, which is the nominal arm and stands where the motion begins.

    Args:
        job: What to do.
        model: The nominal arm, with its payload.
        cycle: Of the controller that is rehearsed for [s].
        payload: Name of the body that it carries; empty for none.
        shown: Who shows how far it is; closed in the end.

    Raises:
        NotAllowed: The simulated arm had to be stopped.
    """
    start = job.motion.state_at(0.0).position
    settings = {"cycle": cycle, "clock": "stepped"}
    plant = partial(simulated_arm, model, start, payload=payload)
    driver = make_driver("mock", settings, model.robot, plant)
    watch = replace(job.watch, temperature=float("inf"))  # the temperature of the real arm is unknown
    with ExitStack() as stack:
        sinks = [stack.enter_context(closing(sink)) for sink in (Nobody(), *shown)]
        outcome = perform(driver, replace(job, settle=cycle, watch=watch), sinks)
        for sink in sinks:
            sink.put(text_frame(END, {}))
    if outcome.stop is not None:
        raise NotAllowed(
            f"in a rehearsal on the simulated arm the run was stopped: {outcome.stop.text}. Look at the "
            "limits and drive gains of the robot file, or play it slower (exidyn record --speed)"
        )
    return outcome
