"""Refit: identify the model again with the findings, for everything that takes a fit."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from ..arm.robot import Robot
from ..fit.fit import Fit
from ..fit.identification import identify
from ..model import Model
from ..preparation.prepare import Filtering
from ..recordings.recording import Recording
from .findings.diagnosis import Diagnosis
from .improved.improved import as_found
from .runs.usable import HELD_OUT
from .words.measures import slides
from .words.sentences import sentence

NOT_HELD = "not included in this fit, because no model can represent it"


def refit(
    diagnosis: Diagnosis,
    recordings: Sequence[tuple[str, Recording]],
    progress: Callable[[str], None] = lambda _: None,
    filtering: Filtering = Filtering(),  # noqa: B008
) -> Fit | None:
    """Identify the model again with the findings; None for a diagnosis without evidence.

    Findings that no fit can include are listed in its warnings.

    Raises:
        ExidynError: If the runs cannot be fitted.
    """
    if diagnosis.evidence is None:
        return None
    left_out = as_found(diagnosis.evidence, diagnosis.findings).left_out
    fitted_names = {trace.name for trace in diagnosis.evidence.traces}
    used = [(role, run) for role, run in recordings if run.name in fitted_names]
    fit = identify(
        [run for role, run in used if role != HELD_OUT],
        [run for role, run in used if role == HELD_OUT],
        model=model_to_fit(diagnosis),
        filtering=filtering,
        as_recorded=True,  # the diagnosis has checked the recordings already
        progress=progress,
    )
    absent = [diagnosis.findings[place] for place in left_out]
    warnings = [
        f"{sentence(finding, diagnosis.joints, slides(diagnosis, finding))}: {NOT_HELD}" for finding in absent
    ]
    return replace(fit, warnings=(*warnings, *fit.warnings))


def model_to_fit(diagnosis: Diagnosis) -> Model:
    """The nominal model with the effects and drive gains found.

    A diagnosis leaves bodies without stated inertias free. A fit gives them a prior, as it does without a
    diagnosis: what torque does not determine stays nominal, instead of where a solver happens to end.
    """
    assert diagnosis.evidence is not None
    arm = as_found(diagnosis.evidence, diagnosis.findings)
    robot, share = arm.model.robot, arm.gain / diagnosis.evidence.gain_after
    held = robot.inertial_tolerance if robot.inertias_stated else Robot.inertial_tolerance
    return replace(
        arm.model, robot=replace(robot, drive_gain=robot.drive_gain * share, inertial_tolerance=held)
    )
