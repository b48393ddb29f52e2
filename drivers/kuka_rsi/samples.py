"""Samples: a telegram in our units, or that none came."""

import numpy as np

from ..driver import Sample
from ..host_clock import host_time
from .axes import Axes
from .layout import ACTUAL, Layout
from .rsi_settings import RsiSettings
from .telegrams.conversation import lateness
from .telegrams.session import Fresh


class Samples:
    """Makes the samples of one session; their times never go back.

    Args:
        layout: Which values of the telegrams belong to which joint.
        axes: How axes and joints are related.
        settings: Name the elements of currents and torques.
    """

    def __init__(self, layout: Layout, axes: Axes, settings: RsiSettings) -> None:
        self._layout, self._axes, self._settings = layout, axes, settings
        self._unknown = np.full(len(layout.axes), np.nan)
        self._fresh = np.zeros(len(layout.axes), bool)
        self._gone = 0  # cycles reported since the last telegram
        self._time = self._host_time = 0

    def of(self, fresh: Fresh, elapsed: float, events: tuple[str, ...], fault: str, sent: bool) -> Sample:
        """Of a telegram, so long after the first [ms]."""
        numbers = np.array(fresh.telegram.numbers)
        skipped = max(fresh.cycles - 1 - self._gone, 0)
        self._gone = 0
        self._time = round(1e6 * elapsed)
        self._host_time = max(self._host_time + 1, fresh.datagram.arrival)
        return Sample(
            host_time=self._host_time,
            controller_time=self._time,
            position=self._axes.joints(numbers[self._layout.columns(ACTUAL)]),
            velocity=self._unknown,
            current=self._scaled(numbers, self._settings.current_tag, self._axes.ampere),
            torque=self._scaled(numbers, self._settings.torque_tag, self._axes.sign),
            temperature=self._unknown,
            lateness=lateness(fresh),
            skipped=skipped,
            stale=self._fresh,
            events=events,
            fault=fault,
            sent=sent,
        )

    def _scaled(self, numbers: np.ndarray, element: str, scale: np.ndarray) -> np.ndarray:
        columns = self._layout.columns(element)
        return self._unknown if columns is None else numbers[columns] * scale

    def of_silence(self, gone: int, events: tuple[str, ...], fault: str) -> Sample:
        """Of nothing, so many cycles after the last telegram."""
        skipped = max(gone - 1 - self._gone, 0)
        self._gone += 1 + skipped
        self._host_time = max(self._host_time + 1, host_time())
        return Sample(
            self._host_time,
            self._time,
            *(self._unknown,) * 5,
            skipped=skipped,
            stale=~self._fresh,
            events=events,
            fault=fault,
            sent=False,
        )
