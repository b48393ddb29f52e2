"""Franka Research 3: a separate process talks to the FCI at 1 kHz; this driver exchanges messages with it.

The controller keeps the only clock. Commands are held back by some milliseconds, so that the controller gets
one every millisecond even if this program is late. The resulting delay of the arm is between commands and
positions only, and does not affect the measurements.
"""

import numpy as np

from ..driver import Arm, Driver, Info, StopLevel
from ..errors import BadSettings, LinkLost, NotReady
from ..host_clock import WALL
from ..samples import ControllerSamples, Remarks, word
from ..values import Command, Sample
from .fci_link import FciLink
from .fci_messages import ENDED, FLOW, OFF, ROBOT_MODE, STATE, STOP, mode_of, obstacle, target
from .settings import FrankaSettings, info_of
from .target_stream import CYCLE, JOINTS

SILENCE = 5
"""Number of cycles without a state after which a sample is stale; a busy network causes fewer."""
LOST = 1.5
"""Time without a state after which the link is lost [s]; the library reports it after one second."""
MOST = 100
"""Maximum number of queued states once commands are sent; before, only the newest state counts."""
REPORTED = ("robot_mode", "error")
"""Parts of the controller's state whose changes are events."""


class Franka(Driver):
    """One Franka controller.

    States flow from the first exchange on, and the motion begins with the first command: until then the
    controller holds the arm by itself.
    """

    Settings = FrankaSettings
    fixed_joints = JOINTS

    def __init__(self, settings: FrankaSettings, arm: Arm) -> None:
        super().__init__(settings, arm)
        if arm.dof != JOINTS:
            raise BadSettings(f"driver franka: the robot has {arm.dof} joints; expected {JOINTS}")
        self._link: FciLink | None = None
        self._samples = ControllerSamples(JOINTS, len(STATE), CYCLE)
        self._remarks = Remarks(STATE, REPORTED)
        self._flowing = self._armed = self._stopped = False
        self._next: np.void | None = None
        self._holes = 0
        self._heard = self.clock.monotonic()
        self._target: np.ndarray | None = None
        self._held: np.ndarray | None = None
        self._mode = ""
        self._fault = ""

    @property
    def sent_to_read(self) -> str:
        return "the request for its state (FCI)"

    def open(self) -> Info:
        self._link = FciLink(self.settings)
        try:
            record = self._link.state()
            self._require_ready(record)
            return self._explained(record)
        except BaseException:
            self.close()
            raise

    def open_to_read(self) -> Info:
        self._link = FciLink(self.settings)
        return self._explained(self._link.state())

    def _explained(self, record: np.void) -> Info:
        self._mode = word(ROBOT_MODE, mode_of(record))
        return info_of(self.settings, self._opened().version, record, self.arm)

    def _require_ready(self, record: np.void) -> None:
        if reason := obstacle(record):
            raise NotReady(f"driver franka: {reason}")

    def states(self) -> tuple[str, ...]:
        return (self._mode,) * JOINTS

    def arm_drives(self) -> None:
        """Check that the controller holds the arm, and store the held position, where the motion begins."""
        record = self._opened().state()
        self._require_ready(record)
        self._held, self._armed = record["q_d"].copy(), True

    def held(self) -> np.ndarray | None:
        return self._held

    def exchange(self, command: Command | None) -> Sample:
        """Return a sample of each state in turn, including states that came while this program was late.

        A lost state gives a sample without a measurement, whose command is sent: the controller takes a
        command for each of its milliseconds. `lateness` is the delay from a state's time stamp to its
        processing, minus the shortest such delay.
        """
        link = self._flow()
        if self._next is None and not self._receive(link):
            return self._silent()
        record = self._next
        assert record is not None
        self._fault = self._fault or self._fault_in(record)
        sent = self._commanded(command) or command is None
        if self._holes:
            self._holes -= 1
            return self._samples.of_silence(1, fault=self._fault, sent=sent)
        self._next, self._mode = None, word(ROBOT_MODE, mode_of(record))
        time = int(record["time"])
        return self._samples.of(
            time,
            int(record["arrival"]) + WALL,
            self._samples.cycles(time),
            self._samples.lateness(self.clock.host_time(), time),
            position=record["q"].copy(),
            velocity=record["dq"].copy(),
            torque=record["tau_J"].copy(),
            events=self._remarks.on(record["state"]),
            fault=self._fault,
            sent=sent,
            state=record["state"].copy(),
        )

    def _flow(self) -> FciLink:
        link = self._opened()
        if not self._flowing:
            link.forget()
            link.send(FLOW)
            self._flowing, self._heard = True, self.clock.monotonic()
        return link

    def _receive(self, link: FciLink) -> bool:
        """Take the next state; returns whether there is one."""
        quiet = self.clock.monotonic() - self._heard
        link.forget(keep=1 if self._target is None else MOST)
        self._next = link.next(max(SILENCE * CYCLE - quiet, CYCLE))
        if self._next is None:
            return False
        self._heard = self.clock.monotonic()
        holes = max(self._samples.cycles(int(self._next["time"])) - 1, 0)
        # A gap longer than the buffer cannot be bridged: the arm has been stopped.
        self._holes = holes if self._target is not None and holes * CYCLE < self.settings.buffer else 0
        return True

    def _commanded(self, command: Command | None) -> bool:
        """Send a command, or the last one again; returns whether a new command was sent."""
        if not self._armed or self._stopped or self._fault:
            return False
        position = self._target if command is None else command.position
        if position is None or not self._opened().send(target(position)):
            return False
        self._target = position
        return command is not None

    def _fault_in(self, record: np.void) -> str:
        reason = self._opened().fault or obstacle(record)
        if reason or self._target is None or self._stopped:
            return reason
        return "the motion was ended at the controller" if int(record["motion"]) == ENDED else ""

    def _silent(self) -> Sample:
        """Sample without a measurement, so that monitors can decide. Raises LinkLost after too long."""
        quiet = self.clock.monotonic() - self._heard
        if quiet > LOST:
            raise LinkLost(
                f"driver franka: nothing from {self.settings.address} for {quiet:.2f} s. Look at cable and "
                "controller"
            )
        return self._samples.of_silence(int(quiet / CYCLE), fault=self._fault, sent=False)

    def _opened(self) -> FciLink:
        if self._link is None:
            raise LinkLost("driver franka is not open")
        return self._link

    def stop(self, level: StopLevel) -> None:
        """Stop the arm: QUICK decelerates within the controller's limits; OFF ends the motion at once.

        After OFF the controller brakes as hard as it can and holds: the FCI cannot switch the torque off.
        """
        if level >= StopLevel.QUICK and self._link is not None:
            self._stopped = True
            self._link.send(OFF if level >= StopLevel.OFF else STOP)

    def close(self) -> None:
        """Let the process stop the arm, after which the controller holds it."""
        if self._link is not None:
            self._link.close()
        self._link = None
        self._armed = self._flowing = False
