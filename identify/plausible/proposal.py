"""Proposal of how to read a log: columns, units, order of joints, sign and size of drive gains."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import RecordingError
from ..model import Model
from ..recordings.arrival_times import regular_clock
from ..recordings.effort_checks import NO_MOTOR, UNMEASURED, unread
from ..recordings.recording import EFFORT
from ..recordings.restored_columns import signed, unwrapped
from ..recordings.separate_runs import beginnings
from ..recordings.tables.column_names import MEASURED, STAMPS, Family, families, unit_of, words_of
from ..recordings.units import COMMANDS
from ..recordings.wrong_unit import unit_questions
from ..text_table import digits
from .described_bodies import described
from .evidence import Reading
from .gains import AGAINST, NOT_TORQUE, Gain, effort_odds, gain_guesses, gains
from .position_servos import BY_SERVO, only_commanded, servo_gains, with_error
from .proposed_units import Log, joint_odds, propose_units
from .refusals import has_few_digits, no_time, not_found, require_computable, require_measured
from .samples import LONG, runs_of
from .suspicion import Guess
from .units import STATED, TIME, Units, affine, moves, quirks
from .weigh import posterior

FOLLOWS = 2.0
"""Maximum ratio of the motion of a command and of the joint that follows it, or the reverse."""
FEWEST = 100
"""Minimum number of samples of a run."""


@dataclass(frozen=True)
class Proposal:
    """Proposed interpretation of a log."""

    # "time" or signal of a recording -> names of its columns, one per joint in the robot's order.
    columns: Mapping[str, tuple[str, ...]]
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
    def open(self) -> list[Guess]:
        """Guesses that the log does not decide."""
        return [guess for guess in self.guesses if not guess.decided]

    def by_gains(self) -> "Proposal":
        """Proposal for a log without a preset: torques of opposite sign become currents with gains of -1."""
        if not self.against:
            return self
        renamed = {"torque": "current"}
        columns = {renamed.get(signal, signal): names for signal, names in self.columns.items()}
        turned = Gain(-1.0, 0.0, 0.0)
        return replace(self, columns=columns, gains=(turned,) * len(columns["current"]), against=False)


def propose(names: Sequence[str], values: np.ndarray, model: Model, joints: Sequence[str] = ()) -> Proposal:
    """Propose how to read the columns of a log.

    Args:
        names: Names of the c columns.
        values: Values of the columns, shape (t, c); NaN for empty cells.
        model: Model of the described arm.
        joints: Names of the joints that numbers in the names stand for, if the log states them.

    Raises:
        RecordingError: Time, positions or efforts cannot be identified.
    """
    robot, clock = model.robot, _time(names, values)
    values, clock_notes = _continuing(names, values, clock)
    groups = [f for f in families(names, robot.joints, joints) if clock not in f.places]
    groups = [f for f in groups if f.signal not in EFFORT or not _are_flags(values[:, f.places])]
    chosen, guesses, unnamed = _signals(groups)
    read = [f for f in groups if f.signal != "other"]
    if servo := only_commanded(chosen):
        names, values, chosen = with_error(names, values, chosen)
        read.append(chosen["current"])
    require_computable(names, values, sorted({clock, *(place for family in read for place in family.places)}))
    usable = _usable(values, clock, read)
    time = values[usable, clock]
    chosen, by_motion = _by_motion(chosen, unnamed, values[usable], time, model)
    guesses += by_motion
    if "position" not in chosen:
        raise not_found("position", ("position",), names, robot)
    values, restored = _restored(chosen, values)
    effort = next((signal for signal in EFFORT if signal in chosen), "")
    if not effort:
        raise not_found("current or torque", EFFORT, names, robot)
    log = Log(time, {signal: values[usable][:, family.places] for signal, family in chosen.items()})
    clock_unit = unit_of(f"time {names[clock]}")
    # The clock does not continue between concatenated runs.
    if len(runs_of(time)) == 1 and (regular := regular_clock(time, log.values["position"])):
        clock_notes.append(
            f"{regular.description}: import replaces them by a regular clock" * regular.certain
        )
        log = replace(log, time=regular.time) if regular.certain else log
    require_measured(log.values[effort], chosen[effort].pattern)
    units, order, reading, gravity, more, doubt, doubted = propose_units(log, model, chosen, clock_unit)
    guesses += more
    scale, offset = affine(robot, units.position, log.values["position"])
    position = log.values["position"][:, order] * scale + offset
    time = log.time * TIME[units.time]
    silent = unread(time, position, log.values[effort][:, order])
    if servo:
        signals, drives, more = servo_gains(chosen, reading, scale)
    else:
        signals, drives, more = _efforts(
            chosen, reading, effort, (silent > 0.0) | np.isin(np.arange(robot.dof), doubted)
        )
    if not units.velocity:
        signals.pop("velocity", None)
    astray = _astray(signals, values[usable])
    guesses = [guess for guess in guesses if guess.what not in astray]
    columns = {s: tuple(f.names[k] for k in order) for s, f in signals.items() if s not in astray}
    notes = quirks(time, position, robot, len(values))
    notes += filter(None, clock_notes)
    notes += unit_questions(robot, log.values["position"][:, order], units.position)
    if silent.any():
        unmeasured = [f"{robot.joints[j]} in {100 * silent[j]:.0f} %" for j in np.flatnonzero(silent)]
        notes.append(f"{UNMEASURED}: {', '.join(unmeasured)}")
    if effortless := [robot.joints[j] for j in np.flatnonzero(~log.values[effort][:, order].any(axis=0))]:
        notes.append(f"no effort at all: {', '.join(effortless)}. Without a motor: {NO_MOTOR}")
    notes += [f"{signals[command].pattern} {reason}" for command, reason in astray.items()]
    if unused := [f.pattern for f in groups if f.signal in ("", "velocity") and f not in signals.values()]:
        notes.append(f"columns that are not read: {', '.join(unused)}")
    notes += restored
    notes += [doubt] * bool(doubt)
    if servo:
        notes.append(BY_SERVO)
    against = any(guess.value == AGAINST for guess in more)
    columns = {"time": (names[clock],), **columns}
    return Proposal(columns, units, drives, against, (*guesses, *more), tuple(notes), gravity, servo)


def _restored(chosen: Mapping[str, Family], values: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Values (t, c) with restored turns and signs that the log had lost, and notes."""
    restored, notes = np.array(values), []
    for signal, family in chosen.items():
        for name, place in zip(family.names, family.places, strict=True):
            column, better = values[:, place], None
            if signal == "position":
                better = unwrapped(column) or unwrapped(column, 360.0)
            elif signal in EFFORT:
                better = signed(column)
            if better is not None:
                restored[:, place] = better.values
                notes.append(f"{name} {better.fact}")
    return restored, notes


def _astray(chosen: Mapping[str, Family], values: np.ndarray) -> dict[str, str]:
    """Commands that the measured signal does not follow, perhaps for their unit -> end of a note."""
    reasons = {}
    for command, signal in COMMANDS.items():
        if command in chosen and signal in chosen:
            stds = (np.nanstd(values[:, chosen[name].places], axis=0) for name in (command, signal))
            commanded, measured = (float(np.linalg.norm(std)) for std in stds)
            if not 1 / FOLLOWS < commanded / max(measured, 1e-12) < FOLLOWS:
                share = digits(commanded / max(measured, 1e-12))
                reasons[command] = f"is left out: it moves {share} times as far as the measured {signal}"
    return reasons


def one_after_another(names: Sequence[str], tables: Sequence[np.ndarray]) -> np.ndarray:
    """Concatenate tables (t, c) with the same columns; time continues with a gap between them.

    Raises:
        RecordingError: There is no column of time.
    """
    clock, parts = _time(names, tables[0]), [tables[0]]
    # The gap is long for the median step of all tables, which is at most that of the slowest one.
    gap = 2.0 * LONG * max(float(np.nanmedian(np.diff(table[:, clock]))) for table in tables)
    for table in tables[1:]:
        later = table.copy()
        later[:, clock] += np.nanmax(parts[-1][:, clock]) + gap - np.nanmin(table[:, clock])
        parts.append(later)
    return np.concatenate(parts)


def _continuing(names: Sequence[str], values: np.ndarray, clock: int) -> tuple[np.ndarray, list[str]]:
    """Values (t, c) with continuing time if a recorder appended several runs, and notes."""
    rows = [row for row, _ in beginnings(values[:, clock], np.delete(values, clock, axis=1))]
    if not rows or min(np.diff([0, *rows, len(values)])) < FEWEST:
        return values, []
    where = ", ".join(str(row + 1) for row in rows)
    note = f"{len(rows) + 1} runs follow each other, from row {where}: import writes a recording of each"
    return one_after_another(names, np.split(values, rows)), [note]


def _time(names: Sequence[str], values: np.ndarray) -> int:
    """Index of the time column: one with such a name, else the only one that always increases."""
    rising = [k for k in range(len(names)) if np.mean(np.diff(values[:, k]) > 0) > 0.99]
    stamps = [k for k in range(len(names)) if STAMPS.intersection(words_of(names[k]))]
    called = [k for k in stamps if k in rising] or [k for k in stamps if has_few_digits(values, k)]
    candidates = called or rising
    if not candidates or (len(candidates) > 1 and not called):
        raise no_time(names, values, len(rising))
    return candidates[0]


def _usable(values: np.ndarray, clock: int, read: Sequence[Family]) -> np.ndarray:
    """Rows in which time increases and positions and efforts are numbers."""
    mostly_known = np.isfinite(values).mean(axis=0) > 0.5
    known = [p for f in read for p in f.places if mostly_known[p] and f.signal in ("", "position", *EFFORT)]
    rows = np.flatnonzero(np.isfinite(values[:, [clock, *known]]).all(axis=1))
    later = np.maximum.accumulate(values[rows, clock])
    rising = rows[np.concatenate([[True], np.diff(later) > 0])] if len(rows) else rows
    runs = runs_of(values[rising, clock]) if len(rising) > 1 else []
    long = [rising[run] for run in runs if run.stop - run.start >= FEWEST]
    if not long:
        raise RecordingError(f"{len(rising)} samples with time, positions and efforts; {FEWEST} are needed")
    return np.concatenate(long)


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
    chosen: dict[str, Family], unnamed: Sequence[Family], values: np.ndarray, time: np.ndarray, model: Model
) -> tuple[dict[str, Family], list[Guess]]:
    """Choose positions and efforts without informative names: the pair that rigid bodies explain best."""
    effort = next((signal for signal in EFFORT if signal in chosen), "")
    if "position" in chosen and effort:
        return chosen, []
    positions = [chosen["position"]] if "position" in chosen else list(unnamed)
    efforts = [chosen[effort]] if effort else list(unnamed)
    odds: dict[tuple[Family, Family], float] = {}
    for a in positions:
        for b in efforts:
            if a is not b and not _is_rate(values, time, a, b) and not _is_rate(values, time, b, a):
                log = Log(time, {"position": values[:, a.places], "current": values[:, b.places]})
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
    rate = next((f for f in unnamed if f not in (a, b) and _is_rate(values, time, a, f)), None)
    if rate and "velocity" not in chosen:
        new["velocity"] = rate
        guesses.append(
            Guess("velocity", rate.pattern, STATED, "derivative of position", "[velocity] column in a preset")
        )
    return {**chosen, **new}, guesses


def _is_rate(values: np.ndarray, time: np.ndarray, position: Family, other: Family) -> bool:
    return bool(np.isfinite(moves(time, values[:, position.places], values[:, other.places]).ratio))


def _efforts(
    chosen: Mapping[str, Family], reading: Reading, effort: str, silent: np.ndarray
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
