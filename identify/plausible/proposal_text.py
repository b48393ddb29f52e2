"""A proposal as a table for people, as a robot.toml, and as the preset of a log.

No motion identifies joints that stand still throughout a log: the robot.toml holds them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from exidyn.quoting import hash_comment

from ..arm.robot import PositionServo, Robot
from ..model import Model
from ..robot_files.description import XML
from ..robot_files.robot_text import model_text, servo_keys
from ..robot_files.toml_fields import block, lines
from ..text_table import digits, paragraph, table
from .changes import with_gravity
from .gains import GAIN_OF, Gain, gain_guesses
from .guess import DECIDED, Guess
from .proposal import Proposal
from .units import affine, at_rest, units_of

STILL = 1e-3
"""Range of a position below which a joint does not move [rad, m]: a loaded gear bends by as much."""


UNDECIDED = 1.0
"""Relative standard deviation of a gain that is not decided: twice as much, or none, is one of it away."""


class Still(NamedTuple):
    """What stands still.

    Attributes:
        position: Joint -> where it stands [rad, m].
        column: Column of its position -> between what it stays, in the unit of the log.
    """

    position: Mapping[str, float] = MappingProxyType({})
    column: Mapping[str, tuple[float, float]] = MappingProxyType({})


NOTHING = Still()


def proposal_text(proposal: Proposal) -> str:
    """What was guessed, how sure that is, what else was seen, and what is not decided."""
    rows = [[g.what, g.value, chance(g.probability), g.why] for g in proposal.guesses if g.decided]
    parts = [table(["what", "guess", "sure", "from"], rows, left=(0, 1, 3))]
    parts += [paragraph(note, "  ", "* ") for note in proposal.notes]
    for guess in proposal.open:
        parts.append(paragraph(f"NOT DECIDED: {_open_words(guess)}", "  "))
    return "\n".join(line for part in parts for line in part)


def chance(probability: float) -> str:
    """A probability in per cent; what is rounded to all of them is above 99.9."""
    return "> 99.9 %" if probability > 0.999 else f"{100 * probability:.1f} %"


def _open_words(guess: Guess) -> str:
    """What is not decided, and what settles it."""
    likely = f", likeliest {guess.value} ({chance(guess.probability)})" if guess.probability > 0 else ""
    return f"{guess.what}{likely}. To settle it: {guess.option}"


def robot_toml(
    proposal: Proposal,
    model: Model,
    urdf: str,
    log: str,
    joints: Sequence[str] = (),
    held: Mapping[str, float] = MappingProxyType({}),
) -> str:
    """A robot.toml with what the log tells of the drives.

    Args:
        proposal: For this arm.
        model: The arm as described.
        urdf: Path of its URDF or MJCF from the new file; "" if it is described otherwise, and is written out.
        log: What the log is called.
        joints: Those of that file that move, where others are held at zero.
        held: Joints of that file that are held elsewhere, and where [rad, m].
    """
    head = [hash_comment(f"Proposed by exidyn init from {log}; what it did not decide is said in comments.")]
    head += [hash_comment(_open_words(guess)) for guess in proposal.open]
    known = any(gain.known for gain in proposal.gains) and bool(np.all(model.robot.drive_gain == 1.0))
    values, tolerance = _stated_gains(proposal.gains) if known else ([], [])
    if proposal.gains and not known:
        gains = ", ".join(digits(gain.value) if gain.known else "?" for gain in proposal.gains)
        head.append(hash_comment(f"Gains of the log [N m per unit]: [{gains}]"))
    drive = block("[drive]", {"gain": values, "gain_tolerance": tolerance}) + "\n" if known else ""
    undecided = [j for j, gain in zip(model.robot.joints, proposal.gains, strict=False) if not gain.known]
    if known and undecided:
        head.append(
            hash_comment(
                f"[drive] gain of {', '.join(undecided)} is a guess: gain_tolerance is {UNDECIDED:g}"
            )
        )
    n = model.robot.dof
    servo = None
    if proposal.servo and model.robot.servo is None:
        # No limit: by a gain that may be half as much again, samples below it would be cut off.
        servo = PositionServo(np.ones(n), np.full(n, np.inf))
        drive = (drive or "[drive]\n") + lines(servo_keys(servo)) + "\n"
    if urdf:
        keys: dict[str, object] = {
            "format": 1,
            "name": model.robot.name,
            "mjcf" if urdf.lower().endswith(XML) else "urdf": urdf,
        }
        keys |= {"joints": list(joints)} if joints else {}
        keys |= (
            {"gravity": [float(f"{part:.3f}") + 0.0 for part in proposal.gravity]} if proposal.gravity else {}
        )
        body = lines(keys | ({"held": dict(held)} if held else {})) + "\n"
        return "\n".join(head) + "\n\n" + body + (f"\n{drive}" if drive else "")
    if proposal.gravity:
        model = with_gravity(model, np.array(proposal.gravity))
    if known:
        gain, spread = np.array(values), np.array(tolerance)
        model = replace(model, robot=replace(model.robot, drive_gain=gain, drive_gain_tolerance=spread))
    if servo is not None:
        model = replace(model, robot=replace(model.robot, servo=servo))
    return "\n".join(head) + "\n\n" + model_text(model)


def _stated_gains(gains: Sequence[Gain]) -> tuple[list[float], list[float]]:
    """Gains and their relative standard deviations, of which `UNDECIDED` stands for gains that are not known.

    A gain of which the log tells nothing is as large as those that are known.
    """
    usual = float(np.exp(np.mean([np.log(abs(gain.value)) for gain in gains if gain.known])))
    values = [gain.value if np.isfinite(gain.value) else usual for gain in gains]
    spread = [max(gain.relative, 0.01) if gain.known else UNDECIDED for gain in gains]
    return [float(f"{value:.4g}") for value in values], [float(f"{share:.2f}") for share in spread]


def preset_toml(
    proposal: Proposal, robot: Robot, log: str, rate: float | None = None, still: Still = NOTHING
) -> str:
    """Which columns of a log are what, as the preset that `exidyn import` finds beside it.

    `rate` is that of a log without a column of time [Hz]; joints that are `still` are to stay so.
    """
    units = proposal.units
    per = "" if units.velocity in ("", "rpm") else "/s"
    position, velocity = units_of(robot, units.position), units_of(robot, units.velocity, per)
    unit = {"position": position, "command": position, "link_position": position}
    if units.velocity:
        unit |= {"velocity": velocity, "command_velocity": velocity}
    blocks = [hash_comment(f"Proposed by exidyn init from {log}.")]
    blocks += [] if rate is None else [lines({"rate": rate})]
    for signal, names in proposal.columns.items():
        if signal == "time" and rate is not None:
            continue
        if signal == "time":
            keys: dict[str, object] = {"column": names[0], "unit": units.time}
        else:
            each = unit.get(signal, [])
            keys = {"column": list(names)}
            keys |= {"unit": each[0] if len(set(each)) == 1 else each} if each else {}
            keys |= {"sign": -1} if signal == "torque" and proposal.against else {}
        blocks.append(block(f"[{signal}]", keys))
    if still.column:
        blocks.append(block("[still]", still.column))
    return "\n\n".join(blocks) + "\n"


def as_json(proposal: Proposal, written: Sequence[str], then: str) -> dict[str, object]:
    """The same for scripts."""
    return {
        "exidyn_init": 1,
        "columns": {signal: list(names) for signal, names in proposal.columns.items()},
        "units": proposal.units._asdict(),
        "gains": [gain._asdict() | {"known": gain.known} for gain in proposal.gains],
        "torque_counts_against": proposal.against,
        "gravity": list(proposal.gravity),
        "guesses": [vars(guess) | {"decided": guess.decided} for guess in proposal.guesses],
        "decided_from": DECIDED,
        "notes": list(proposal.notes),
        "written": list(written),
        "then": then,
    }


def still_joints(proposal: Proposal, robot: Robot, names: Sequence[str], values: np.ndarray) -> Still:
    """Joints that move by less than `STILL` in all of a log, if any other moves."""
    columns = proposal.columns["position"]
    position = values[:, [list(names).index(column) for column in columns]]
    factor, offset = affine(robot, proposal.units.position, position)
    resting = np.nanmax(position, axis=0) - np.nanmin(position, axis=0) < STILL / factor
    if resting.all():
        return NOTHING
    middle, about = np.nanmedian(position, axis=0), STILL / factor
    places = np.flatnonzero(resting)
    return Still(
        {robot.joints[j]: float(middle[j] * factor[j] + offset[j]) for j in places},
        {columns[j]: (float(middle[j] - about[j]), float(middle[j] + about[j])) for j in places},
    )


def without_still(proposal: Proposal, robot: Robot, still: Still) -> Proposal:
    """The same without columns and gains of those joints, and a note of each."""
    kept = [j for j, joint in enumerate(robot.joints) if joint not in still.position]
    columns = {
        signal: names if signal == "time" else tuple(names[j] for j in kept)
        for signal, names in proposal.columns.items()
    }
    found = tuple(proposal.gains[j] for j in kept) if proposal.gains else ()
    guesses = [guess for guess in proposal.guesses if not guess.what.startswith(GAIN_OF)]
    guesses += gain_guesses([robot.joints[j] for j in kept], found)
    notes = [note for note in proposal.notes if note not in map(at_rest, still.position)]
    for joint, where in still.position.items():
        unit = "rad" if robot.revolute[robot.index(joint)] else "m"
        notes.append(f"{at_rest(joint)}: the model holds it at {digits(where)} {unit}")
    return replace(proposal, columns=columns, gains=found, guesses=tuple(guesses), notes=tuple(notes))
