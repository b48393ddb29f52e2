"""Recording: one run of one arm as measured, with events, the loop's timing and the controller's state."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..arm.rigid_regressor import INERTIAL
from ..arm.robot import Robot
from ..errors import RecordingError, WrongShape
from ..model import Model
from ..notebook import InNotebook, counted, optional

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
"""What can be measured on each joint, and its unit; for joints that slide read m for rad and N for N m.

`current` is the motor's, `torque` the joint's; `position` comes from the motor's encoder and `link_position`
from a second one behind the gear, both in joint coordinates; `command` and its velocity were asked for."""
RATE_AGREES = 0.02
"""Share by which samples a second may differ from one over the median period and count as the same."""
SIMULATED = "simulated"
"""Setting of a run that a model made; its text is of what."""
JOG = "jog"
"""Setting of a run in which one joint was moved slowly; its text is which, and how far."""
EFFORT = ("current", "torque")
"""Signals of which a recording needs at least one."""


def _to_nanoseconds(time: np.ndarray) -> np.ndarray:
    """Times [s] as whole nanoseconds, as files keep them; what is no number is found by the checks."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.array(np.rint(np.asarray(time, float) * 1e9) / 1e9)


def _set_arrays(value: object, **arrays: np.ndarray) -> None:
    """Set fields of a frozen dataclass to arrays that nobody changes."""
    for name, array in arrays.items():
        array.setflags(write=False)
        object.__setattr__(value, name, array)


@dataclass(frozen=True, eq=False)
class Signal:
    """One quantity of all joints at its own rate.

    Attributes:
        time: Shape (t,) from the start of the run [s].
        values: Shape (t, n) in the unit of `SIGNALS`; a joint that was not measured is NaN throughout.
    """

    time: np.ndarray
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

    @property
    def period(self) -> float:
        """Median time between samples [s]; zero for fewer than two."""
        return float(np.median(np.diff(self.time))) if len(self) > 1 else 0.0

    @property
    def rate(self) -> float:
        """Samples a second [Hz]: of the median period, or of all where gaps or jitter make that another."""
        if not self.period or self.time[-1] <= self.time[0]:
            return 1.0 / self.period if self.period else 0.0
        mean = (len(self) - 1) / float(self.time[-1] - self.time[0])
        return mean if abs(mean * self.period - 1.0) > RATE_AGREES else 1.0 / self.period


@dataclass(frozen=True)
class KnownPayload:
    """A body on the flange and what is known of it.

    Attributes:
        name: What the columns of its unknown parameters are called after.
        known: Names in `INERTIAL` and values, about the flange's origin in its axes; all, or (("M", 175.0),).
    """

    name: str = "L"
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
    """Something that happened.

    Attributes:
        time: On the recording's axis [s].
        kind: A word: "driver", "stage", "stop", "late", "warning".
        text: A sentence.
        details: Joint, value, limit, unit and level of a stop, where it has them.
    """

    time: float
    kind: str
    text: str
    details: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Timing:
    """How each cycle of the control loop went, arrays of shape (t,).

    Attributes:
        time: On the recording's axis [s].
        lateness: By how much each began too late [s].
        skipped: Cycles that were missed before each.
        stage: What the arm was doing: indices into the names `stages`.
    """

    time: np.ndarray
    lateness: np.ndarray
    skipped: np.ndarray
    stage: np.ndarray
    stages: tuple[str, ...] = ()

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
    """What the controller reported about itself, such as its safety mode.

    Attributes:
        time: Shape (t,) on the recording's axis [s].
        values: Shape (t, k), a column a name; NaN where unknown.
        words: Name -> what its codes mean; nothing for a plain number.
    """

    time: np.ndarray
    values: np.ndarray
    words: Mapping[str, Mapping[int, str]]

    def __post_init__(self) -> None:
        time, values = _to_nanoseconds(self.time), np.array(self.values, float)
        expected = (*np.shape(time), len(self.words))
        if values.shape != expected:
            raise WrongShape(f"controller state: values have shape {values.shape}, expected {expected}")
        _set_arrays(self, time=time, values=values)

    def __len__(self) -> int:
        return len(self.time)

    def of(self, name: str) -> np.ndarray:
        """One of `words`, shape (t,)."""
        return np.asarray(self.values[:, list(self.words).index(name)])


@dataclass(frozen=True, eq=False)
class Recording(InNotebook):
    """One run of one arm; `recording_checks.check` reports whether it is plausible.

    Attributes:
        name: What people call the run.
        model: The nominal robot when the run was recorded.
        signals: Keys from `SIGNALS`; "position" and one of `EFFORT` at least.
        payload: What hung on the flange; None for nothing.
        trajectory: Text of the trajectory's file, if there was one.
        settings: Role, controller, source and whatever else explains the run.
        host_time: Host's clock at each position sample, shape (t,) [ns]; None if it was not recorded.
        events: In order.
        timing: Timing of the control loop; None if that was not recorded.
        controller: Its own state; None where its driver reads none of that.
        outcome: How the run ended, by name; empty if unknown.
        warnings: In sentences.
        recorded: Whether exidyn wrote its file. What cannot be in it is then evidence of what went wrong, and
            a warning; in other people's files it is a wrong unit, and refused.
    """

    name: str
    model: Model
    signals: Mapping[str, Signal]
    payload: KnownPayload | None = None
    trajectory: str = ""
    settings: Mapping[str, str] = field(default_factory=dict)
    host_time: np.ndarray | None = None
    events: tuple[Event, ...] = ()
    timing: Timing | None = None
    controller: ControllerState | None = None
    outcome: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
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
            if (found := signal.values.shape[1]) != self.robot.dof:
                raise WrongShape(
                    f"{self.name}: {name} has {found} columns, but {self.robot.name} has {self.robot.dof} "
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
        robot: "Model | Path | str",
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
        """One run out of arrays.

        Args:
            robot: The nominal arm: a model, the name of a built-in one, or a robot.toml or URDF.
            t: Time of the samples, shape (t,) [s].
            q: Position, shape (t, n) [rad].
            torque: Joint torque, shape (t, n) [N m].
            current: Motor current, shape (t, n) [A].
            dq: Velocity, shape (t, n) [rad/s], where it was recorded.
            mass: Mass of a body on the flange [kg].
            com: Center of mass of that body from the flange's origin, in the flange's axes, shape (3,) [m].
            degrees: Positions and velocities are in degrees.
            name: What to call the run.
            signals: Further ones of `SIGNALS`: temperature, command, link_position.

        Example:
            >>> Recording.from_arrays("arm.urdf", t, q, torque=torque)

        Raises:
            WrongShape: Arrays that do not fit each other or the robot.
        """
        from ..effects import known_parameters
        from ..robot_files.robot_file import read_model
        from .from_arrays import signals_of

        arrays = {"position": q, "velocity": dq, "torque": torque, "current": current, **signals}
        body = None if mass is None else KnownPayload(known=known_parameters(mass, com))
        model = read_model(robot) if isinstance(robot, Path | str) else robot
        return cls(name, model, signals_of(t, arrays, degrees), payload=body)

    @property
    def robot(self) -> Robot:
        """The arm that was recorded."""
        return self.model.robot

    @property
    def duration(self) -> float:
        """Time from the first to the last position sample [s]."""
        time = self.signals["position"].time
        return float(time[-1] - time[0]) if len(time) else 0.0

    @property
    def simulated(self) -> bool:
        """Whether a model made it, by `exidyn simulate`: it shows what that model predicts, and no arm."""
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
        """All signals as a pandas table: a row for each position sample, columns (signal, joint).

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
        """The recording with only those samples of some signals, and of its host time, name -> bool (t,)."""
        fewer = {name: self.signals[name][kept] for name, kept in rows.items() if not kept.all()}
        host_time = self.host_time
        if host_time is not None and "position" in fewer:
            host_time = host_time[rows["position"]]
        return replace(self, signals={**self.signals, **fewer}, host_time=host_time)

    def with_warnings(self, *warnings: str) -> "Recording":
        """The same recording with more warnings; one that is already there is not repeated."""
        return replace(self, warnings=tuple(dict.fromkeys((*self.warnings, *warnings))))
