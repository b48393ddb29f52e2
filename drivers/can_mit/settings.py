"""Settings of motors with the MIT frame, their consistency, and the metadata of a recording."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..can.can_bus import CanSettings, bus_load
from ..driver import Arm, Info
from ..errors import BadSettings
from ..settings import setting
from .damiao import TIMEOUT_UNIT, MotorData
from .mit_frame import DAMIAO, KD, KP, MODELS, T_MOTOR, Motor, Ranges, State, error_text

OWN = {"Damiao": DAMIAO, "T-Motor": T_MOTOR}
"""Maker, which replaces the model where the user sets the ranges."""


@dataclass(frozen=True)
class MitSettings(CanSettings):
    """Addresses, gains and units of the motors."""

    model: tuple[str, ...] = setting(..., "model of the motor", choices=(*MODELS, *OWN))
    ids: tuple[int, ...] = setting(..., "identifier of commands to the motor (ESC_ID)", low=1, high=0x7FE)
    kp: tuple[float, ...] = setting(..., "stiffness", unit="N m/rad", low=0.0, high=KP)
    kd: tuple[float, ...] = setting(..., "damping", unit="N m s/rad", low=0.0, high=KD)
    masters: tuple[int, ...] = setting(0, "identifier of answers of the motor (MST_ID)", low=0, high=0x7FE)
    sign: tuple[int, ...] = setting(1, "-1 where the motor counts against the joint", choices=(1, -1))
    zero: tuple[float, ...] = setting(0.0, "position of the joint at motor zero", unit="rad")
    position_range: tuple[float, ...] = setting(
        0.0, "largest position in a frame, PMAX; 0 is the model's", unit="rad", low=0.0, high=1e3
    )
    velocity_range: tuple[float, ...] = setting(
        0.0, "largest velocity, VMAX; 0 is the model's", unit="rad/s", low=0.0, high=1e3
    )
    torque_range: tuple[float, ...] = setting(
        0.0, "largest torque, TMAX; 0 is the model's", unit="N m", low=0.0, high=1e3
    )
    current_range: tuple[float, ...] = setting(
        0.0, "T-Motor: largest current in an answer; 0 reads torque", unit="A", low=0.0, high=1e3
    )
    torque_constant: tuple[float, ...] = setting(
        0.0, "torque constant at the output; 0 is unknown", unit="N m/A", low=0.0, high=1e3
    )
    dead_man: float = setting(
        0.2, "Damiao: silence of the host after which motors switch off", unit="s", low=0.02, high=10.0
    )

    def motors(self, names: tuple[str, ...]) -> list[Motor]:
        return [self._motor(joint, name) for joint, name in enumerate(names)]

    def _motor(self, joint: int, name: str) -> Motor:
        model = self.model[joint]
        family, usual = MODELS.get(model) or (OWN[model], Ranges(0.0, 0.0, 0.0))
        user = (self.position_range[joint], self.velocity_range[joint], self.torque_range[joint])
        commanded = Ranges(*(value or default for value, default in zip(user, usual, strict=True)))
        ampere = self.current_range[joint]
        return Motor(
            name=f"{name} (motor {self.ids[joint]})",
            number=self.ids[joint],
            master=self.masters[joint],
            family=family,
            commanded=commanded,
            answered=commanded._replace(torque=ampere) if ampere else commanded,
            kp=self.kp[joint],
            kd=self.kd[joint],
        )

    @property
    def frames(self) -> list[int]:
        return [8] * (2 * len(self.ids))

    @property
    def apart(self) -> float:
        """Maximum time between the commands to two successive motors [s]."""
        return bus_load([8, 8], 1.0, self.bitrate)


def require_sound(s: MitSettings, arm: Arm) -> None:
    """Raise BadSettings if the settings do not fit each other, the arm or the bus."""
    _require_distinct(s)
    for joint, motor in enumerate(s.motors(arm.joints)):
        if 0.0 in motor.commanded:
            raise BadSettings(
                f"{motor.name}: set position_range, velocity_range and torque_range (PMAX, VMAX, TMAX of the "
                f"motor), or one of the models {', '.join(MODELS)}"
            )
        if s.current_range[joint] and motor.family is DAMIAO:
            raise BadSettings(f"{motor.name}: current_range is for T-Motor; Damiao motors answer with torque")
        _require_within(s, arm, joint, motor)
    s.require_bus()


def _require_distinct(s: MitSettings) -> None:
    """Raise BadSettings unless answers identify their motor by identifier or by the half byte in them."""
    seen: dict[tuple[int, int], int] = {}
    for number, master in zip(s.ids, s.masters, strict=True):
        other = seen.setdefault((master, number & 0x0F), number)
        if list(s.ids).count(number) > 1 or other != number:
            raise BadSettings(
                f"motors {other} and {number} cannot be distinguished: each needs its own id, and those "
                "with the same master an id that differs in its last hexadecimal digit"
            )


def _require_within(s: MitSettings, arm: Arm, joint: int, motor: Motor) -> None:
    ends = np.array([arm.position_lower[joint], arm.position_upper[joint]]) - s.zero[joint]
    far = float(np.abs(ends[np.isfinite(ends)]).max(initial=0.0))
    for value, most, subject, unit in (
        (far, motor.commanded.position, "its position limits are up to", "rad from motor zero"),
        (float(arm.velocity[joint]), motor.commanded.velocity, "its velocity limit is", "rad/s"),
    ):
        if np.isfinite(value) and value > most:
            raise BadSettings(
                f"{motor.name}: {subject} {value:g} {unit}, limit of a frame {most:g}. Narrow the arm's "
                "limits, or check zero and ranges"
            )


def info_of(
    s: MitSettings,
    motors: Sequence[Motor],
    motor_data: Sequence[MotorData],
    states: Sequence[State],
    to_current: np.ndarray,
    to_torque: np.ndarray,
) -> Info:
    """Metadata that explain the measurements later, and warnings.

    `to_current` [A] and `to_torque` [N m], shape (n,), are per unit of an answer's effort; NaN where unknown.
    """
    known = {
        "position": True,
        "velocity": True,
        "current": np.isfinite(to_current).any(),
        "torque": np.isfinite(to_torque).any(),
        "temperature": any(np.isfinite(state.temperature) for state in states),
    }
    timeout = round(s.dead_man / TIMEOUT_UNIT)
    return Info(
        cycle=s.cycle,
        clock="host",
        signals=tuple(name for name, is_known in known.items() if is_known),
        dead_man=f"switched off {s.dead_man:g} s after the host's last frame: an arm without "
        f"brakes drops (TIMEOUT {timeout} read back)"
        if all(data.guarded for data in motor_data)
        else "",
        settings=_explained(s, motors, motor_data),
        warnings=(*(text for data in motor_data for text in data.warnings), *_warnings(s, motors, states)),
    )


def _warnings(s: MitSettings, motors: Sequence[Motor], states: Sequence[State]) -> Iterator[str]:
    for motor, state, ampere in zip(motors, states, s.current_range, strict=True):
        if motor.family is T_MOTOR:
            yield (
                f"{motor.name} keeps following its last command if this computer falls silent; and it "
                "reports its state only when commanded with zero gains, so that opening makes it limp"
            )
            if not ampere:
                yield (
                    f"{motor.name}: its answer is read as torque up to {motor.answered.torque:g} N m; "
                    "makers' papers disagree whether it is a current: set current_range to read a current"
                )
        if text := error_text(motor.family, state.error):
            yield f"{motor.name} has {text}; it is cleared when the motors are switched on"


def _explained(s: MitSettings, motors: Sequence[Motor], motor_data: Sequence[MotorData]) -> dict[str, str]:
    explained = {
        "bus": s.bus,
        "time of a sample": "when the first command was handed to the bus; a motor measures when its own "
        f"arrives, on a wire up to {1e3 * s.apart:.2f} ms after the one before it",
    }
    for joint, (motor, data) in enumerate(zip(motors, motor_data, strict=True)):
        ranges = motor.answered
        effort = "current in A" if s.current_range[joint] else "torque in N m"
        explained[motor.name] = ", ".join(
            [
                f"{motor.family.name} {s.model[joint]}, answers with {effort}",
                f"steps of {2.0 * ranges.position / 65535:.3g} rad, "
                f"{2.0 * ranges.velocity / 4095:.3g} rad/s and {2.0 * ranges.torque / 4095:.3g}",
                f"kp {motor.kp:g}, kd {motor.kd:g}, sign {s.sign[joint]}, zero {s.zero[joint]:g} rad",
                *data.facts,
            ]
        )
    return explained
