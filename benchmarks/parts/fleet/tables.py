"""Seasons of arms as tables of fit numbers, parameters with their intervals: what drift is found from.

A run is its unknowns, true but for noise, and the normal matrix of a real check run of the type. What makes
fleets hard is in them: scatter from run to run with heavy tails, offsets that scatter by a share of the arm's
own, seasons of 20 K, single runs out of line, files of another arm, tools, and arms that are exchanged.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from exidyn.identification.fleet.kind import Kind
from exidyn.identification.fleet.runs import Run
from exidyn.identification.fleet.summary import reduced

from .arms import BY_KELVIN, REFERENCE, Wear, arm
from .recordings import DAILY, OWN, PART, SEASON, SECONDS, START, WEEK
from .seasons import check_run

TAILS = 3.0
"""Degrees of freedom of Student's distribution of scatter: its variance is thrice its scale's square."""
FRICTION, GAIN, OFFSET = 0.0044, 0.0005, 0.15
"""Scale of that scatter: of friction, of drive gains, and of an offset over the arm's own offset [-]. The
middle half of the runs scatters as normal numbers of 0.5 % do, which `arms` has."""
OFFSETS = 0.15
"""Offset of a joint over its dry friction, standard deviation between arms [-]."""
NOISE = 0.01
"""Current noise over the usual current [-]."""
TOOL = {"cobot": 0.8, "kr270": 8.0}
"""Mass of a tool [kg]."""
REACH = 0.08
"""How far its centre is off the flange, for one of 0.8 kg [m]; as the cube root of the mass for others."""
ODD_FRICTION, ODD_GAIN = 0.2, 0.03
"""Deviations of a run that is out of line."""


class Event(NamedTuple):
    """What happens to an arm: a wear, or "tool", "exchange", "outlier", "stray"; and in which week."""

    what: Wear | str
    week: float


CREEP, STEP = 0.12, 0.1
EVENTS: dict[str, tuple[Wear | str, ...]] = {
    "cobot": (
        Wear("coulomb_friction", 3, ("Fc3",), CREEP, 8.0), "tool", "exchange", "outlier", "stray",
        Wear("drive_gain", 4, ("gain4",), -0.03), Wear("viscous_friction", 2, ("Fv2",), STEP),
        Wear("viscous_friction", 5, ("Fv5",), CREEP, 8.0), Wear("load_dependent_friction", 3, ("mu3",), 0.2),
        Wear("coulomb_friction", 6, ("Fc6",), CREEP, 8.0),
    ),
    "kr270": (
        Wear("spring_balancer", 2, ("Kr", "K0"), -0.05), "tool", "exchange", "outlier", "stray",
        Wear("coulomb_friction", 2, ("Fc2",), CREEP, 8.0), Wear("drive_gain", 1, ("gain1",), -0.03),
        Wear("coulomb_friction", 5, ("Fc5",), CREEP, 8.0), Wear("viscous_friction", 3, ("Fv3",), STEP),
        Wear("viscous_friction", 6, ("Fv6",), CREEP, 8.0),
    ),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Numbers:
    """Stands for a `Summary`: what a run says of the unknowns is given and linear."""

    precision: np.ndarray
    unknowns: np.ndarray
    temperature: np.ndarray
    payload: str
    known: bool = True
    seconds: float = SECONDS

    def normal(self, kind: Kind, values: np.ndarray, gain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As that of `Summary`."""
        return self.precision, self.precision @ self.unknowns


@lru_cache
def precision(kind: str, carries: bool) -> tuple[np.ndarray, np.ndarray]:
    """Normal matrix of a check run of the nominal arm, shape (m, m), and a root of its inverse."""
    own, random = check_run(kind, carries), np.random.default_rng(0)
    exact = own.equations.current
    noise = random.normal(size=own.prepared.current.shape) * NOISE * np.sqrt(np.mean(exact**2, axis=0))
    noisy = replace(own.equations, current=exact + own.prepared.decimation.apply(noise))
    said = reduced(noisy, np.full(exact.shape[1], REFERENCE), "", True, SECONDS)
    model = own.kind.model
    values = own.kind.base.regrouping @ model.nominal_values
    found = said.normal(own.kind, values, own.kind.gain)[0]
    size = 1.0 / np.sqrt(np.diag(found))
    scaled = np.linalg.cholesky(found * np.outer(size, size) + 1e-12 * np.eye(len(size)))
    return found, size[:, None] * np.linalg.inv(scaled).T


@dataclass(frozen=True, eq=False)
class Unit:
    """One arm: values by the names of the type's model, and drive gains over nominal."""

    names: list[str]
    values: np.ndarray
    gain: np.ndarray

    @classmethod
    def drawn(cls, kind: str, seed: int) -> "Unit":
        """A sound unit of a type."""
        built, model = arm(kind, seed), check_run(kind, False).kind.model
        random, given = (
            np.random.default_rng([seed, 7]),
            dict(zip(built.built.names, built.built.nominal_values, strict=True)),
        )
        for joint in range(1, model.robot.dof + 1):
            given[f"Off{joint}"] = OFFSETS * given[f"Fc{joint}"] * random.normal()
        values = np.array([given[name] for name in model.names])
        return cls(list(model.names), values, built.gain / model.robot.drive_gain)


def season(kind: str, name: str, seed: int, weeks: int, event: Event | None, other: int = -1) -> list[Run]:
    """Weekly runs of an arm; units are drawn by their seeds, `other` being that of which a stray file is."""
    random = np.random.default_rng([seed, len(kind), 1])
    own, new, stray = (Unit.drawn(kind, one) for one in (seed, seed + 50_000, max(other, 0)))
    found = []
    for week in range(weeks):
        unit = own
        if event is not None and event.what == "exchange" and week >= event.week:
            unit = new
        if event is not None and event.what == "stray" and week == event.week:
            unit = stray
        found.append(_run(kind, name, unit, week, event, random))
    return found


def _run(
    kind: str, name: str, unit: Unit, week: int, event: Event | None, random: np.random.Generator
) -> Run:
    own = check_run(kind, False).kind
    joints = own.model.robot.dof
    day = START + WEEK * week + random.uniform(0.2, 0.8)
    swing = SEASON * np.sin(2.0 * np.pi * (day - START) / (26.0 * WEEK) + hall(name))
    temperature = REFERENCE + swing + DAILY * random.normal() + OWN * random.normal(size=joints)
    values, gain = _scattered(unit, temperature, random)
    carries = bool(random.uniform() < 0.25)
    if event is not None:
        values, gain = _changed(unit, values, gain, event, (day - START) / WEEK, random)
    unknowns = np.append(own.base.regrouping @ values, np.log(gain))
    if event is not None and event.what == "tool" and week >= event.week:
        unknowns[:-joints] += own.body @ tool(TOOL[kind])
    exact, root = precision(kind, carries)
    unknowns = unknowns + root @ random.normal(size=len(unknowns))
    numbers = Numbers(exact, unknowns, temperature, PART.name if carries else "")
    return Run(f"{name} {week}", day, numbers)  # type: ignore[arg-type]


def hall(name: str) -> float:
    """When its season begins: arms stand in several halls."""
    return float(sum(name.encode()) % 7)


def _scattered(
    unit: Unit, temperature: np.ndarray, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    values, warm = unit.values.copy(), temperature - REFERENCE
    for place, name in enumerate(unit.names):
        if name[:2] in BY_KELVIN:
            by = BY_KELVIN[name[:2]] * warm[int(name[2:]) - 1]
            values[place] *= np.exp(-by) if name[:2] == "Fv" else 1.0 - by
        share = OFFSET if name.startswith("Off") else FRICTION if name[:2] in ("Fv", "Fc", "mu") else 0.0
        values[place] *= 1.0 + share * random.standard_t(TAILS)
    return values, unit.gain * (1.0 + GAIN * random.standard_t(TAILS, len(unit.gain)))


def _changed(
    unit: Unit, values: np.ndarray, gain: np.ndarray, event: Event, weeks: float, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    values, gain = values.copy(), gain.copy()
    if isinstance(event.what, Wear):
        share = event.what.at(weeks - event.week)
        for name in event.what.parameters:
            if name.startswith("gain"):
                gain[int(name[4:]) - 1] *= 1.0 + share
            else:
                values[unit.names.index(name)] *= 1.0 + share
    elif event.what == "outlier" and int(weeks) == event.week:
        rubbing = [name[:2] in ("Fv", "Fc", "mu") for name in unit.names]
        values[rubbing] *= 1.0 + ODD_FRICTION * random.normal(size=sum(rubbing))
        gain *= 1.0 + ODD_GAIN * random.normal(size=len(gain))
    return values, gain


def tool(mass: float) -> np.ndarray:
    """Its ten parameters about the flange, XX to M, off the axis."""
    off = REACH * np.cbrt(mass / TOOL["cobot"])
    centre = off * np.array([0.4, 0.2, 0.9])
    own = mass * 0.3 * off**2
    about = own * np.eye(3) + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    x, y, z = mass * centre
    return np.array(
        [about[0, 0], about[0, 1], about[0, 2], about[1, 1], about[1, 2], about[2, 2], x, y, z, mass]
    )
