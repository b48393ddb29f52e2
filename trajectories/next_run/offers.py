"""Offers: the runs that an arm could make next, planned, and what each asks of a person."""

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
"""What a person takes to hang a body on a flange, or to take it off [s]."""
TEMPERATURE, WARM = 25.0, 45.0
"""At which runs on offer are foreseen where temperatures are recorded [degC]: of a cold arm, and of one that
has worked for some time."""
WARMING = 1800.0
"""What an arm takes to warm up, as long as its gears remember [s]."""
EXCITATIONS = ("an excitation", "an excitation where the fit knows least")
"""Names of those that `exidyn excite` plans, before and after a fit."""
ONE_BY_ONE = ("sweeps", "single-joint")
"""Kinds of run in which joints move one after the other."""
RANGES = (1.0, 0.75, 0.5, 0.25)
"""Shares of the joints' ranges that are tried with a body on the flange [-]."""
WARM_UP = "Let the arm work until it is warm, for half an hour or so"
"""The request of a run with a warm arm."""

Watched = Callable[[Sequence[Any]], Iterable[Any]]
"""Hands on what is to be done one by one."""
Planned = tuple[str, Plan]


@dataclass(frozen=True, eq=False)
class Offer:
    """A run on offer.

    Attributes:
        name: What people call it, as "a swept sine" is.
        recording: Recording of the planned motion as the arm so far known would make it, or one that exists.
        plan: The motion; None for a recording that exists.
        request: What a person has to do before, in a sentence; empty for nothing.
        setup: Time that this takes [s].
    """

    name: str
    recording: Recording
    plan: Plan | None = None
    request: str = ""
    setup: float = 0.0

    @property
    def payload(self) -> KnownPayload | None:
        """What hangs on the flange."""
        return self.recording.payload

    @property
    def motion(self) -> float:
        """How long the arm moves [s]."""
        return float(self.recording.duration if self.plan is None else self.plan.trajectory.duration)

    @property
    def seconds(self) -> float:
        """How long it takes, a person's part included [s]."""
        return self.motion + self.setup


def kinds_of_run(model: Model, wishes: Wishes, said: Callable[[str], None]) -> Iterator[Planned]:
    """A run of each kind that is made by rule, of all joints; those that an arm cannot make are left out."""
    for kind in KINDS:
        try:
            yield f"a run of the kind {kind}", by_rule(kind, model, wishes)
        except ExidynError as error:
            said(f"no run of the kind {kind}: {error}")


def kinds_of_joint(
    model: Model, wishes: Wishes, joint: int, said: Callable[[str], None]
) -> Iterator[Planned]:
    """Runs of those kinds that move one joint after the other, of one joint alone."""
    for kind in ONE_BY_ONE:
        try:
            words = f"a run of {model.robot.joints[joint]} alone, of the kind {kind}"
            yield words, by_rule(kind, model, wishes, [joint])
        except ExidynError as error:
            said(f"no run of the kind {kind}: {error}")


def kinds_with_body(model: Model, wishes: Wishes, kind: str) -> Iterator[Plan]:
    """A run of a kind for an arm with a body on its flange, over less and less of every joint's range.

    Near the ends of their ranges arms stretch out, and a body asks for more torque than drives have.
    """
    for share in RANGES:
        try:
            yield for_robot(by_rule(kind, _narrower(model, share), wishes), model)
        except ExidynError:
            continue


def _narrower(model: Model, share: float) -> Model:
    """The same arm with so much of the range of each joint, about the middle."""
    limits = model.robot.limits
    middle = 0.5 * (limits.position_upper + limits.position_lower)
    half = 0.5 * share * (limits.position_upper - limits.position_lower)
    limits = replace(limits, position_lower=middle - half, position_upper=middle + half)
    return replace(model, robot=replace(model.robot, limits=limits))


def for_robot(planned: Plan, model: Model) -> Plan:
    """The plan as one for this arm, by whose limits it is to be checked, whatever it was planned for."""
    own = Plan.of(planned.trajectory, model)
    names = ("robot", "robot_hash", "model_hash", "limits")
    return replace(planned, **{name: getattr(own, name) for name in names})


def excitation(
    model: Model,
    wishes: Wishes,
    fit: Fit | None,
    seed: int,
    seconds: float,
    body: KnownPayload | None = None,
) -> Planned:
    """The run that `exidyn excite` plans, after a fit where that leaves values open.

    With a body it keeps to the limits of the arm that carries it.
    """
    name = EXCITATIONS[fit is not None]
    asked = replace(wishes, fit=fit, bodies=() if body is None else (body.known,))
    return name, plan(model, asked, seed=seed, starts=1, seconds=seconds)[0]


def distinguishing(
    model: Model, diagnosis: Diagnosis, wishes: Wishes, seed: int, seconds: float
) -> Iterator[Planned]:
    """The run that `exidyn excite --against` plans for the most open finding, where a model holds both."""
    found, every = found_model(diagnosis), (*diagnosis.findings, *diagnosis.undecided)
    pairs = sorted(rivals(diagnosis), key=lambda one: every[one.finding].probability)
    if found is None or not pairs or pairs[0].left_out:
        return
    rival, finding = pairs[0], every[pairs[0].finding]
    other = finding.alternatives[rival.alternative].effect
    names = [effect_words(finding.effect), f"{effect_words(other)} instead"]
    limits, _ = usable(found.robot, wishes.margins, wishes.window, wishes.start)
    goal = two_models((found, rival.model), names, limits, rows_of(wishes))
    words = f"the excitation that best distinguishes {names[0]} from {effect_words(other)}"
    planned = plan(found, wishes, goal=goal, seed=seed, starts=1, seconds=seconds)[0]
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
    """Every planned run, without and with a body on the flange, and with a warm arm.

    Args:
        model: Nominal.
        planned: Names and motions.
        loaded: The same with a body on the flange; none without one.
        body: That a person has; None for none.
        mounted: What hangs on the flange now.
        rate: Rate of samples [Hz].
        warm: Whether temperatures are recorded.
        watched: Hands on what is to be made one by one, and may show how far that is.
    """
    temperature = TEMPERATURE if warm else None
    every = [(*one, None, temperature) for one in planned] + [(*one, body, temperature) for one in loaded]
    if warm:
        every += [(*one, mounted, WARM) for one in (planned if mounted is None else loaded)]
    return [
        offered(model, name, motion, carried, mounted, rate, temperature)
        for name, motion, carried, temperature in watched(every)
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
    """A planned motion with what is to hang on the flange, and the arm's temperature [degC] if recorded."""
    request, setup, words = "", 0.0, name
    if carried != mounted:
        request, setup = _request(carried), HANDLING
    if carried is not None:
        words = f"{words}, with {dict(carried.known)['M']:g} kg on the flange"
    if temperature == WARM:
        request, setup, words = WARM_UP, WARMING, f"{words}, with a warm arm"
    return Offer(words, _foreseen(model, motion, carried, rate, temperature), motion, request, setup)


def _request(carried: KnownPayload | None) -> str:
    if carried is None:
        return "Take the body off the flange"
    known = dict(carried.known)
    centre = [known.get(name) for name in ("MX", "MY", "MZ")]
    text = f"Hang the body of {known['M']:g} kg on the flange"
    if None in centre:
        return text
    place = ", ".join(f"{one / known['M']:.4g}" for one in centre if one is not None)
    return f"{text}, turned so that its centre of mass is at ({place}) m of the flange's x, y and z axes"


def _foreseen(
    model: Model, motion: Plan, carried: KnownPayload | None, rate: float, temperature: float | None
) -> Recording:
    """The motion as the nominal arm makes it."""
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
