"""Recording: measurements of one run of one arm, with events, timing and the controller's state."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from ..arm.rigid_regressor import INERTIAL
from ..arm.robot import Robot
from ..effects import known_parameters
from ..errors import RecordingError, WrongShape
from ..model import Model
from ..notebook import InNotebook, counted, optional
from ..robot_files.robot_file import read_model

SIGNALS: dict[str, str] = {
    "position": "rad",
    "velocity": "rad/s",
    "current": "A",
    "torque": "N m",
    "temperature": "degC",
    "link_position": "rad",
    "command": "rad",
    "command_velocity": "rad/s",
}
"""Signals of each joint, and their units; for prismatic joints, read m for rad and N for N m.

`current` is that of the motor, and `torque` that of the joint; `position` comes from the motor's encoder and
`link_position` from a second encoder behind the gear, both in joint coordinates; `command` and
`command_velocity` are commanded values."""
RATE_AGREES = 0.02
"""Maximum relative difference between the mean sampling rate and one over the median period."""
SIMULATED = "simulated"
"""Setting of a simulated run; its text names the model."""
JOG = "jog"
"""Setting of a run in which one joint was moved slowly; its text is the joint and the distance."""
EFFORT = ("current", "torque")
"""Signals of which a recording needs at least one."""


def _to_nanoseconds(time: np.ndarray) -> np.ndarray:
    """Times [s], rounded to whole nanoseconds as in files; the checks find times that are not finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.array(np.rint(np.asarray(time, float) * 1e9) / 1e9)


def interpolated(time: np.ndarray, known: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (t, n) interpolated linearly at other times, (k,) or (k, n) if joints differ, shape (k, n)."""
    times = np.broadcast_to(time.T, (values.shape[1], len(time)))
    columns = zip(times, values.T, strict=True)
    return np.stack([np.interp(at, known, column) for at, column in columns], axis=1)


def _set_arrays(value: object, **arrays: np.ndarray) -> None:
    """Set fields of a frozen dataclass to read-only arrays."""
    for name, array in arrays.items():
        array.setflags(write=False)
        object.__setattr__(value, name, array)


@dataclass(frozen=True, eq=False)
class Signal:
    """One quantity of all joints at its own rate."""

    time: np.ndarray  # time since the start of the run, shape (t,) [s]
    # Values in the unit of `SIGNALS`, shape (t, n); a joint that was not measured is always NaN.
    values: np.ndarray

    def __post_init__(self) -> None:
        time, values = _to_nanoseconds(self.time), np.array(self.values, float)
        if time.ndim != 1 or values.ndim != 2 or len(time) != len(values):
            raise WrongShape(
                f"signal: time has shape {time.shape} and values {values.shape}, expected (t,) and (t, n)"
            )
        _set_arrays(self, time=time, values=values)

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, rows: np.ndarray | slice) -> "Signal":
        return Signal(self.time[rows], self.values[rows])

    def at(self, time: np.ndarray) -> np.ndarray:
        """Values at other times (t,) [s], interpolated linearly, shape (t, n)."""
        return interpolated(time, self.time, self.values)

    @property
    def period(self) -> float:
        """Median time between samples [s]; zero for fewer than two."""
        return float(np.median(np.diff(self.time))) if len(self) > 1 else 0.0

    @property
    def rate(self) -> float:
        """Sampling rate [Hz]: one over the median period, or the mean rate if gaps or jitter matter."""
        if not self.period or self.time[-1] <= self.time[0]:
            return 1.0 / self.period if self.period else 0.0
        mean = (len(self) - 1) / float(self.time[-1] - self.time[0])
        return mean if abs(mean * self.period - 1.0) > RATE_AGREES else 1.0 / self.period


@dataclass(frozen=True)
class KnownPayload:
    """A payload on the flange and its known parameters."""

    name: str = "L"  # name of the payload, which the names of its unknown parameters contain
    # Names in `INERTIAL` and values, about the flange's origin in its axes; all, or (("M", 175.0),).
    known: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        if unknown := [name for name, _ in self.known if name not in INERTIAL]:
            valid = ", ".join(INERTIAL)
            raise RecordingError(
                f"payload {self.name}: unknown parameters {', '.join(unknown)}. Valid: {valid}"
            )
        object.__setattr__(self, "known", tuple((name, float(value)) for name, value in self.known))


@dataclass(frozen=True)
class Event:
    """An event during a run."""

    time: float  # time on the recording's time axis [s]
    kind: str  # kind of the event, such as "driver", "stage", "stop", "late" or "warning"
    text: str  # description in one sentence
    # Joint, value, limit, unit and level of a stop, if known.
    details: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Timing:
    """Timing of the cycles of the control loop, arrays of shape (t,)."""

    time: np.ndarray  # time on the recording's time axis [s]
    lateness: np.ndarray  # delay of the start of each cycle [s]
    skipped: np.ndarray  # number of cycles missed before each cycle
    stage: np.ndarray  # stage of the run, as an index into `stages`
    stages: tuple[str, ...] = ()  # names of the stages

    def __post_init__(self) -> None:
        arrays = {name: np.array(getattr(self, name), np.int64) for name in ("skipped", "stage")}
        arrays |= {"time": _to_nanoseconds(self.time), "lateness": np.array(self.lateness, float)}
        for name, array in arrays.items():
            if array.shape != np.shape(self.time):
                raise WrongShape(f"timing: {name} has shape {array.shape}, time {np.shape(self.time)}")
        _set_arrays(self, **arrays)

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True, eq=False)
class ControllerState:
    """State that the controller reported, such as its safety mode."""

    time: np.ndarray  # time on the recording's time axis, shape (t,) [s]
    values: np.ndarray  # values with one column per name, shape (t, k); NaN if unknown
    words: Mapping[str, Mapping[int, str]]  # name -> meaning of its codes; empty for a plain number

    def __post_init__(self) -> None:
        time, values = _to_nanoseconds(self.time), np.array(self.values, float)
        expected = (*np.shape(time), len(self.words))
        if values.shape != expected:
            raise WrongShape(f"controller state: values have shape {values.shape}, expected {expected}")
        _set_arrays(self, time=time, values=values)

    def __len__(self) -> int:
        return len(self.time)

    def of(self, name: str) -> np.ndarray:
        """Values of a name in `words`, shape (t,)."""
        return np.asarray(self.values[:, list(self.words).index(name)])


@dataclass(frozen=True, eq=False)
class Recording(InNotebook):
    """One run of one arm; `recording_checks.check` reports whether it is plausible."""

    name: str  # name of the run
    model: Model  # nominal model when the run was recorded
    signals: Mapping[str, Signal]  # name in `SIGNALS` -> signal; at least "position" and one of `EFFORT`
    payload: KnownPayload | None = None  # payload on the flange; None if there was none
    trajectory: str = ""  # text of the trajectory's file; empty if there was none
    # Role, controller, source and further information about the run.
    settings: Mapping[str, str] = field(default_factory=dict)
    # Host clock at each position sample, shape (t,) [ns]; None if it was not recorded.
    host_time: np.ndarray | None = None
    events: tuple[Event, ...] = ()  # events in the order of time
    timing: Timing | None = None  # timing of the control loop; None if it was not recorded
    controller: ControllerState | None = None  # state of the controller; None if its driver reads none
    # Properties of the end of the run, by name; empty if unknown.
    outcome: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()  # warnings, one sentence each
    # Whether exidyn wrote the file. Implausible content is then evidence of a fault, and causes a warning; in
    # files of other tools it indicates a wrong unit, and is refused.
    recorded: bool = False

    def __post_init__(self) -> None:
        if unknown := [name for name in self.signals if name not in SIGNALS]:
            valid = ", ".join(SIGNALS)
            raise WrongShape(f"{self.name}: unknown signals {', '.join(unknown)}. Valid: {valid}")
        if "position" not in self.signals or not any(name in self.signals for name in EFFORT):
            servos = ". Of position servos, --effort command takes what is left to the command"
            raise WrongShape(
                f"{self.name}: a recording needs position and one of {', '.join(EFFORT)}; "
                f"it has {', '.join(self.signals) or 'nothing'}{servos if 'command' in self.signals else ''}"
            )
        for name, signal in self.signals.items():
            if (width := signal.values.shape[1]) != self.robot.dof:
                raise WrongShape(
                    f"{self.name}: {name} has {width} columns, but {self.robot.name} has {self.robot.dof} "
                    f"joints: {', '.join(self.robot.joints)}"
                )
        if self.host_time is not None:
            host_time = np.array(self.host_time, np.int64)
            count = len(self.signals["position"])
            if host_time.shape != (count,):
                raise WrongShape(
                    f"{self.name}: host_time has shape {host_time.shape}, expected one for each of {count} "
                    "position samples"
                )
            _set_arrays(self, host_time=host_time)

    @classmethod
    def from_arrays(
        cls,
        robot: Model | pin.Model | Path | str,
        t: Any,
        q: Any,
        *,
        torque: Any = None,
        current: Any = None,
        dq: Any = None,
        mass: float | None = None,
        com: Sequence[float] | None = None,
        degrees: bool = False,
        name: str = "arrays",
        **signals: Any,
    ) -> "Recording":
        """Create a recording of one run from arrays.

        Args:
            robot: Nominal model, Pinocchio model, name of a built-in robot, or path of a robot.toml or URDF.
            t: Time of the samples, shape (t,) [s].
            q: Position, shape (t, n) [rad].
            torque: Joint torque, shape (t, n) [N m].
            current: Motor current, shape (t, n) [A].
            dq: Velocity, if it was recorded, shape (t, n) [rad/s].
            mass: Mass of the payload on the flange [kg].
            com: Center of mass of the payload from the flange's origin, in the flange's axes, shape (3,) [m].
            degrees: Whether positions and velocities are in degrees.
            name: Name of the run.
            signals: Further signals in `SIGNALS`: temperature, command, link_position.

        Example:
            >>> Recording.from_arrays("arm.urdf", t, q, torque=torque)

        Raises:
            WrongShape: The shapes of the arrays do not match each other or the robot.
        """
        arrays = {"position": q, "velocity": dq, "torque": torque, "current": current, **signals}
        body = None if mass is None else KnownPayload(known=known_parameters(mass, com))
        model = robot if isinstance(robot, Model) else read_model(robot)
        return cls(name, model, _signals(t, arrays, degrees), payload=body)

    @property
    def robot(self) -> Robot:
        """Robot that was recorded."""
        return self.model.robot

    @property
    def duration(self) -> float:
        """Time from the first to the last position sample [s]."""
        time = self.signals["position"].time
        return float(time[-1] - time[0]) if len(time) else 0.0

    @property
    def simulated(self) -> bool:
        """Whether `exidyn simulate` made the recording, which then is the prediction of a model."""
        return SIMULATED in self.settings

    def __repr__(self) -> str:
        carried = f", payload {self.payload.name}" if self.payload else ""
        size = f"{self.duration:.4g} s, {self.robot.dof} joints{carried}"
        lines = [f"Recording {self.name} of {self.robot.name}: {size}"]
        for name, signal in self.signals.items():
            lines.append(f"  {name:16} {len(signal):8} samples  {signal.rate:.4g} Hz  [{SIGNALS[name]}]")
        if self.warnings:
            lines.append(f"  {counted(len(self.warnings), 'warning')}, the first: {self.warnings[0]}")
        return "\n".join(lines)

    def to_dataframe(self) -> Any:
        """All signals as a pandas table: one row per position sample, columns (signal, joint).

        Signals of other rates are interpolated, and NaN before their first and after their last sample.

        Raises:
            MissingPackage: pandas is not installed.
        """
        pandas, time = optional("pandas", "a table"), self.signals["position"].time
        columns = {
            (name, joint): np.interp(time, signal.time, values, np.nan, np.nan)
            for name, signal in self.signals.items()
            for joint, values in zip(self.robot.joints, signal.values.T, strict=True)
        }
        return pandas.DataFrame(columns, index=pandas.Index(time, name="time [s]"))

    def keeping(self, rows: Mapping[str, np.ndarray]) -> "Recording":
        """Recording with only the selected samples of some signals and its host time; name -> bool (t,)."""
        fewer = {name: self.signals[name][mask] for name, mask in rows.items() if not mask.all()}
        host_time = self.host_time
        if host_time is not None and "position" in fewer:
            host_time = host_time[rows["position"]]
        return replace(self, signals={**self.signals, **fewer}, host_time=host_time)

    def with_warnings(self, *warnings: str) -> "Recording":
        """Recording with more warnings; existing warnings are not repeated."""
        return replace(self, warnings=tuple(dict.fromkeys((*self.warnings, *warnings))))


def _signals(t: Any, arrays: Mapping[str, Any], degrees: bool) -> dict[str, Signal]:
    """Signals from arrays (t, n) by name, on one time axis (t,) [s] that begins at zero; skips None."""
    time = np.asarray(t, float)
    signals = {}
    for name, values in arrays.items():
        if values is None:
            continue
        turned = degrees and SIGNALS.get(name, "").startswith("rad")
        array = np.asarray(values, float) * (np.pi / 180.0 if turned else 1.0)
        if time.ndim != 1 or array.shape[:1] != time.shape or array.ndim > 2:
            raise WrongShape(
                f"{name} has shape {array.shape} and t {time.shape}; expected (t, n) and (t,): one row per "
                "sample, one column per joint"
            )
        signals[name] = Signal(time - time[:1].sum(), array.reshape(len(time), -1))
    return signals
