"""Layout of telegrams: which value belongs to which joint, and how joints and axes are related.

Joints are in radians and axes in degrees, possibly with another sign and zero. Corrections are in degrees of
the axes, relative to the start.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import BadSettings
from .config import AXES, EXTERNAL_AXES, RsiConfig
from .settings import RsiSettings


@dataclass(frozen=True)
class Axes:
    """Relation between axes and joints."""

    sign: np.ndarray  # sign of the axes relative to the joints, 1 or -1, shape (n,)
    zero: np.ndarray  # joint positions where the axes show zero, shape (n,) [rad]
    ampere: np.ndarray  # amperes per unit of current of the controller, shape (n,)

    def joints(self, degrees: np.ndarray) -> np.ndarray:
        """Joint positions (n,) [rad] of axis positions [deg]."""
        return self.sign * np.radians(degrees) + self.zero

    def degrees(self, position: np.ndarray) -> np.ndarray:
        """Axis positions (n,) [deg] of joint positions [rad]."""
        return self.sign * np.degrees(position - self.zero)

    def window(self, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Convert limits of corrections [deg] to limits of joint displacements, each (n,) [rad]."""
        ends = np.radians([self.sign * lower, self.sign * upper])
        return ends.min(axis=0), ends.max(axis=0)


def axes_of(settings: RsiSettings) -> Axes:
    """Relation between axes and joints. Raises BadSettings for currents in percent without i_max."""
    ampere = []
    for place, (unit, most) in enumerate(zip(settings.current_unit, settings.i_max, strict=True)):
        if unit == "percent" and not most:
            raise BadSettings(
                f"driver kuka_rsi: current_unit[{place}] is percent; set i_max, the current at 100 percent"
            )
        ampere.append(0.01 * most if unit == "percent" else 1.0)
    return Axes(np.array(settings.sign), np.array(settings.zero), np.array(ampere))


ACTUAL, PROGRAMMED, DELAY = "AIPos", "ASPos", "Delay"
EXTERNAL = ("EIPos", "MECur")
"""Elements of external axes, recorded in the controller's units: degrees or mm, and currents."""


@dataclass(frozen=True)
class Layout:
    """Values read and written for one arm."""

    axes: tuple[str, ...]  # axis of each joint, such as A1
    elements: tuple[str, ...]  # elements with a value for each axis, in reading order
    external: tuple[str, ...]  # names of values of external axes, such as EIPos.E1
    delay: bool  # whether the controller counts answers that came late
    corrections: tuple[str, ...]  # tag of each joint's correction; empty when only listening
    switch: str  # tag of the Stop channel; empty without one

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all values that are read from a telegram."""
        internal = tuple(f"{element}.{axis}" for element in self.elements for axis in self.axes)
        values = internal + self.external
        return (*values, f"{DELAY}.D") if self.delay else values

    @property
    def external_columns(self) -> slice:
        """Indices of the values of external axes in `names`."""
        first = len(self.elements) * len(self.axes)
        return slice(first, first + len(self.external))

    def columns(self, element: str) -> slice | None:
        """Indices of the values of an element in `names`; None if it is not sent."""
        if element not in self.elements:
            return None
        first = self.elements.index(element) * len(self.axes)
        return slice(first, first + len(self.axes))


def layout_of(config: RsiConfig, settings: RsiSettings, joints: int) -> Layout:
    """Layout for an arm. Raises BadSettings if the configuration lacks a required value."""
    axes = _axes(settings, joints)
    where = settings.config or "the configuration"
    wanted = (ACTUAL, PROGRAMMED, settings.current_tag, settings.torque_tag)
    elements = [name for name in wanted if name and all(config.sends(f"{name}.{axis}") for axis in axes)]
    if ACTUAL not in elements:
        raise BadSettings(
            f"{where} does not send the axes' positions: add DEF_{ACTUAL} to SEND, also on the controller"
        )
    tags = tuple(element.tag for element in config.receive)
    return Layout(
        axes=axes,
        elements=tuple(elements),
        external=tuple(
            name
            for name in (f"{element}.{axis}" for element in EXTERNAL for axis in EXTERNAL_AXES)
            if config.sends(name)
        ),
        delay=config.sends(DELAY),
        corrections=() if config.only_send else _corrections(config, settings, axes, where),
        switch=settings.stop_tag if settings.stop_tag in tags and not config.only_send else "",
    )


def _axes(settings: RsiSettings, joints: int) -> tuple[str, ...]:
    axes = tuple(settings.axes.split()) or AXES[:joints]
    if len(axes) != joints or len(set(axes)) != joints or not set(axes) <= set(AXES):
        raise BadSettings(
            f"driver kuka_rsi: axes are '{' '.join(axes)}' for {joints} joints; give each joint one of "
            f"{', '.join(AXES)}. External axes are recorded, and not driven"
        )
    return axes


def _corrections(
    config: RsiConfig, settings: RsiSettings, axes: Sequence[str], where: str
) -> tuple[str, ...]:
    candidates = (settings.correction_tag,) if settings.correction_tag else config.corrections()
    if len(candidates) != 1:
        problem = f"several corrections: {', '.join(candidates)}" if candidates else "no axis corrections"
        raise BadSettings(
            f"{where} receives {problem}. Set correction_tag to the element wired to AXISCORR, or add AK.A1 "
            "to AK.A6 to RECEIVE"
        )
    elements = {element.tag: element for element in config.receive}
    tags = tuple(f"{candidates[0]}.{axis}" for axis in axes)
    for tag in tags:
        element = elements.get(tag)
        if element is None or element.kind != "DOUBLE":
            raise BadSettings(
                f"{where} does not receive {tag} as DOUBLE; add it, there and on the controller"
            )
        if not element.hold:
            raise BadSettings(
                f'{where}: {tag} has HOLDON="0": one late answer would send the arm back to its start '
                'within a cycle. Set HOLDON="1", there and on the controller'
            )
    return tags
