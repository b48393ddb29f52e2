"""exidyn watch: what a controller measures, live; nothing is commanded and no drive is powered."""

import sys
import time
from argparse import Namespace
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import numpy as np

from exidyn.drivers import Arm, Driver, Info, create, driver_class
from exidyn.drivers.errors import BadSettings
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import paragraph

from ..arguments.command import Command, Group, Option, positive, print_warning
from ..arguments.controllers import CONTROLLER, read_controller
from ..arguments.options import ALARMS, FLEET, JSON, require_json, robot_option
from ..run.arms import make_driver, standing_arm
from ..run.listener import Listener, Reading
from ..run.stopping.stop import StopRequests
from ..terminal.joint_units import JointUnits
from ..terminal.json_output import SCREEN
from ..terminal.run_summary import confirm_reading
from ..terminal.watch_text import Redraw, json_line, line, table_lines

if TYPE_CHECKING:
    from ..fleet.analysis import ResidualAlarm

REDRAW, LINES = 0.2, 1.0
"""Time between readings of a table, which an eye follows, and of lines, which fill a screen [s]."""
STEP = 0.05
"""Time between looks for a reason to end [s]."""


@Command(
    "Show what a controller measures, live. Nothing is commanded and no drive is powered.",
    (
        "exidyn watch --controller cell.toml                        # positions in radians",
        "exidyn watch --controller cell.toml --robot robot.toml     # in degrees, beside the limits",
        "exidyn watch --controller cell.toml --seconds 10 --json -  # a line of JSON for each reading",
        "exidyn watch --controller cell.toml --arm welding-07        # residual, held against its check runs",
    ),
    (
        robot_option("degrees and limits; without it radians"),
        *CONTROLLER,
        Option("--seconds S", "end after so long; default: at Ctrl-C", positive),
        Option("--every S", f"between readings; default: {REDRAW:g}, lines {LINES:g}", positive),
        Group(
            "residual, held against the arm's check runs (exidyn fleet)",
            (
                Option("--arm ARM", "its name in the fleet"),
                Option("--fleet FOLDER", "of its results", Path, FLEET),
                ALARMS,
            ),
        ),
        JSON,
    ),
)
def watch_command(given: Namespace) -> None:
    """Open to read, show, close; Ctrl-C is the usual end."""
    require_json(given.json)
    with ExitStack() as stack:
        alarm = _alarm(given, stack)
        driver, units = _driver(given, alarm)
        confirm_reading(driver.risk_of_reading)
        asked = stack.enter_context(StopRequests())
        stack.callback(driver.close)
        info = driver.open_to_read()
        asked.look()  # from here on Ctrl-C is a request, and does not interrupt
        for warning in info.warnings:
            print_warning(warning)
        print("\n".join(paragraph(f"read only; sent to it: {driver.sent_to_read}")), file=sys.stderr)
        file = None
        if given.json is not None and given.json != SCREEN:
            file = stack.enter_context(Path(given.json).open("w", encoding="utf-8"))
        listener = stack.enter_context(Listener(driver))
        _show(given, _readings(given, listener, asked), units, info, file, alarm)


def _alarm(given: Namespace, stack: ExitStack) -> "ResidualAlarm | None":
    if given.arm is None:
        return None
    from ..fleet.analysis import ResidualAlarm
    from ..fleet.store import Store
    from ..fleet.work import process_apart

    store, executor = Store(given.fleet.resolve()), stack.enter_context(process_apart())
    return ResidualAlarm(store, given.arm, given.alarms_per_arm_year, executor)


def _driver(given: Namespace, alarm: "ResidualAlarm | None") -> tuple[Driver, JointUnits]:
    name, settings = read_controller(given.controller, given.driver, given.set)
    if name == "mock":  # whose simulated time would else run away, also by a file with all its settings
        settings["clock"] = "real"
    if (model := _model(given, alarm)) is not None:
        robot = model.robot
        return make_driver(name, settings, robot, standing_arm(robot, model)), JointUnits.of(robot)
    count = driver_class(name).count_joints(settings)
    if not count:
        cell = "" if given.controller else ", and what moves it with --controller"
        raise BadSettings(
            f"driver {name}: the settings list no joints, so that their number is unknown. "
            f"Name the arm with --robot{cell}"
        )
    far = np.full(count, np.inf)
    arm = Arm(tuple(f"joint{k + 1}" for k in range(count)), -far, far, far)
    return create(name, settings, arm), JointUnits.unknown(arm)


def _model(given: Namespace, alarm: "ResidualAlarm | None") -> Model | None:
    """The robot that was named, or that of the arm in the fleet; None without either."""
    model = read_model(given.robot) if given.robot is not None else None
    if alarm is None or model is None:
        return model or (alarm.model if alarm is not None else None)
    joints, others = model.robot.joints, alarm.model.robot.joints
    if joints != others:
        raise BadSettings(
            f"--robot has joints {', '.join(joints)}, and {given.arm} in {given.fleet} {', '.join(others)}"
        )
    return model


def _readings(given: Namespace, listener: Listener, asked: StopRequests) -> Iterator[tuple[float, Reading]]:
    """Seconds since the first reading, and a reading, until a stop is asked for or time is up."""
    tabular = given.json is None and sys.stdout.isatty()
    every = given.every or (REDRAW if tabular else LINES)
    began, due = None, time.monotonic()
    while asked.look() is None:
        now = time.monotonic()
        over = began is not None and given.seconds is not None and now - began >= given.seconds
        if (now >= due or over) and (reading := listener.look()) is not None:
            began, due = now if began is None else began, now + every
            yield now - began, reading
        if over:
            return
        time.sleep(STEP)


def _show(
    given: Namespace,
    readings: Iterator[tuple[float, Reading]],
    units: JointUnits,
    info: Info,
    file: TextIO | None,
    alarm: "ResidualAlarm | None",
) -> None:
    page, events = Redraw(sys.stdout), list[str]()
    for seconds, reading in readings:
        residual = alarm.add(reading.samples) if alarm is not None else None
        if file is not None:
            file.write(json_line(reading, units, seconds, residual) + "\n")
            file.flush()
        if given.json == SCREEN:
            print(json_line(reading, units, seconds, residual), flush=True)
        elif sys.stdout.isatty():
            events += reading.events
            page.draw(table_lines(reading, units, info, seconds, events, residual))
        else:
            print(line(reading, units, info, seconds, residual), flush=True)
