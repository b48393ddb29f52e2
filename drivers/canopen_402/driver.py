"""CiA 402 drives on a CAN bus in cyclic synchronous position mode: the host interpolates and keeps the clock.

Drives are found and set up with `canopen`; from then on, only raw frames are used (`frames`). In each cycle
the host sends the targets, then SYNC, at which every drive takes its target and measures, and waits for the
measurements. Nothing is stored in a drive beyond its next power-off.
"""

import numpy as np

from ..can.can_driver import CanDriver
from ..driver import Arm, Info, StopLevel
from ..errors import NotReady
from ..values import Command, Resting
from . import cia402 as c
from .frames import Frames
from .network import DriveNetwork, SetUp
from .settings import BEATS, RANGE, CanopenSettings, require_sound
from .setup import DriveData

ENABLING = 5.0
"""Maximum time to enable the drives, including their brakes [s]."""
REACTIONS = {1: "fault", 2: "switch-off", 3: "quick stop"}
"""Value of 0x6007 -> reaction of a drive to a silent host."""


class Canopen402(CanDriver[Frames]):
    """CiA 402 drives in cyclic synchronous position mode."""

    Settings = CanopenSettings
    settings: CanopenSettings

    def __init__(self, settings: CanopenSettings, arm: Arm) -> None:
        super().__init__(settings, arm)
        require_sound(settings, arm)
        self._names = [f"{joint} (node {n})" for joint, n in zip(arm.joints, settings.nodes, strict=True)]
        self._per_radian, self._zero = settings.per_radian.tolist(), list(settings.zero)
        self._network: DriveNetwork | None = None
        self._unit = self._samples.unknown
        self._kind = ""
        self._resting = Resting(arm.dof)

    def open(self) -> Info:
        """Set up all drives and start the network; motors stay without power."""
        s = self.settings
        bus = self._open_bus()
        try:
            self._network = DriveNetwork(bus, s, self._names)
            setup = self._network.set_up_all(self.arm)
        except BaseException:
            self.close()
            raise
        self._kind = setup.kind
        unit = np.array([effort.unit for effort in setup.efforts]) * np.array(s.sign)
        self._unit = unit if setup.kind == "current" else unit * np.array(s.gear)
        self._round = Frames(
            bus,
            s.nodes,
            self._names,
            s.host_node,
            s.dead_man / BEATS,
            s.heartbeat,
            [effort.entry for effort in setup.efforts],
            [drive.beats for drive in setup.drives],
        )
        return self._info(setup)

    def arm_drives(self) -> None:
        """Bring all drives from any state to operation enabled, holding their positions."""
        frames = self._opened()
        self._begin_commands(frames)
        self._level, self._resting = 0, Resting(self.arm.dof)
        end = self.clock.monotonic() + ENABLING
        while not (frames.commanding and _all_enabled(frames)):
            self._cycles(frames, 1)
            position = self._position(frames)
            for joint in np.flatnonzero(frames.fresh):
                self._resting.add(int(joint), float(position[joint]))
            if frames.fault or self.clock.monotonic() > end:
                why = frames.fault or self._not_enabled(frames)
                self.stop(StopLevel.OFF)
                raise NotReady(why)
            if all(status >= 0 for status in frames.status):
                self._armed = True
                self._request_enabling(frames)

    def held(self) -> np.ndarray | None:
        if not self._armed:
            return None
        return self.settings.from_counts(np.array(self._opened().target, float))

    @property
    def sent_to_read(self) -> str:
        """Drives answer SYNC in any state."""
        return "SYNC, and the set-up of a run over SDO; no controlword and no target"

    def states(self) -> tuple[str, ...]:
        """State of each drive by its last statusword, in the terms of CiA 402."""
        frames = self._opened()
        return tuple("" if word < 0 else c.state(word) for word in frames.status)

    def stop(self, level: StopLevel) -> None:
        """Stop the drives: QUICK is a quick stop by 0x605A, OFF disables the voltage."""
        frames = self._round
        if frames is None or not frames.commanding or level <= max(self._level, StopLevel.BRAKE):
            return
        self._level = level
        word = c.QUICK_STOP if level == StopLevel.QUICK else c.NO_VOLTAGE
        frames.control = [word] * self.arm.dof
        frames.send()
        frames.synchronize()

    def _info(self, setup: SetUp) -> Info:
        s, drives = self.settings, setup.drives
        guarded = all(drive.guarded for drive in drives)
        return Info(
            cycle=s.cycle,
            clock="host",
            signals=("position", setup.kind),
            dead_man=f"{REACTIONS[s.abort_connection]} {s.dead_man:g} s after the host's last heartbeat "
            "(0x1016 and 0x6007 read back)"
            if guarded
            else "",
            settings=self._explain(setup),
            warnings=(
                *setup.warnings,
                *(text for drive in drives for text in drive.warnings),
                *self._suspicious_positions(drives),
            ),
        )

    def _suspicious_positions(self, drives: list[DriveData]) -> list[str]:
        position = self.settings.from_counts(np.array([drive.position for drive in drives]))
        lower, upper = self.arm.position_lower, self.arm.position_upper
        return [
            f"{name} stands at {position[joint]:.4f} rad, beyond its limits {lower[joint]:.4f} to "
            f"{upper[joint]:.4f}: are counts, gear, sign and zero right?"
            for joint, name in enumerate(self._names)
            if not lower[joint] <= position[joint] <= upper[joint]
        ]

    def _explain(self, setup: SetUp) -> dict[str, str]:
        s = self.settings
        meaning = {
            "current": f"amperes {s.ampere}, of the object and by the scale beside each joint",
            "torque": "of the motor by the object and scale beside each joint, times gear: at the joint",
        }
        explained = {
            "bus": s.bus,
            "time of a sample": "when SYNC was handed to the bus; on a wire it follows the targets, and "
            f"drives measure up to {1e3 * s.behind:.2f} ms later",
            setup.kind: meaning[setup.kind],
        }
        for name, drive, scale, zero in zip(self._names, setup.drives, self._per_radian, s.zero, strict=True):
            explained[name] = f"{scale:.9g} counts/rad, {zero:g} rad at zero; {', '.join(drive.facts)}"
        return explained

    def _request_enabling(self, frames: Frames) -> None:
        """Choose the controlword of each drive's next transition, with its resting position as the target."""
        if not all(map(self._resting.known, range(self.arm.dof))):
            return
        counts = self.settings.to_counts(np.array([self._resting.position(j) for j in range(self.arm.dof)]))
        for joint in range(self.arm.dof):
            state = frames.state(joint)
            if state != c.ENABLED or not frames.commanding:
                frames.target[joint] = round(counts[joint])
            if state == c.FAULT:  # the rising edge resets it
                bit_is_set = frames.control[joint] == c.RESET_FAULT
                frames.control[joint] = c.NO_VOLTAGE if bit_is_set else c.RESET_FAULT
            else:
                frames.control[joint] = c.TOWARDS_ENABLED.get(state, frames.control[joint])
        frames.commanding = True

    def _not_enabled(self, frames: Frames) -> str:
        joints = range(self.arm.dof)
        moving = (j for j in joints if not self._resting.known(j))
        joint = next((j for j in joints if not _enabled(frames.status[j])), next(moving, 0))
        name, word, state = self._names[joint], frames.status[joint], frames.state(joint)
        if word < 0:
            return f"{name} does not answer SYNC, though its PDOs are set up. Is it still there?"
        if not self._resting.known(joint):
            return (
                f"{name} is not enabled: {self._resting.doubt(joint)}. Let the arm stand still, and look at "
                "its encoder"
            )
        text = f"{name} stays in {state} (statusword 0x{word:04X}) for {ENABLING:g} s"
        if state == c.FAULT and self._network is not None:
            return f"{text}: {self._network.error_of(joint)}. Remove the cause, then try again"
        if state == c.STOPPING:
            return f"{text} and cannot be enabled from there. Hold the arm and switch its power off and on"
        return (
            f"{text}, sent 0x{frames.control[joint]:02X}. Is its power stage on, and are its enable and "
            "safe-torque-off inputs closed?"
        )

    def _set_target(self, frames: Frames, command: Command) -> None:
        where = zip(command.position.tolist(), self._zero, self._per_radian, strict=True)
        counts = [(position - zero) * scale for position, zero, scale in where]
        if all(abs(count) < RANGE - 1 for count in counts):  # false for NaN
            frames.target = [round(count) for count in counts]
        elif not frames.fault:
            frames.fail(f"a command is not a position: {command.position}")

    def _check_answers(self, frames: Frames) -> None:
        if _all_enabled(frames):
            return
        for joint, status in enumerate(frames.status):
            if not _enabled(status):
                lost = ": its power stage has lost its supply (voltage enabled is off)"
                frames.fail(
                    f"{self._names[joint]}: left operation enabled for {frames.state(joint)} "
                    f"(statusword 0x{status:04X}){'' if status & c.VOLTAGE else lost}"
                )

    def _measured(self, frames: Frames) -> dict[str, np.ndarray]:
        effort = np.array(frames.effort, float) * self._unit
        return {"position": self._position(frames), self._kind: effort}

    def _position(self, frames: Frames) -> np.ndarray:
        counts = zip(frames.position, self._per_radian, self._zero, strict=True)
        return np.array([count / scale + zero for count, scale, zero in counts])

    def _stopped(self, frames: Frames) -> bool:
        return not any(map(_enabled, frames.status))

    def _detach(self, frames: Frames) -> None:
        frames.leave()


def _enabled(status: int) -> bool:
    return status >= 0 and status & 0x6F == 0x27


def _all_enabled(frames: Frames) -> bool:
    return all(map(_enabled, frames.status))
