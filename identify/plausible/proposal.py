"""Proposal of how to read a log: columns, units, order of joints, sign and size of drive gains."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ..model import Model
from ..recordings.effort_checks import unmeasured_words, unread
from ..recordings.misread_columns import unit_questions
from ..recordings.recording import EFFORT, Recording
from ..recordings.tables.column_names import MEASURED, STAMPS, Family, families, unit_of, words_of
from ..recordings.tables.preset import Reading
from ..recordings.units import COMMANDS
from ..text_table import digits
from .described_bodies import described
from .evidence import Reading as Evidence
from .gains import AGAINST, NOT_TORQUE, Gain, effort_odds, gain_guesses, gains
from .imported_log import Log, imported, in_log_units, likely_units, readings_of, rough_log
from .position_servos import BY_SERVO, error_of, only_commanded, servo_gains
from .proposed_units import Proposed, joint_odds, propose_units, stated_units
from .refusals import no_time, not_found, require_computable, require_measured
from .search import posterior
from .stated_units import (
    Stated,
    as_stated,
    fixed_units,
    in_si,
    permuted,
    require_used,
    unit_of_signal,
    with_stated,
)
from .suspicion import Guess
from .units import STATED, TIME, Units, affine, moves, quirks

FOLLOWS = 2.0
"""Maximum ratio of the motion of a command and of the joint that follows it, or the reverse."""
RISING = 0.99
"""Minimum share of the steps in which time increases; a clock may be set during a run."""
TRIALS = 2
"""Number of times a log is read, with units of its raw numbers, and then with those of its samples."""


@dataclass(frozen=True)
class Proposal:
    """Proposed interpretation of a log."""

    # "time" or signal of a recording -> its columns, one per joint in the robot's order, and their units.
    readings: Mapping[str, Reading]
    units: Units  # units of time, position and velocity; "" for a velocity that is left out
    gains: tuple[Gain, ...]  # drive gains if there are currents, else empty
    against: bool  # whether the torques have the opposite sign of the positions
    guesses: tuple[Guess, ...]  # guesses with their probabilities
    notes: tuple[str, ...]  # sentences on other observations
    # Gravity in the base frame, shape (3,) [m/s^2], if it certainly differs from the description; else empty.
    gravity: tuple[float, ...] = ()
    # Whether there are commands and no efforts; gains are then those of position servos [N m/rad].
    servo: bool = False

    @property
    def columns(self) -> dict[str, tuple[str, ...]]:
        """Names of the columns of "time" and each signal."""
        columns = {signal: reading.column for signal, reading in self.readings.items()}
        return {s: (names,) if isinstance(names, str) else tuple(names) for s, names in columns.items()}

    @property
    def open(self) -> list[Guess]:
        """Guesses that the log does not decide."""
        return [guess for guess in self.guesses if not guess.decided]

    def by_gains(self) -> "Proposal":
        """Proposal for a log without a preset: torques of opposite sign become currents with gains of -1."""
        if not self.against:
            return self
        renamed = {"torque": "current"}
        readings = {renamed.get(signal, signal): reading for signal, reading in self.readings.items()}
        turned = Gain(-1.0, 0.0, 0.0)
        return replace(self, readings=readings, gains=(turned,) * len(self.columns["torque"]), against=False)


class Meaning(NamedTuple):
    """Meaning of the columns of a log."""

    clock: int  # index of the time column
    chosen: dict[str, Family]  # signal -> its columns
    effort: str  # signal of the effort
    servo: bool  # whether the position error takes the place of an effort
    guesses: list[Guess]  # guesses with their probabilities
    unread: list[Family]  # other columns that may be positions, efforts or velocities


class Weighed(NamedTuple):
    """Samples of a log, and their most probable units, order and mounting."""

    runs: list[Recording]  # runs as import reads them with these units
    log: Log  # samples of all runs
    proposed: Proposed


def propose(
    names: Sequence[str],
    values: np.ndarray | list[np.ndarray],
    model: Model,
    joints: Sequence[str] = (),
    stated: Stated = MappingProxyType({}),
    source: str = "log",
) -> Proposal:
    """Propose how to read the columns of a log.

    Args:
        names: Names of the c columns.
        values: Values of the columns of one file or of several, shape (t, c); NaN for empty cells.
        model: Model of the described arm.
        joints: Names of the joints that numbers in the names stand for, if the log states them.
        stated: Units that are not to be guessed.
        source: Name of the log in messages.

    Raises:
        RecordingError: Time, positions or efforts cannot be identified, or import cannot read the log.
    """
    tables, robot = values if isinstance(values, list) else [values], model.robot
    meaning = _meaning(names, tables, model, joints)
    require_used(stated, list(meaning.chosen))
    runs, log, (units, order, reading, gravity, more, doubt, doubted, signs) = _weighed(
        names, tables, meaning, model, stated, source
    )
    scale, offset = affine(robot, units.position, log.values["position"])
    position, time = log.values["position"][:, order] * scale + offset, log.time * TIME[units.time]
    silent = unread(time, position, log.values[meaning.effort][:, order]) > 0.0
    if meaning.servo:
        signals, drives, of_efforts = servo_gains(meaning.chosen, reading)
    else:
        skipped = silent | np.isin(np.arange(robot.dof), doubted)
        signals, drives, of_efforts = _efforts(meaning.chosen, reading, meaning.effort, skipped)
    # Bodies show the unit of efforts, if the unit of positions is known.
    sure = next(guess.probability for guess in more if guess.what == "unit of position")
    sure = 1.0 if meaning.chosen["position"].unit or "position" in stated else sure
    of_efforts = [replace(guess, probability=min(guess.probability, sure)) for guess in of_efforts]
    if not units.velocity:
        signals.pop("velocity", None)
    astray = {} if meaning.servo else _astray(signals, log)
    guesses = [guess for guess in (*meaning.guesses, *more, *of_efforts) if guess.what not in astray]
    notes = quirks(time, position, robot)
    notes += dict.fromkeys(warning for run in runs for warning in run.warnings)
    notes += unit_questions(robot, log.values["position"][:, order], units.position)
    notes += [f"{signals[command].pattern} {reason}" for command, reason in astray.items()]
    if unused := [f.pattern for f in meaning.unread if f not in signals.values()]:
        notes.append(f"columns that are not read: {', '.join(unused)}")
    notes += [doubt] * bool(doubt) + [BY_SERVO] * meaning.servo
    columns = {s: tuple(f.names[k] for k in order) for s, f in signals.items() if s not in astray}
    columns = {"time": (names[meaning.clock],), **columns}
    readings = readings_of(columns, units, robot, log.values["position"], signs)
    return Proposal(
        with_stated(readings, permuted(stated, order)),
        units,
        drives,
        any(guess.value == AGAINST for guess in of_efforts),
        tuple(as_stated(guess, stated) for guess in guesses),
        tuple(notes),
        gravity,
        meaning.servo,
    )


def _meaning(
    names: Sequence[str], tables: Sequence[np.ndarray], model: Model, joints: Sequence[str]
) -> Meaning:
    """Meaning of the columns, by their names or else by their motion."""
    robot, clock, values = model.robot, _time(names, tables[0]), np.concatenate(tables)
    groups = [f for f in families(names, robot.joints, joints) if clock not in f.places]
    groups = [f for f in groups if f.signal not in EFFORT or not _are_flags(values[:, f.places])]
    places = {place for f in groups if f.signal != "other" for place in f.places}
    require_computable(names, values, sorted({clock, *places}))
    chosen, guesses, unnamed = _signals(groups)
    silent = [s for s in EFFORT if s in chosen and unmeasured_words(values[:, chosen[s].places])]
    if len(silent) == 1 and {*EFFORT} <= {*chosen}:  # as import does
        del chosen[silent[0]]
        guesses = [guess for guess in guesses if guess.what != silent[0]]
    servo = only_commanded(chosen)
    if not servo:
        chosen, by_motion = _by_motion(chosen, unnamed, max(tables, key=len), clock, model)
        guesses += by_motion
    if "position" not in chosen:
        raise not_found("position", ("position",), names, robot)
    effort = next((signal for signal in EFFORT if signal in chosen), "")
    if not effort and not servo:
        raise not_found("current or torque", EFFORT, names, robot)
    others = [family for family in groups if family.signal in ("", "velocity")]
    return Meaning(clock, chosen, effort or EFFORT[0], servo, guesses, others)


def _weighed(
    names: Sequence[str],
    tables: Sequence[np.ndarray],
    meaning: Meaning,
    model: Model,
    stated: Stated,
    source: str,
) -> Weighed:
    """Samples with the units that are probable for the raw numbers, or else for these samples."""
    robot, clock, chosen = model.robot, meaning.clock, meaning.chosen
    columns = {"time": (names[clock],), **{signal: family.names for signal, family in chosen.items()}}
    used = {name: family for name, family in chosen.items() if name in ("position", "velocity", *EFFORT)}
    rough = in_si(rough_log(max(tables, key=len), clock, used), stated, robot)
    hints = stated_units(chosen, unit_of(f"time {names[clock]}"))
    fixed = fixed_units(stated, robot)
    units = likely_units(rough, robot, hints, fixed)
    if meaning.servo:
        chosen = chosen | {"current": error_of(chosen["position"])}
    position = np.concatenate(tables)[:, chosen["position"].places]
    for _ in range(TRIALS):
        guessed = readings_of(columns, units, robot, position)
        runs = imported(names, tables, with_stated(guessed, stated), model, source)
        log = in_log_units(
            runs, {s: r for s, r in guessed.items() if unit_of_signal(stated, s) is None}, units
        )
        require_measured(log.values[meaning.effort], chosen[meaning.effort].pattern)
        proposed = propose_units(log, model, chosen, hints, fixed)
        if proposed.units[:2] == units[:2]:
            break
        units = proposed.units._replace(velocity=proposed.units.velocity or units.velocity)
    return Weighed(runs, log, proposed)


def _astray(chosen: Mapping[str, Family], log: Log) -> dict[str, str]:
    """Commands that the measured signal does not follow, perhaps for their unit -> end of a note."""
    reasons = {}
    for command, signal in COMMANDS.items():
        if command in log.values and signal in chosen:
            stds = (np.nanstd(log.values[name], axis=0) for name in (command, signal))
            commanded, measured = (float(np.linalg.norm(std)) for std in stds)
            if not 1 / FOLLOWS < commanded / max(measured, 1e-12) < FOLLOWS:
                share = digits(commanded / max(measured, 1e-12))
                reasons[command] = f"is left out: it moves {share} times as far as the measured {signal}"
    return reasons


def _time(names: Sequence[str], values: np.ndarray) -> int:
    """Index of the time column: one with such a name, else the only one that always increases."""
    steps = np.diff(values, axis=0)
    rising = np.flatnonzero(np.sum(steps > 0, axis=0) > RISING * len(steps)).tolist()
    stamps = [k for k in range(len(names)) if STAMPS.intersection(words_of(names[k]))]
    # Import says what is wrong with stamps that do not increase.
    steady = [k for k in stamps if np.sum(steps[:, k] >= 0) > RISING * len(steps)]
    called = [k for k in stamps if k in rising] or steady or stamps
    candidates = called[:1] or rising
    if len(candidates) != 1:
        raise no_time(len(rising))
    return candidates[0]


def _are_flags(values: np.ndarray) -> bool:
    """Whether columns (t, n) are flags, such as motor on or off: only 0 and 1, and not all 0."""
    known = values[np.isfinite(values)]
    return set(np.unique(known).tolist()) in ({1.0}, {0.0, 1.0})


def _signals(groups: Sequence[Family]) -> tuple[dict[str, Family], list[Guess], list[Family]]:
    """Families by the signal that their names state, guesses, and families with uninformative names."""
    chosen, guesses = {}, []
    for signal in {family.signal: None for family in groups if family.signal not in ("", "other")}:
        candidates = [family for family in groups if family.signal == signal]
        best = [
            family for family in candidates if MEASURED.intersection(words_of(family.pattern))
        ] or candidates
        if len(best) == 1 or signal in ("position", *EFFORT):
            chosen[signal] = best[0]
            option = f"[{signal}] column in a preset"
            guesses.append(Guess(signal, best[0].pattern, STATED / len(best), "its name", option))
    return chosen, guesses, [family for family in groups if family.signal == ""]


def _by_motion(
    chosen: dict[str, Family], unnamed: Sequence[Family], values: np.ndarray, clock: int, model: Model
) -> tuple[dict[str, Family], list[Guess]]:
    """Choose positions and efforts without informative names: the pair that rigid bodies explain best."""
    effort = next((signal for signal in EFFORT if signal in chosen), "")
    if "position" in chosen and effort:
        return chosen, []
    rough = rough_log(values, clock, {f.pattern: f for f in (*chosen.values(), *unnamed)})
    time, columns = rough.time, {f: rough.values[f.pattern] for f in (*chosen.values(), *unnamed)}
    positions = [chosen["position"]] if "position" in chosen else list(unnamed)
    efforts = [chosen[effort]] if effort else list(unnamed)
    odds: dict[tuple[Family, Family], float] = {}
    for a in positions:
        for b in efforts:
            if a is not b and not any(_is_rate(time, columns[x], columns[y]) for x, y in ((a, b), (b, a))):
                log = Log(time, {"position": columns[a], "current": columns[b]})
                odds[a, b] = max(joint_odds(log, model, Units("", a.unit, "")).values())
    if not odds:
        return chosen, []
    likely = posterior(odds)
    (a, b), probability = next(iter(likely.items()))
    option = "[position] and [current] column in a preset"
    why = "bodies explain it"
    guesses = [Guess("position", a.pattern, probability, why, option)] if "position" not in chosen else []
    guesses += [Guess("current", b.pattern, probability, why, option)] if not effort else []
    new = {"position": a} | ({} if effort else {"current": b})
    rate = next((f for f in unnamed if f not in (a, b) and _is_rate(time, columns[a], columns[f])), None)
    if rate and "velocity" not in chosen:
        new["velocity"] = rate
        guesses.append(
            Guess("velocity", rate.pattern, STATED, "derivative of position", "[velocity] column in a preset")
        )
    return {**chosen, **new}, guesses


def _is_rate(time: np.ndarray, position: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.isfinite(moves(time, position, other).ratio))


def _efforts(
    chosen: Mapping[str, Family], reading: Evidence, effort: str, silent: np.ndarray
) -> tuple[dict[str, Family], tuple[Gain, ...], list[Guess]]:
    """Signals with efforts as torque or current, gains unless efforts are joint torques, and guesses.

    `silent` (n,) marks joints whose effort is not measured, or may be that of another joint.
    """
    family, robot = chosen[effort], reading.model.robot
    drives = [Gain() if skip else gain for gain, skip in zip(gains(reading), silent, strict=True)]
    likely = posterior(effort_odds(drives, family.signal))
    value, probability = next(iter(likely.items()))
    why = "described bodies" if described(robot) else "its name; no real masses"
    guesses = [Guess(f"unit of {family.pattern}", value, probability, why, "[drive] gain in robot.toml")]
    others = {signal: f for signal, f in chosen.items() if signal not in EFFORT}
    if value != NOT_TORQUE:
        return {**others, "torque": family}, (), guesses
    guesses += gain_guesses(robot.joints, drives)
    return {**others, "current": family}, tuple(drives), guesses
