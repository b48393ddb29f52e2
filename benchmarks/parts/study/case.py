"""Cases: an arm that is not what is stated of it, and what may be said of it."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from exidyn.acquire.run.simulated import simulated
from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.model import Model
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.simulation.plant import Transmission
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import read_plan

from .arms import EFFECTS, KNOWN, Concealed, concealed, nominal, truth

BODY = KnownPayload("L", known_parameters(3.0, (0.05, 0.0, 0.02), (0.02, 0.0, 0.0, 0.02, 0.0, 0.02)))
WISHES, SHORT = Wishes(seconds=16.0, tick=0.004), Wishes(seconds=8.0, tick=0.004)
"""Of a whole excitation, and of a short one, as those of a study are."""
WRONG = (1.18, 1.20)
"""True over stated gains where these are wrong; their tolerances are `KNOWN`."""
ASIDE = 0.05
"""How far the base leans, or the shoulder's zero is off, about the shoulder's axis [rad]."""
LEANS = frozenset({("base_tilt", ()), ("encoder_offset", (1,))})
"""One about the axis of the other: no torque tells which."""

Named = frozenset[tuple[str, tuple[int, ...]]]
"""Effects, each with its joints from 1."""


def named(every: Iterable[tuple[str, Iterable[int]]]) -> Named:
    """Effects and joints."""
    return frozenset((effect, tuple(joints)) for effect, joints in every)


@dataclass(frozen=True)
class Case:
    """An arm.

    Attributes:
        kind: What is wrong with it, in a word, as in `KINDS`.
        seed: Of its noise and of what was drawn.
        parts: Effects that the nominal model does not have.
        gain: True over stated drive gains.
        lean: Of the base [rad].
        zero: Of the shoulder's encoder [rad].
        free: Whether masses are not stated.
    """

    kind: str
    seed: int
    parts: tuple[Concealed, ...] = ()
    gain: tuple[float, float] = (1.0, 1.0)
    lean: float = 0.0
    zero: float = 0.0
    free: bool = False

    @classmethod
    def drawn(cls, kind: str, seed: int) -> "Case":
        """One of a kind; gains are off by what is stated, everywhere."""
        random = np.random.default_rng(seed)
        count, more = KINDS[kind]
        names = random.choice(EFFECTS, count, replace=False)
        parts = tuple(
            concealed(str(name), int(random.integers(2)), float(random.uniform(0.7, 1.5))) for name in names
        )
        gain = tuple(float(one) for one in 1.0 + KNOWN * random.uniform(-1.0, 1.0, 2))
        return cls(kind, seed, parts, **{"gain": gain} | more)

    @property
    def concealed(self) -> Named:
        """What is there and can be told."""
        gains = {("drive_gain", (1,)), ("drive_gain", (2,))} if self.gain == WRONG else set()
        return named((part.name, (part.joint + 1,)) for part in self.parts) | gains

    @property
    def alike(self) -> Named:
        """Of which one is there, and no motion tells which."""
        return LEANS if self.lean or self.zero else frozenset()

    @property
    def nominal(self) -> Model:
        """The arm as it is stated."""
        model = nominal()
        return replace(model, robot=replace(model.robot, inertias_stated=not self.free))

    @property
    def truth(self) -> tuple[Model, Transmission]:
        """The arm as it is."""
        model, gears = truth(self.parts)
        kinematics = model.robot.kinematics.copy()
        kinematics.gravity = pin.Motion(
            pin.utils.rotate("y", self.lean) @ kinematics.gravity.linear, np.zeros(3)
        )
        gain = model.robot.drive_gain * np.array(self.gain)
        return replace(model, robot=replace(model.robot, kinematics=kinematics, drive_gain=gain)), gears

    def run(self, plan: Plan, body: KnownPayload | None, name: str) -> Recording:
        """A run of the true arm; without second encoders, which would measure the gears."""
        model, gears = self.truth
        loaded = model if body is None else model + Payload(body.name, body.known)
        recording = simulated(model, plan, loaded, body, gears, tick=WISHES.tick, seed=self.seed, name=name)
        signals = {name: one for name, one in recording.signals.items() if name != "link_position"}
        read = signals["position"].values + np.array([self.zero, 0.0])
        signals["position"] = replace(signals["position"], values=read)
        return replace(recording, model=self.nominal, signals=signals)

    def record(self, plan: Path, path: Path, body: KnownPayload | None) -> None:
        """The same, into a file, as fast as it computes."""
        write_recording(self.run(read_plan(plan), body, path.parent.name), path)


KINDS: dict[str, tuple[int, dict[str, object]]] = {
    "nothing": (0, {}),
    "nothing, masses not stated": (0, {"free": True}),
    "one effect": (1, {}),
    "one effect, masses not stated": (1, {"free": True}),
    "two effects": (2, {}),
    "gains": (0, {"gain": WRONG}),
    "gains, masses not stated": (0, {"gain": WRONG, "free": True}),
    "a base that leans": (0, {"lean": ASIDE}),
    "a shoulder's zero": (0, {"zero": ASIDE}),
}
"""Name -> number of effects, and what else is not as stated."""
SCORED = (
    *("nothing", "nothing, masses not stated"),
    *("one effect",) * 3,
    "one effect, masses not stated",
    *("two effects",) * 2,
    *("gains", "gains, masses not stated", "a base that leans", "a shoulder's zero"),
)
"""Kinds of the arms on which study and programme are compared."""
OTHERS = ("nothing, masses not stated", "one effect", "one effect", "two effects", "gains, masses not stated")
"""Kinds of the arms on which the best programme is searched."""
FIRST, OTHER = 100, 900
"""Seed of the first of each."""


def scored() -> list[Case]:
    """Those that are compared."""
    return [Case.drawn(kind, FIRST + place) for place, kind in enumerate(SCORED)]


def others() -> list[Case]:
    """Those on which programmes are searched."""
    return [Case.drawn(kind, OTHER + place) for place, kind in enumerate(OTHERS)]
