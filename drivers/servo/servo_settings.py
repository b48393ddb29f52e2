"""Settings of every arm of servos on a serial line."""

from dataclasses import dataclass

from ..settings import joint_setting, setting


@dataclass(frozen=True)
class ServoSettings:
    """Settings that all servo drivers share."""

    port: str = setting(..., 'serial port of the adapter, such as "/dev/ttyUSB0"', kind=str)
    ids: tuple[int, ...] = joint_setting(..., "id of each joint's servo", kind=int, low=0, high=252)
    baudrate: int = setting(1_000_000, "as set in the servos", unit="bit/s", low=9600, high=10_000_000)
    cycle: float = setting(0.002, "time between exchanges", unit="s", low=0.001, high=0.1)
    counts_per_turn: tuple[int, ...] = joint_setting(
        4096, "counts in a turn of the servo", low=1, high=1 << 24
    )
    gear: tuple[float, ...] = joint_setting(
        1.0, "turns of the servo in a turn of the joint", low=1e-3, high=1e4
    )
    sign: tuple[int, ...] = joint_setting(1, "-1 where the servo turns against the joint", choices=(1, -1))
    zero: tuple[int, ...] = joint_setting(
        2048, "count of the servo where the joint's position is zero", low=-(1 << 24), high=1 << 24
    )
    at_end: str = setting(
        "hold", "what servos do after the run: an arm without brakes drops when off", choices=("hold", "off")
    )


def explained(settings: ServoSettings) -> dict[str, str]:
    """The settings as text, to explain the measurements later."""
    return {
        name: " ".join(map(str, value)) if isinstance(value, tuple) else str(value)
        for name, value in vars(settings).items()
    }
