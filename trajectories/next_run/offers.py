"""Offers: planned runs that an arm could make next, and the preparation that each needs."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.improved.improved import found_model, rivals
from exidyn.identification.diagnosis.words.naming import effect_words
from exidyn.identification.effects import Payload
from exidyn.identification.errors import ExidynError
from exidyn.identification.fit.fit import Fit
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal
from exidyn.identification.simulation.simulate import simulate

from ..kinds.by_rule import KINDS, by_rule
from ..limits.usable_limits import usable
from ..planning.goals import two_models
from ..planning.planner import plan
from ..planning.wishes import Wishes, rows_of
from ..plans.plan import Plan

HANDLING = 60.0
"""Time that a person needs to mount or remove a payload [s]."""
TEMPERATURE, WARM = 25.0, 45.0
"""Temperature of a cold and of a warm arm in simulated runs on offer, if temperatures are recorded [degC]."""
WARMING = 1800.0
"""Time that an arm needs to warm up, the thermal time constant of its gears [s]."""
EXCITATIONS = ("an excitation", "an excitation where the fit knows least")
"""Names of the runs that `exidyn excite` plans, before and after a fit."""
ONE_BY_ONE = ("sweeps", "single-joint")
"""Kinds of run in which joints move one after the other."""
RANGES = (1.0, 0.75, 0.5, 0.25)
"""Shares of the joint ranges that are tried with a payload [-]."""
WARM_UP = "Let the arm work until it is warm, for about half an hour"
"""Request of a run with a warm arm."""

Watched = Callable[[Sequence[Any]], Iterable[Any]]
"""Passes on a sequence item by item, and may show the progress."""
Planned = tuple[str, Plan]


@dataclass(frozen=True, eq=False)
class Offer:
    """A run on offer.

    Attributes:
        name: Name in messages, such as "a swept sine".
        recording: Simulated recording of the planned motion, or an existing recording.
        plan: The motion; None for an existing recording.
        request: Sentence on what a person has to do first; empty for nothing.
        setup: Time for this preparation [s].
        warm: Whether the arm has to be warm.
    """

    name: str
    recording: Recording
    plan: Plan | None = None
    request: str = ""
    setup: float = 0.0
    warm: bool = False

    @property
    def payload(self) -> KnownPayload | None:
        """Payload of the run."""
        return self.recording.payload

    @property
    def motion(self) -> float:
        """Duration of the motion [s]."""
        return float(self.recording.duration if self.plan is None else self.plan.trajectory.duration)

    @property
    def seconds(self) -> float:
        """Duration including preparation [s]."""
        return self.motion + self.setup


def kinds_of_run(
    model: Model, wishes: Wishes, said: Callable[[str], None], joint: int | None = None
) -> Iterator[Planned]:
    """A run of each rule-based kind, of all joints, or of one in kinds in which joints move one by one.

    Kinds that the arm cannot run are skipped and reported.
    """
    whose = "a run" if joint is None else f"a run of {model.robot.joints[joint]} alone,"
    for kind in KINDS if joint is None else ONE_BY_ONE:
        try:
            yield (
                f"{whose} of the kind {kind}",
                by_rule(kind, model, wishes, () if joint is None else (joint,)),
            )
        except ExidynError as error:
            said(f"no run of the kind {kind}: {error}")


def kinds_with_body(model: Model, wishes: Wishes, kind: str) -> Iterator[Plan]:
    """Runs of a kind for an arm with a payload, over decreasing shares of every joint's range.

    Near the ends of the joint ranges the arm is stretched out, and a payload may need more torque than the
    drives have.
    """
    for share in RANGES:
        try:
            yield for_robot(by_rule(kind, _narrower(model, share), wishes), model)
        except ExidynError:
            continue


def _narrower(model: Model, share: float) -> Model:
    """The arm with a share of the range of each joint, about the middle."""
    limits = model.robot.limits
    middle = 0.5 * (limits.position_upper + limits.position_lower)
    half = 0.5 * share * (limits.position_upper - limits.position_lower)
    limits = replace(limits, position_lower=middle - half, position_upper=middle + half)
    return replace(model, robot=replace(model.robot, limits=limits))


def for_robot(planned: Plan, model: Model) -> Plan:
    """The plan with the robot and limits of this arm, against which it will be checked."""
    for_arm = Plan.of(planned.trajectory, model)
    names = ("robot", "robot_hash", "model_hash", "limits")
    return replace(planned, **{name: getattr(for_arm, name) for name in names})


def excitation(
    model: Model,
    wishes: Wishes,
    fit: Fit | None,
    seed: int,
    seconds: float,
    body: KnownPayload | None = None,
) -> Planned:
    """The run that `exidyn excite` plans, after a fit if there is one.

    With a payload, the run keeps to the limits of the loaded arm.
    """
    name = EXCITATIONS[fit is not None]
    options = replace(wishes, fit=fit, bodies=() if body is None else (body.known,))
    return name, plan(model, options, seed=seed, starts=1, seconds=seconds)[0]


def distinguishing(
    model: Model, diagnosis: Diagnosis, wishes: Wishes, seed: int, seconds: float
) -> Iterator[Planned]:
    """The run that `exidyn excite --against` plans for the least certain finding, if models of both exist."""
    improved, findings = found_model(diagnosis), (*diagnosis.findings, *diagnosis.undecided)
    pairs = sorted(rivals(diagnosis), key=lambda rival: findings[rival.finding].probability)
    if improved is None or not pairs or pairs[0].left_out:
        return
    rival, finding = pairs[0], findings[pairs[0].finding]
    other = finding.alternatives[rival.alternative].effect
    names = [effect_words(finding.effect), f"{effect_words(other)} instead"]
    limits, _ = usable(improved.robot, wishes.margins, wishes.window, wishes.start)
    goal = two_models((improved, rival.model), names, limits, rows_of(wishes))
    words = f"the excitation that best distinguishes {names[0]} from {effect_words(other)}"
    planned = plan(improved, wishes, goal=goal, seed=seed, starts=1, seconds=seconds)[0]
    yield words, for_robot(planned, model)


def offers_of(
    model: Model,
    planned: Sequence[Planned],
    loaded: Sequence[Planned],
    body: KnownPayload | None,
    mounted: KnownPayload | None,
    rate: float,
    warm: bool,
    watched: Watched = iter,
) -> list[Offer]:
    """Offers of every planned run, without and with a payload, and with a warm arm.

    Args:
        model: Nominal model.
        planned: Names and plans of runs without a payload.
        loaded: Names and plans of runs with the payload; empty without one.
        body: Payload that is available; None for none.
        mounted: Payload that is mounted now.
        rate: Sampling rate [Hz].
        warm: Whether temperatures are recorded.
        watched: Passes on the runs one by one, and may show the progress.
    """
    temperature = TEMPERATURE if warm else None
    variants = [(*run, None, temperature) for run in planned] + [(*run, body, temperature) for run in loaded]
    if warm:
        variants += [(*run, mounted, WARM) for run in (planned if mounted is None else loaded)]
    return [
        offered(model, name, motion, carried, mounted, rate, temperature)
        for name, motion, carried, temperature in watched(variants)
    ]


def offered(
    model: Model,
    name: str,
    motion: Plan,
    carried: KnownPayload | None,
    mounted: KnownPayload | None,
    rate: float = 500.0,
    temperature: float | None = None,
) -> Offer:
    """Offer of a planned motion with a payload and the arm's temperature [degC], if recorded."""
    request, setup, words = "", 0.0, name
    if carried != mounted:
        request, setup = _request(carried), HANDLING
    if carried is not None:
        words = f"{words}, with {dict(carried.known)['M']:g} kg on the flange"
    warm = temperature == WARM
    if warm:
        request, setup, words = WARM_UP, WARMING, f"{words}, with a warm arm"
    return Offer(words, _simulated(model, motion, carried, rate, temperature), motion, request, setup, warm)


def _request(carried: KnownPayload | None) -> str:
    if carried is None:
        return "Remove the payload from the flange"
    known = dict(carried.known)
    first_moment = [known.get(name) for name in ("MX", "MY", "MZ")]
    text = f"Mount the payload of {known['M']:g} kg on the flange"
    if None in first_moment:
        return text
    place = ", ".join(f"{moment / known['M']:.4g}" for moment in first_moment if moment is not None)
    return f"{text}, with its center of mass at ({place}) m along the flange's x, y and z axes"


def _simulated(
    model: Model, motion: Plan, carried: KnownPayload | None, rate: float, temperature: float | None
) -> Recording:
    """Simulated recording of the motion by the nominal model."""
    loaded = model if carried is None else model + Payload(carried.name, carried.known)
    states = motion.trajectory.every(1.0 / rate).motion()
    recording = simulate(
        loaded,
        loaded.nominal_values,
        model.robot.drive_gain,
        states,
        model,
        payload=carried,
        name=motion.robot,
    )
    if temperature is None:
        return recording
    still = Signal(states.time, np.full(states.position.shape, temperature))
    return replace(recording, signals={**recording.signals, "temperature": still})
