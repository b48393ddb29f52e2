"""exidyn watch: show live measurements of a controller; nothing is commanded and no drive is powered."""

import sys
from argparse import Namespace
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import numpy as np

from exidyn.drivers import Arm, Driver, Info, create, driver_class
from exidyn.drivers.errors import BadSettings
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.text_table import paragraph

from ..arguments.command import Command, Group, Option, positive, print_warning
from ..arguments.options import ALARMS_PER_HOUR, FREE, JSON, payload_name, require_apart, robot_option
from ..arguments.run_options import CONTROLLER, read_controller
from ..run.arms import make_driver, standing_arm
from ..run.frames import END, STAGES, sample_frame, text_frame
from ..run.listener import Listener, Reading
from ..run.pipe import Sink
from ..run.recorder import RunHead
from ..run.stopping.stop import StopRequests
from ..terminal.json_output import SCREEN, print_written
from ..terminal.run_summary import confirm_reading
from ..terminal.watch_text import JointUnits, Redraw, json_line, line, table_lines
from ..views.live_view import CONTACT_PROCESS, PROCESS, VIEW, Targets, require_showable, start_view

if TYPE_CHECKING:
    from ..terminal.live_contact import LiveContact

REDRAW, LINES = 0.2, 1.0
"""Time between readings in a table and between lines, which would otherwise fill the screen [s]."""
STEP = 0.05
"""Time between checks whether to end [s]."""


@Command(
    "Show what a controller measures, live. Nothing is commanded and no drive is powered.",
    (
        "exidyn watch --controller cell.toml                        # positions in radians",
        "exidyn watch --controller cell.toml --length 10 --json -   # one line of JSON per reading",
        "exidyn watch --controller cell.toml --robot robot.toml --view    # in degrees; plots and the arm",
        "exidyn watch --controller cell.toml --fit fit.json --free free.mcap --view  # contacts",
    ),
    (
        robot_option("for degrees and limits; without it radians"),
        *CONTROLLER,
        Option("--length S", "duration; default: until Ctrl-C", positive),
        Group(
            "external torque and contact, by a fit (exidyn contact)",
            (
                Option("--fit FIT", "fit.json of exidyn identify", Path),
                FREE,
                ALARMS_PER_HOUR,
                Option("--payload NAME", "payload of the fit on the flange; default: none", payload_name, ""),
            ),
        ),
        Group("live view of the measurements; with --fit of the external torques", VIEW),
        JSON,
    ),
)
def watch_command(args: Namespace) -> None:
    """Open the controller for reading, show measurements until Ctrl-C or the end, close it."""
    with ExitStack() as stack:
        targets = Targets(args.view, args.serve, args.save)
        require_showable(targets)
        if args.save is not None:
            require_apart(args.save, "--save", [args.fit, *args.free])
        contact = _contact(args)
        model = _model(args, contact, targets)
        driver, units = _driver(args, model)
        confirm_reading(driver.risk_of_reading)
        process = PROCESS if contact is None else CONTACT_PROCESS
        views = [stack.enter_context(view) for view in start_view(targets, process)]
        if contact is not None and views:
            contact.show(views)
        requests = stack.enter_context(StopRequests())
        stack.callback(driver.close)
        info = driver.open_to_read()
        requests.look()  # from here on Ctrl-C is a request and does not interrupt
        for warning in info.warnings:
            print_warning(warning)
        print("\n".join(paragraph(f"read only; sent to it: {driver.sent_to_read}")), file=sys.stderr)
        file = None
        if args.json is not None and args.json != SCREEN:
            file = stack.enter_context(Path(args.json).open("w", encoding="utf-8"))
        listener = stack.enter_context(Listener(driver))
        readings = _readings(args, listener, requests)
        if contact is None and model is not None:
            readings = _shown(readings, views, model, info)
        _show(args, readings, units, info, file, contact)
    if args.save is not None:
        print_written(args.save)


def _contact(args: Namespace) -> "LiveContact | None":
    if args.fit is None:
        if args.free:
            raise BadSettings("--free is for a threshold of contact; name the fit with --fit")
        return None
    from exidyn.identification.fit.fit_file import read_fit

    from ..files.given_runs import read_runs
    from ..terminal.live_contact import LiveContact

    fit = read_fit(args.fit)
    return LiveContact(fit, read_runs(args.free, fit.model), args.payload, args.alarms_per_hour)


def _driver(args: Namespace, model: Model | None) -> tuple[Driver, JointUnits]:
    name, settings = read_controller(args.controller, args.driver, args.set)
    if name == "mock":
        settings["clock"] = "real"  # simulated time would run ahead, even if a controller file asks for it
    if model is not None:
        robot = model.robot
        return make_driver(name, settings, robot, standing_arm(robot, model)), JointUnits.of(robot)
    count = driver_class(name).count_joints(settings)
    if not count:
        cell = "" if args.controller else ", and its controller with --controller"
        raise BadSettings(
            f"driver {name}: the settings list no joints, so that their number is unknown. "
            f"Name the arm with --robot{cell}"
        )
    unlimited = np.full(count, np.inf)
    arm = Arm(tuple(f"joint{k + 1}" for k in range(count)), -unlimited, unlimited, unlimited)
    return create(name, settings, arm), JointUnits.unknown(arm)


def _model(args: Namespace, contact: "LiveContact | None", targets: Targets) -> Model | None:
    """The model of --robot, or else of the fit; None without either, which a view needs."""
    if args.robot is None:
        if contact is None and targets.any:
            raise BadSettings("--view, --serve and --save draw the arm; name it with --robot")
        return None if contact is None else contact.fit.model
    model = read_model(args.robot)
    if contact is None:
        return model
    source, other = f"--fit {args.fit}", contact.fit.model.robot
    if model.robot.joints != other.joints:
        first, second = (", ".join(robot.joints) for robot in (model.robot, other))
        raise BadSettings(f"--robot has joints {first}, but {source} has {second}")
    if model.robot.differs_from(other):
        raise BadSettings(f"{source} is of {other.name}, an arm with other geometry than --robot")
    return model


def _readings(args: Namespace, listener: Listener, requests: StopRequests) -> Iterator[tuple[float, Reading]]:
    """Time since the first reading [s] and a reading, until a stop is requested or time is up."""
    tabular = args.json is None and sys.stdout.isatty()
    period = REDRAW if tabular else LINES
    began, due = None, listener.clock.monotonic()
    while requests.look() is None:
        now = listener.clock.monotonic()
        over = began is not None and args.length is not None and now - began >= args.length
        if (now >= due or over) and (reading := listener.look()) is not None:
            began, due = now if began is None else began, now + period
            yield now - began, reading
        if over:
            return
        listener.clock.sleep(STEP)


def _shown(
    readings: Iterator[tuple[float, Reading]], views: Sequence[Sink], model: Model, info: Info
) -> Iterator[tuple[float, Reading]]:
    """The readings, each put to the live views of the measurements as it comes."""
    head = RunHead("watch", model, signals=info.signals).frame()
    for view in views:
        view.put(head)
    for seconds, reading in readings:
        for view, sample in product(views, reading.samples):
            view.put(sample_frame(sample, None, STAGES.index("listening")))
        yield seconds, reading
    for view in views:
        view.put(text_frame(END, {"stop": "none", "text": "the arm is no longer watched"}))


def _show(
    args: Namespace,
    readings: Iterator[tuple[float, Reading]],
    units: JointUnits,
    info: Info,
    file: TextIO | None,
    contact: "LiveContact | None",
) -> None:
    page, events = Redraw(sys.stdout), list[str]()
    for seconds, reading in readings:
        external = None if contact is None else contact.add(reading.samples)
        if file is not None:
            file.write(json_line(reading, units, seconds, external) + "\n")
            file.flush()
        if args.json == SCREEN:
            print(json_line(reading, units, seconds, external), flush=True)
        elif sys.stdout.isatty():
            events += reading.events
            page.draw(table_lines(reading, units, info, seconds, events, external))
        else:
            print(line(reading, units, info, seconds, external), flush=True)
