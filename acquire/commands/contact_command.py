"""exidyn contact: external torques and contacts along a recording."""

from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.identification.contact.contact import Contact, contact, torque_unit
from exidyn.identification.contact.threshold import Alarm
from exidyn.identification.errors import RecordingError
from exidyn.identification.file_names import write_whole
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.notebook import counted
from exidyn.identification.text_table import digits, paragraph, table

from ..arguments import options
from ..arguments.command import Command, Option
from ..files.given_runs import read_runs, single_recording
from .result import Result, later

SHORT = 0.2
"""Duration of the runs without contact below which the page asks for longer ones [h]: from a fifth of the
usual hour between false alarms on, the extrapolation is short."""


@Command(
    "Estimate external torques along a recording, and find contacts.",
    (
        "exidyn contact run.mcap --fit exidyn-fit/fit.json --free other.mcap",
        "exidyn contact run.mcap --fit exidyn-fit/fit.json -o external.csv",
    ),
    (
        Option("run RUN", "recording (.mcap), or table (.csv)", Path),
        Option("--fit FIT", "fit.json of exidyn identify", Path, required=True),
        options.FREE,
        options.ALARMS_PER_HOUR,
        Option(
            "--payload NAME",
            "payload on the flange, or none; default: that of the recording",
            options.payload_name,
        ),
        options.output_option("FILE", meaning="write external torques and flange force as a table (.csv)"),
        options.JSON,
        *options.view_options("torques, and the force on the moving arm,"),
    ),
    """With --payload none, a payload is an external force: its weight is what the
flange force shows. A payload that the recording states and the fit does not have
is refused otherwise.""",
)
def contact_command(args: Namespace) -> Result:
    """Print the contacts, and write the estimates."""
    fit = read_fit(args.fit)
    options.require_file(args.save, "--save", [args.run, args.fit, *args.free])
    if args.output is not None and args.output.suffix != ".csv":
        raise RecordingError(f"--output {args.output}: the name must end in .csv")
    options.require_file(args.output, "--output", [args.run, args.fit, *args.free])
    if any(path.exists() and args.run.exists() and path.samefile(args.run) for path in args.free):
        raise RecordingError(f"{args.run} is given with --free too; judge it by other runs without contact")
    run = single_recording(args.run, fit.model)
    result = contact(fit, run, read_runs(args.free, fit.model), args.payload, args.alarms_per_hour)
    written = [] if args.output is None else [write_whole(args.output, _csv(fit, result))]
    view = later("contact_view", result, torque_unit(fit))
    return Result("\n".join(_page(fit, result)), _table(fit, result, written), written, view=view)


def _page(fit: Fit, result: Contact) -> list[str]:
    """Alarms, or the external torques without a threshold; then the mean force on the flange."""
    if fit.unscaled:
        words = "No force in newtons: drive gains are unknown. Identify them with a payload that was weighed."
    else:
        mean = " ".join(digits(value, 3) for value in _mean_force(result))
        words = f"Mean force on the flange, x y z in the axes of the base: {mean} N."
    force = paragraph(words)
    if result.threshold is None:
        return [*_torques(fit, result), "", *force]
    lines = paragraph(_words(result))
    if result.alarms:
        torque = f"torque [{torque_unit(fit)}]"
        head = ["from [s]", "to [s]", "joint", torque, "times threshold", "force x y z [N]"]
        rows = [_row(fit, alarm) for alarm in result.alarms]
        lines += ["", *table(head, rows, left=(2, 5)), ""]
        lines += paragraph("torque, force: of the joint and on the flange, at the peak of the contact.")
    return [*lines, *force]


def _torques(fit: Fit, result: Contact) -> list[str]:
    """Range of the external torques of each joint, and how to find contacts."""
    torque = result.estimates.torque
    lowest, highest = (of(torque, axis=0) for of in (np.nanmin, np.nanmax))
    joints = fit.model.robot.joints
    rows = [[joint, digits(lowest[j], 3), digits(highest[j], 3)] for j, joint in enumerate(joints)]
    sentence = (
        f"{result.run}: no threshold, so contacts are not counted: state runs without contact with --free. "
        f"External torque [{torque_unit(fit)}]:"
    )
    return [*paragraph(sentence), *table(["joint", "lowest", "highest"], rows, left=(0,))]


def _words(result: Contact) -> str:
    """Number of contacts, and the threshold with its source."""
    threshold = result.threshold
    assert threshold is not None
    rate = f"{threshold.alarms_per_hour:g} false {'alarm' if threshold.alarms_per_hour == 1.0 else 'alarms'}"
    longer = " Longer runs without contact lower it." if threshold.hours < SHORT else ""
    contacts = counted(len(result.alarms), "contact") if result.alarms else "no contact"
    return (
        f"{result.run}: {contacts}. The threshold for {rate} an hour is {threshold.level:.1f} standard "
        "deviations of the residual at the same speed and load, extrapolated from "
        f"{60.0 * threshold.hours:.1f} min without contact.{longer}"
    )


def _force_at(fit: Fit, alarm: Alarm) -> np.ndarray:
    """Force on the flange at the peak of a contact, shape (3,) [N]; NaN without drive gains."""
    return np.full(3, np.nan) if fit.unscaled else alarm.wrench(fit.model.robot)[:3]


def _mean_force(result: Contact) -> np.ndarray:
    """Mean force on the flange, shape (3,) [N]; NaN without any."""
    known = result.wrench[np.all(np.isfinite(result.wrench), axis=1), :3]
    return np.mean(known, axis=0) if len(known) else np.full(3, np.nan)


def _row(fit: Fit, alarm: Alarm) -> list[str]:
    return [
        f"{alarm.start:.2f}",
        f"{alarm.end:.2f}",
        fit.model.robot.joints[alarm.joint],
        digits(alarm.torque[alarm.joint], 3),
        digits(alarm.score, 2),
        " ".join(digits(value, 3) for value in _force_at(fit, alarm)),
    ]


def _table(fit: Fit, result: Contact, written: list[Path]) -> dict[str, Any]:
    """Content of the JSON."""
    threshold, robot = result.threshold, fit.model.robot
    return {
        "exidyn_contact": 1,
        "run": result.run,
        "joints": list(robot.joints),
        "level": None if threshold is None else threshold.level,
        "alarms_per_hour": None if threshold is None else threshold.alarms_per_hour,
        "free_hours": None if threshold is None else threshold.hours,
        "torque_rms": np.sqrt(np.nanmean(result.estimates.torque**2, axis=0)),
        "force_mean": _mean_force(result),
        "alarms": [
            {
                "start": alarm.start,
                "end": alarm.end,
                "joint": robot.joints[alarm.joint],
                "torque": alarm.torque,
                "over_threshold": alarm.score,
                "force": _force_at(fit, alarm),
            }
            for alarm in result.alarms
        ],
        "written": [str(path) for path in written],
    }


def _csv(fit: Fit, result: Contact) -> str:
    """External torques, the torque of each joint that makes an alarm, and the flange force, by time."""
    joints = range(1, fit.model.robot.dof + 1)
    names = ["t", *(f"external{j}" for j in joints)]
    columns = [result.estimates.time[:, None], result.estimates.torque]
    if result.threshold is not None:
        names += [f"contact_from{j}" for j in joints]
        columns.append(result.threshold.torque(result.estimates))
    names += ["force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z"]
    rows = np.concatenate([*columns, result.wrench], axis=1)
    lines = (",".join("" if np.isnan(value) else f"{value:.9g}" for value in row) for row in rows)
    return "\n".join([",".join(names), *lines]) + "\n"
