"""Universal Robots controllers by RTDE: the controller sends every 2 or 8 ms, the driver answers.

The controller keeps the only clock: positions and currents of a sample have the same time stamp. A program
that the driver sends follows the targets by `servoj`; the resulting delay of the arm is between commands and
positions only, and does not affect the measurements.
"""

from contextlib import suppress
from typing import Any

import numpy as np

from ..driver import Arm, Driver, Info, StopLevel
from ..errors import BadSettings, DriverError, LinkLost, NotReady, Unreadable
from ..samples import ControllerSamples, Remarks, word
from ..values import Command, Sample
from .dashboard import Dashboard
from .program import ASKED, FOLLOW, JOINTS, SILENT, STOP, Registers, UrSettings, program_sent, program_text
from .rtde import DATA, PAUSE, START, RtdeLink, package
from .session import (
    JOINT_MODE,
    PLAYING,
    REPORTED,
    STATE,
    Session,
    agree,
    info_of,
    obstacle,
    sample_of,
    slowed,
    state_of,
)

SILENCE, LONGER = 5, 0.02
"""Number of cycles without a package after which a sample is stale, and maximum wait beyond one cycle [s]: a
busy network delays packages, but the loop must continue."""
LOST = 1.0
"""Time without a package after which the link is lost [s]."""
CLOSING = 1.0
"""Maximum time for the program to end [s]."""
COUNTS = 1 << 30
"""Largest number of a command; the next command has the number 1."""


class UrRtde(Driver):
    """One Universal Robots controller.

    The controller sends no data between `open` and the first exchange, because a person may have to confirm
    the run. From `arm_drives` on the program runs, and each exchange increments the register that keeps it
    running.
    """

    Settings = UrSettings
    fixed_joints = JOINTS

    def __init__(self, settings: UrSettings, arm: Arm) -> None:
        super().__init__(settings, arm)
        if arm.dof != JOINTS:
            raise BadSettings(f"driver ur_rtde: the robot has {arm.dof} joints; expected {JOINTS}")
        self._registers = Registers(settings.first_register)
        self._samples = ControllerSamples(arm.dof, len(STATE), settings.cycle, self.clock)
        self._link: RtdeLink | None = None
        self._session: Session | None = None
        self._dashboard: Dashboard | None = None
        self._remarks = Remarks(STATE, REPORTED)
        self._flowing = self._armed = False
        self._demand, self._count = FOLLOW, 0
        self._quiet, self._heard = 0.0, self.clock.monotonic()
        self._target = np.full(arm.dof, np.nan)
        self._held: np.ndarray | None = None
        self._joint_mode = np.zeros(arm.dof, int)
        self._fault, self._untold = "", tuple[str, ...]()

    @property
    def sent_to_read(self) -> str:
        return "the request for measurements (RTDE)"

    def open(self) -> Info:
        return self._open(commanding=True)

    def open_to_read(self) -> Info:
        return self._open(commanding=False)

    def _open(self, commanding: bool) -> Info:
        settings = self.settings
        self._link = RtdeLink(settings.address, settings.rtde_port, settings.wait, self.clock)
        try:
            self._session = agree(self._link, settings, self._registers, commanding)
            if self._link.ask(START) != b"\x01":
                raise NotReady("driver ur_rtde: the controller refuses to send data. Try restarting it")
            record = self._first()
            self._link.ask(PAUSE)  # until the first exchange: unread data fill the controller's buffers
            if commanding:
                self._dashboard = Dashboard(
                    settings.address, settings.dashboard_port, settings.wait, self.clock
                )
                self._require_ready(record)
            return info_of(settings, self._session.version, record, self._dashboard)
        except BaseException:
            self._let_go()
            raise

    def _first(self) -> np.void:
        """Wait for a record. Raises LinkLost if none comes."""
        link, session = self._opened()
        end = self.clock.monotonic() + self.settings.wait
        while self.clock.monotonic() < end:
            newest = link.newest(self.settings.cycle)
            if newest is not None:
                return self._read(session, newest[0])
        raise LinkLost(f"driver ur_rtde: {self.settings.address} sends no data in {self.settings.wait:g} s")

    def _require_ready(self, record: np.void) -> None:
        reason = obstacle(record) or slowed(record)
        if not reason and self._dashboard is not None:
            if self._dashboard.ask("is in remote control").lower() == "false":
                reason = "the controller is in local control: choose Remote Control at the top of the pendant"
        if reason:
            raise NotReady(f"driver ur_rtde: {reason}")

    def states(self) -> tuple[str, ...]:
        return tuple(word(JOINT_MODE, int(code)) if code else "" for code in self._joint_mode)

    def arm_drives(self) -> None:
        """Send the program, and wait until it runs; it holds the arm at the controller's target."""
        settings = self.settings
        self._flow()
        record = self._first()
        self._require_ready(record)
        number = int(record[self._registers.session]) % COUNTS + 1
        self._target, self._demand, self._fault = record["target_q"].astype(float), FOLLOW, ""
        self._send()
        text = program_text(settings, number)
        end = self.clock.monotonic() + settings.wait
        with program_sent(settings.address, settings.program_port, text, settings.wait):
            while int(record[self._registers.session]) != number:
                if self.clock.monotonic() > end:
                    raise NotReady(
                        f"driver ur_rtde: the program does not begin in {settings.wait:g} s"
                        f"{self._last_message()}. Try Remote Control on the pendant (e-Series), and see its "
                        "log"
                    )
                record = self._first()
                self._send()
        self._armed, self._held = True, self._target

    def held(self) -> np.ndarray | None:
        return self._held

    def exchange(self, command: Command | None) -> Sample:
        """Wait for the package of the cycle, and send the command at once.

        `lateness` is the delay from a package's time stamp to its arrival, minus the shortest such delay; it
        contains delays of the controller, the network and this computer.
        """
        link, session = self._opened()
        self._flow()
        longest = min(SILENCE * self.settings.cycle, self.settings.cycle + LONGER)
        newest = link.newest(max(longest - self._quiet, self.settings.cycle))
        if newest is None:
            return self._silent()
        body, arrival = newest
        record = self._read(session, body)
        self._joint_mode = record["joint_mode"]
        self._fault = self._fault or self._fault_in(record)
        sent = self._commanded(command) or command is None
        try:
            state = state_of(record)
            known = {"state": state, "events": self._events(state), "fault": self._fault, "sent": sent}
            sample = sample_of(self._samples, record, arrival, **known)
        except Unreadable as error:
            return self._silent((str(error),), sent)
        self._quiet, self._heard = 0.0, self.clock.monotonic()
        return sample

    def _commanded(self, command: Command | None) -> bool:
        """Increment the count, with a new target if there is one; returns whether a new target was sent."""
        if not self._armed:
            return False
        is_new = command is not None and not self._fault and self._demand == FOLLOW
        before = self._target
        if is_new:
            assert command is not None
            self._target = command.position
        if self._send():
            return is_new
        self._target = before
        return False

    def _send(self) -> bool:
        link, session = self._opened()
        if session.inputs is None:
            return False
        self._count = self._count % COUNTS + 1
        registers = self._registers
        values: dict[str, Any] = dict(zip(registers.position, self._target.tolist(), strict=True))
        values |= {registers.count: self._count, registers.demand: self._demand}
        return link.send(package(DATA, session.inputs.written(values)))

    def _fault_in(self, record: np.void) -> str:
        reason = obstacle(record)
        if reason or not self._armed or self._demand != FOLLOW:
            return reason
        if int(record[self._registers.ended]) == SILENT:
            return (
                f"no command reached the controller for {self.settings.dead_man:g} s: its program has "
                "stopped the arm"
            )
        if int(record["runtime_state"]) != PLAYING or int(record[self._registers.ended]) == ASKED:
            return f"the program that moves the arm was stopped at the controller{self._last_message()}"
        return slowed(record)

    def _last_message(self) -> str:
        """Last message of the controller, in parentheses; empty without a message."""
        return f" ({self._link.texts[-1]})" if self._link and self._link.texts else ""

    def _silent(self, why: tuple[str, ...] = (), sent: bool = False) -> Sample:
        """Sample without a measurement, so that monitors can decide. Raises LinkLost after too long."""
        self._quiet = self.clock.monotonic() - self._heard
        if self._quiet > LOST:
            received = f"nothing readable ({why[0]})" if why else "nothing"
            raise LinkLost(
                f"driver ur_rtde: {received} from {self.settings.address} for {self._quiet:.2f} s. Look at "
                f"{'the controller' if why else 'cable and controller'}"
            )
        gone = int(self._quiet / self.settings.cycle)
        events = (*why, *self._events(None))
        return self._samples.of_silence(gone, events=events, fault=self._fault, sent=sent)

    def _events(self, state: np.ndarray | None) -> tuple[str, ...]:
        link, _ = self._opened()
        answers = self._dashboard.answers() if self._dashboard is not None else []
        events, self._untold = (*self._remarks.on(state, link.texts), *self._untold, *answers), ()
        return events

    def _opened(self) -> tuple[RtdeLink, Session]:
        if self._link is None or self._session is None:
            raise LinkLost("driver ur_rtde is not open")
        return self._link, self._session

    def _read(self, session: Session, body: bytes) -> np.void:
        try:
            return session.outputs.read(body)
        except ValueError as error:
            raise LinkLost(f"driver ur_rtde: data that cannot be read: {error}") from error

    def _flow(self) -> None:
        """Start the data if they do not flow yet; a controller that refuses sends none."""
        if not self._flowing:
            self._opened()[0].send(package(START))
            self._flowing, self._heard = True, self.clock.monotonic()
            self._samples.restart()

    def stop(self, level: StopLevel) -> None:
        """Stop the arm: QUICK makes the program decelerate (`stopj`) and end; OFF requests power off.

        After power off the brakes close. OFF needs the dashboard server, which on an e-Series obeys in remote
        control only, and which PolyScope X does not have.
        """
        if level < StopLevel.QUICK or self._link is None:
            return
        self._demand = STOP
        with suppress(DriverError):
            if self._armed:
                self._send()
        if level >= StopLevel.OFF and self._dashboard is not None:
            failed = self._dashboard.request("power off")
            self._untold += (failed,) * bool(failed)

    def close(self) -> None:
        """End the program, after which the controller holds the arm."""
        with suppress(DriverError):
            if self._armed and self._demand == FOLLOW:
                self.stop(StopLevel.QUICK)
                self._until_ended()
        self._let_go()

    def _until_ended(self) -> None:
        _, session = self._opened()
        end = self.clock.monotonic() + CLOSING
        while self.clock.monotonic() < end:
            newest = self._opened()[0].newest(self.settings.cycle)
            if newest and int(self._read(session, newest[0])["runtime_state"]) != PLAYING:
                return

    def _let_go(self) -> None:
        for connection in (self._link, self._dashboard):
            if connection is not None:
                connection.close()
        self._link = self._dashboard = None
        self._armed = self._flowing = False
