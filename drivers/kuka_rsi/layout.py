"""Which values of telegrams belong to which joint, and how joints and a controller's axes are related.

Joints are in radians, possibly turning the other way and from another zero; axes are in degrees. Corrections
are axes' degrees from where the arm stood.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import BadSettings
from .config import AXES, EXTERNAL_AXES, RsiConfig
from .settings import RsiSettings


@dataclass(frozen=True)
class Axes:
    """How axes and joints are related, each of shape (n,).

    Attributes:
        sign: 1 or -1.
        zero: Joint's position where the axis shows zero [rad].
        ampere: Amperes in the controller's unit of current.
    """

    sign: np.ndarray
    zero: np.ndarray
    ampere: np.ndarray

    def joints(self, degrees: np.ndarray) -> np.ndarray:
        """Positions of joints (n,) [rad] from those of axes [deg]."""
        return self.sign * np.radians(degrees) + self.zero

    def degrees(self, position: np.ndarray) -> np.ndarray:
        """Positions of axes (n,) [deg] from those of joints [rad]."""
        return self.sign * np.degrees(position - self.zero)

    def window(self, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Limits of corrections [deg] as limits of joints' excursions, each (n,) [rad]."""
        ends = np.radians([self.sign * lower, self.sign * upper])
        return ends.min(axis=0), ends.max(axis=0)


def axes_of(settings: RsiSettings) -> Axes:
    """How axes and joints are related, as set. Raises BadSettings for currents in percent of nothing."""
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
"""Elements of external axes, recorded as they come: degrees or mm, and the controller's currents."""


@dataclass(frozen=True)
class Layout:
    """What is read and written for one arm.

    Attributes:
        axes: Axes of each joint, such as A1.
        elements: Elements with a value for each axis, in the order in which they are read.
        external: Values of external axes, such as EIPos.E1.
        delay: Whether the controller counts answers that came late.
        corrections: Tag of each joint's correction; empty when only listening.
        switch: Tag of the Stop channel; empty for none.
    """

    axes: tuple[str, ...]
    elements: tuple[str, ...]
    external: tuple[str, ...]
    delay: bool
    corrections: tuple[str, ...]
    switch: str

    @property
    def names(self) -> tuple[str, ...]:
        """All that is read of a telegram."""
        own = tuple(f"{element}.{axis}" for element in self.elements for axis in self.axes)
        values = own + self.external
        return (*values, f"{DELAY}.D") if self.delay else values

    @property
    def external_columns(self) -> slice:
        """Where the values of external axes stand among `names`."""
        first = len(self.elements) * len(self.axes)
        return slice(first, first + len(self.external))

    def columns(self, element: str) -> slice | None:
        """Where an element's values stand among `names`; None if it is not sent."""
        if element not in self.elements:
            return None
        first = self.elements.index(element) * len(self.axes)
        return slice(first, first + len(self.axes))


def layout_of(config: RsiConfig, settings: RsiSettings, joints: int) -> Layout:
    """The layout for an arm. Raises BadSettings if the configuration has no place for what is needed."""
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
    found = (settings.correction_tag,) if settings.correction_tag else config.corrections()
    if len(found) != 1:
        what = f"several corrections: {', '.join(found)}" if found else "no axis corrections"
        raise BadSettings(
            f"{where} receives {what}. Set correction_tag to the one wired to AXISCORR, or add AK.A1 to "
            "AK.A6 to RECEIVE"
        )
    elements = {element.tag: element for element in config.receive}
    tags = tuple(f"{found[0]}.{axis}" for axis in axes)
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
