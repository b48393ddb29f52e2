"""A proposal as a table for people, as a robot.toml, and as the preset of a log.

Joints that stand still in the whole log cannot be identified, so the robot.toml lists them as held.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from exidyn.quoting import hash_comment

from ..arm.robot import PositionServo, Robot
from ..model import Model
from ..recordings.recording import SIGNALS
from ..recordings.tables.preset import Reading
from ..recordings.units import factors
from ..robot_files.description import XML
from ..robot_files.robot_text import model_text, servo_keys
from ..robot_files.toml_fields import block, lines
from ..text_table import digits, paragraph, table
from .change import with_gravity
from .gains import GAIN_OF, UNDECIDED, gain_guesses, stated_gains
from .proposal import Proposal
from .proposed_units import GRAVITY
from .suspicion import DECIDED, Guess
from .units import at_rest

STILL = 1e-3
"""A joint with a smaller range of positions does not move [rad, m]: a loaded gear bends by as much."""


class Still(NamedTuple):
    """Joints that stand still."""

    position: Mapping[str, float] = MappingProxyType({})  # joint -> its constant position [rad, m]
    # Position column -> lower and upper limit of the values, in the unit of the log.
    column: Mapping[str, tuple[float, float]] = MappingProxyType({})


NOTHING = Still()


def proposal_text(proposal: Proposal) -> str:
    """Table of guesses with their probabilities, notes, and undecided questions."""
    rows = [[g.what, g.value, chance(g.probability), g.why] for g in proposal.guesses if g.decided]
    parts = [table(["what", "guess", "sure", "from"], rows, left=(0, 1, 3))]
    parts += [paragraph(note, "  ", "* ") for note in proposal.notes]
    for guess in proposal.open:
        parts.append(paragraph(f"NOT DECIDED: {_open_words(guess)}", "  "))
    return "\n".join(line for part in parts for line in part)


def chance(probability: float) -> str:
    """A probability in percent, or "> 99.9 %"."""
    return "> 99.9 %" if probability > 0.999 else f"{100 * probability:.1f} %"


def _open_words(guess: Guess) -> str:
    """Words for an undecided guess, and what settles it."""
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
    """Text of a robot.toml with the drive gains that the log determines.

    Args:
        proposal: Proposal for this arm.
        model: Model of the described arm.
        urdf: Path of its URDF or MJCF, relative to the new file; "" writes out the whole model instead.
        log: Name of the log.
        joints: Joints of that file that move, if others are held at zero.
        held: Joints of that file that are held elsewhere -> position [rad, m].
    """
    head = [hash_comment(f"Proposed by exidyn init from {log}; comments list what it did not decide.")]
    head += [hash_comment(_open_words(guess)) for guess in proposal.open]
    proposed = any(gain.proposed for gain in proposal.gains)
    known = proposed and bool(np.all(model.robot.drive_gain == 1.0))
    values, tolerance = stated_gains(proposal.gains) if known else ([], [])
    if proposed and not known:
        gains = ", ".join(digits(gain.value) if gain.proposed else "undecided" for gain in proposal.gains)
        head.append(hash_comment(f"Gains of the log [N m per unit]: [{gains}]"))
    drive: dict[str, object] = {"gain": values, "gain_tolerance": tolerance} if known else {}
    undecided = [j for j, gain in zip(model.robot.joints, proposal.gains, strict=False) if not gain.proposed]
    if known and undecided:
        head.append(
            hash_comment(
                f"[drive] gain of {', '.join(undecided)} is a guess: gain_tolerance is {UNDECIDED:g}"
            )
        )
    n, servo = model.robot.dof, model.robot.servo
    if proposal.servo and servo is None:
        # No limit: the gain may be 50 % too large, and valid samples would then be cut off.
        servo = PositionServo(np.ones(n), np.full(n, np.inf))
        drive |= servo_keys(servo)
    if urdf:
        keys: dict[str, object] = {"format": 1, "name": model.robot.name}
        keys["mjcf" if urdf.lower().endswith(XML) else "urdf"] = urdf
        if joints:
            keys["joints"] = list(joints)
        if proposal.gravity:
            keys["gravity"] = [float(f"{part:.3f}") + 0.0 for part in proposal.gravity]
        if held:
            keys["held"] = dict(held)
        blocks = ["\n".join(head), lines(keys)]
        if drive:
            blocks.append(block("[drive]", drive))
        return "\n\n".join(blocks) + "\n"
    if proposal.gravity:
        model = with_gravity(model, np.array(proposal.gravity))
    if known:
        gain, spread = np.array(values), np.array(tolerance)
        model = replace(model, robot=replace(model.robot, drive_gain=gain, drive_gain_tolerance=spread))
    model = replace(model, robot=replace(model.robot, servo=servo))
    return "\n".join(head) + "\n\n" + model_text(model)


def preset_toml(proposal: Proposal, log: str, rate: float | None = None, still: Still = NOTHING) -> str:
    """Text of the preset of a log, which `exidyn import` finds beside it.

    `rate` is the sampling rate of a log without a time column [Hz]; the positions of `still` joints must stay
    within limits.
    """
    head = [hash_comment(f"Proposed by exidyn init from {log}; comments list what it did not decide.")]
    about = [guess for guess in proposal.open if not guess.what.startswith((GAIN_OF, GRAVITY))]
    blocks = ["\n".join([*head, *(hash_comment(_open_words(guess)) for guess in about)])]
    blocks += [] if rate is None else [lines({"rate": rate})]
    for signal, reading in proposal.readings.items():
        if signal == "time" and rate is not None:
            continue
        keys: dict[str, object] = {"column": reading.column}
        keys |= {"unit": _alike(reading.unit)} if reading.unit else {}
        signs = [int(sign) for sign in np.ravel(reading.sign)]
        keys |= {"sign": signs} if -1 in signs else {}
        keys |= {"sign": -1} if signal == "torque" and proposal.against else {}
        blocks.append(block(f"[{signal}]", keys))
    if still.column:
        blocks.append(block("[still]", still.column))
    return "\n\n".join(blocks) + "\n"


def _alike(units: str | list[str]) -> str | list[str]:
    """One unit if all joints have the same, else one per joint."""
    return units[0] if isinstance(units, list) and len(set(units)) == 1 else units


def as_json(proposal: Proposal, written: Sequence[str], then: str) -> dict[str, object]:
    """Proposal as JSON for scripts."""
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
    """Joints that move by less than `STILL` in the whole log, if any other joint moves."""
    columns = proposal.columns["position"]
    position = values[:, [list(names).index(column) for column in columns]]
    unit = proposal.readings["position"].unit
    each = [unit] * robot.dof if isinstance(unit, str) else unit
    factor, offset = factors(robot.units(SIGNALS["position"]), each, "position", robot.limits)
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
    """Proposal without columns and gains of joints that stand still, and with a note on each."""
    moving = [j for j, joint in enumerate(robot.joints) if joint not in still.position]
    readings = {
        signal: reading
        if signal == "time"
        else Reading(_of_joints(reading.column, moving), _of_joints(reading.unit, moving))
        for signal, reading in proposal.readings.items()
    }
    drives = tuple(proposal.gains[j] for j in moving) if proposal.gains else ()
    guesses = [guess for guess in proposal.guesses if not guess.what.startswith(GAIN_OF)]
    guesses += gain_guesses([robot.joints[j] for j in moving], drives)
    notes = [note for note in proposal.notes if note not in map(at_rest, still.position)]
    for joint, where in still.position.items():
        unit = "rad" if robot.revolute[robot.index(joint)] else "m"
        notes.append(f"{at_rest(joint)}: the model holds it at {digits(where)} {unit}")
    return replace(proposal, readings=readings, gains=drives, guesses=tuple(guesses), notes=tuple(notes))


def _of_joints(each: str | list[str], joints: Sequence[int]) -> str | list[str]:
    """Values of some joints, if there is one per joint."""
    return each if isinstance(each, str) else [each[joint] for joint in joints]
