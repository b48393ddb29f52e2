"""Samples: a telegram in our units."""

import numpy as np

from ..driver import Sample
from ..samples import ControllerSamples
from .axes import Axes
from .layout import ACTUAL, Layout
from .rsi_settings import RsiSettings
from .telegrams.conversation import lateness
from .telegrams.session import Fresh


class Samples(ControllerSamples):
    """Makes the samples of one session.

    Args:
        layout: Which values of the telegrams belong to which joint.
        axes: How axes and joints are related.
        settings: Name the elements of currents and torques.
    """

    def __init__(self, layout: Layout, axes: Axes, settings: RsiSettings) -> None:
        super().__init__(len(layout.axes), len(layout.external))
        self._axes, self._actual, self._external = axes, layout.columns(ACTUAL), layout.external_columns
        self._current, self._torque = map(layout.columns, (settings.current_tag, settings.torque_tag))

    def of(self, fresh: Fresh, elapsed: float, events: tuple[str, ...], fault: str, sent: bool) -> Sample:
        """Of a telegram, so long after the first [ms]."""
        numbers = np.array(fresh.telegram.numbers)
        skipped = self._skipped(round(1e6 * elapsed), fresh.datagram.arrival, fresh.cycles)
        return Sample(
            host_time=self._host_time,
            controller_time=self._time,
            position=self._axes.joints(numbers[self._actual]),
            velocity=self.unknown,
            current=self._scaled(numbers, self._current, self._axes.ampere),
            torque=self._scaled(numbers, self._torque, self._axes.sign),
            temperature=self.unknown,
            lateness=lateness(fresh),
            skipped=skipped,
            stale=self.fresh,
            events=events,
            fault=fault,
            sent=sent,
            state=numbers[self._external],
        )

    def _scaled(self, numbers: np.ndarray, columns: slice | None, scale: np.ndarray) -> np.ndarray:
        return self.unknown if columns is None else numbers[columns] * scale
