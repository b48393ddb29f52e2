"""Reports of a session: metadata at its beginning, then samples and events."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ..driver import Info
from ..host_clock import Clock
from ..samples import ControllerSamples
from ..values import SIGNALS, Sample, any_of
from .config import RsiConfig
from .conversation import Conversation, lateness
from .plausibility import Plausibility
from .session import Fresh
from .settings import ACTUAL, DELAY, PROGRAMMED, Axes, Layout, RsiSettings
from .start import Beginning, warning

MARGIN = 0.05
"""Margin of the reported window inside the controller's [deg]: users of the window count from the measured
position, which differs slightly from the position from which the controller counts."""
SHORT = 10
"""Number of consecutive late answers that a busy computer may give [cycles]; it is KUKA's default Timeout."""


def simulated(info: Info, cycle: float) -> Info:
    """Metadata of a simulator, which has neither a clock nor a timeout."""
    return replace(
        info,
        cycle=cycle,
        clock="host",
        dead_man="",
        settings={**info.settings, "stamps": "a simulator's count of answers; times are this computer's"},
        warnings=(warning(cycle), *info.warnings),
    )


def info_of(
    settings: RsiSettings, config: RsiConfig, layout: Layout, axes: Axes, beginning: Beginning
) -> Info:
    """Metadata that explain the measurements later, and warnings."""
    signals = ["position"]
    signals += ["current"] if layout.columns(settings.current_tag) else []
    signals += ["torque"] if layout.columns(settings.torque_tag) else []
    info = Info(
        cycle=settings.cycle,
        clock="controller",
        signals=tuple(signals),
        settings=_explained(settings, config, layout, beginning),
        warnings=(*beginning.warnings(), *_warnings(settings, config, layout, signals)),
        listens=config.only_send,
        state={name: {} for name in layout.external},
    )
    if config.only_send:
        return info
    lower, upper = settings.window
    window = axes.window(np.minimum(lower + MARGIN, 0.0), np.maximum(upper - MARGIN, 0.0))
    return replace(
        info,
        dead_man=f"the controller stops after {settings.timeout} cycles "
        f"({settings.timeout * settings.cycle:g} s) without an answer, if that is the Timeout in its RSI "
        "context, which cannot be read",
        window_lower=window[0],
        window_upper=window[1],
    )


def _explained(
    settings: RsiSettings, config: RsiConfig, layout: Layout, beginning: Beginning
) -> dict[str, str]:
    explained = {
        "controller": settings.controller,
        "listens_on": f"{settings.bind or config.address}:{settings.port or config.port}",
        "generation": settings.generation,
        "config": settings.config or "none",
        "mode": "log only" if config.only_send else "absolute corrections",
        "axes": " ".join(layout.axes),
        "sign": _listed(settings.sign),
        "zero": f"{_listed(settings.zero)} rad",
        "start": f"{_listed(beginning.start)} deg",
        "start_reference": beginning.reference,
        "position_decimals": str(beginning.decimals),
        "late_answers_at_start": "not sent" if beginning.delay is None else str(beginning.delay),
        "current_unit": " ".join(np.atleast_1d(settings.current_unit)),
        "i_max": f"{_listed(settings.i_max)} A",
    }
    if config.only_send:
        return explained
    lower, upper = settings.window
    return explained | {
        "sentype": config.sentype,
        "corrections": " ".join(layout.corrections),
        "stop_channel": layout.switch or "none",
        "window": f"{_listed(lower)} to {_listed(upper)} deg",
        "timeout": f"{settings.timeout} cycles",
        "probe": str(settings.probe),
    }


def _warnings(settings: RsiSettings, config: RsiConfig, layout: Layout, signals: list[str]) -> Iterator[str]:
    if len(signals) == 1:
        yield "neither currents nor torques are sent: add DEF_MACur to SEND, or import a trace too"
    if (settings.bind or config.address) == "0.0.0.0":
        yield "the driver listens on every network of this computer; set bind to one address of it"
    if config.only_send:
        yield "this computer only listens: start the motion at the controller within a minute"
        return
    if settings.timeout <= SHORT:
        yield (
            f"the controller stops after {settings.timeout} late answers in a row, which a busy computer "
            "may give: set Timeout of the ETHERNET object, and timeout here, to 100"
        )
    if not settings.probe:
        yield (
            "the effect of corrections is not probed before the motion (probe is false): with "
            "RSI_ON(#RELATIVE) the arm runs away"
        )
    if not layout.switch:
        yield (
            "no Stop channel: a quick stop takes until the controller's timeout, and so does the end of a "
            "run, with an error on the pendant"
        )


def _listed(values: object) -> str:
    return " ".join(f"{value:.6g}" for value in np.atleast_1d(np.asarray(values, float)))


class Samples(ControllerSamples):
    """Creates the samples of one session; values that cannot belong to their cycle are NaN and stale."""

    def __init__(self, layout: Layout, axes: Axes, settings: RsiSettings, clock: Clock) -> None:
        super().__init__(len(layout.axes), len(layout.external), settings.cycle, clock)
        self._axes, self._actual, self._external = axes, layout.columns(ACTUAL), layout.external_columns
        self._current, self._torque = map(layout.columns, (settings.current_tag, settings.torque_tag))
        self._names = layout.axes
        self._plausibility: Plausibility | None = None

    def begin(self, beginning: Beginning, cycle: float) -> None:
        """Check the plausibility of measurements from now on, for a cycle [s]."""
        assert self._actual is not None  # `layout_of` requires it
        effort, step = (self._current, self._torque), 10.0**-beginning.decimals
        self._plausibility = Plausibility(self._names, self._actual, effort, step, cycle)

    def of_telegram(self, fresh: Fresh, elapsed: float, **fields: Any) -> Sample:
        """Sample of a telegram, `elapsed` [ms] after the first; `fields` are further fields of the sample."""
        numbers = np.array(fresh.telegram.numbers)
        sample = self.of(
            round(1e6 * elapsed),
            fresh.datagram.arrival,
            fresh.cycles,
            lateness(fresh, self._clock),
            position=self._axes.joints(numbers[self._actual]),
            current=self._scaled(numbers, self._current, self._axes.ampere),
            torque=self._scaled(numbers, self._torque, self._axes.sign),
            state=numbers[self._external],
            **fields,
        )
        return self._without_implausible(sample, numbers, fresh.cycles)

    def _without_implausible(self, sample: Sample, numbers: np.ndarray, cycles: int) -> Sample:
        if self._plausibility is None:
            return sample
        stale = self._plausibility.implausible(numbers, cycles)
        if not any_of(stale):
            return sample
        events = (*sample.events, *self._plausibility.events())
        fields: dict[str, Any] = {"stale": stale, "events": events}
        fields |= {name: np.where(stale, np.nan, getattr(sample, name)) for name in SIGNALS}
        return replace(sample, **fields)

    def _scaled(self, numbers: np.ndarray, columns: slice | None, scale: np.ndarray) -> np.ndarray:
        return self.unknown if columns is None else numbers[columns] * scale


FOLLOWS = 0.1
"""Motion of the programmed pose above which it is reported [deg]."""


class Remarks:
    """Reports notable events of each cycle once."""

    def __init__(self, layout: Layout, beginning: Beginning, controller: str, commanding: bool) -> None:
        self._delay = beginning.delay
        self._start = np.asarray(beginning.start, float).tolist()
        # With corrections, the programmed pose must stand still; without, it is what moves the arm.
        self._programmed = layout.columns(PROGRAMMED) if commanding else None
        self._controller = controller
        self._strange = False

    def on(self, conversation: Conversation, fresh: Fresh | None) -> tuple[str, ...]:
        """Events since the last cycle; `fresh` is None if no telegram came."""
        events = list(conversation.session.events())
        if fresh is not None:
            events += self._late(fresh) + self._moved(fresh)
        if conversation.refused:
            events.append("the network did not take an answer")
        stranger = conversation.link.stranger
        if stranger and not self._strange:
            self._strange = True
            events.append(f"something from {stranger} was ignored: only {self._controller} is accepted")
        return tuple(events)

    def _late(self, fresh: Fresh) -> list[str]:
        if self._delay is None:
            return []
        before, self._delay = self._delay, int(fresh.telegram.numbers[-1])
        if self._delay <= before:
            return []
        answers = "answer" if self._delay == 1 else "answers"
        return [f"the controller counts {self._delay} late {answers}, {before} before ({DELAY})"]

    def _moved(self, fresh: Fresh) -> list[str]:
        if self._programmed is None:
            return []
        pose = fresh.telegram.numbers[self._programmed]
        moved = max(abs(now - start) for now, start in zip(pose, self._start, strict=True))
        if moved <= FOLLOWS:
            return []
        self._programmed = None
        return [
            f"the programmed pose ({PROGRAMMED}) moved by {moved:.3g} degrees: the program moves the arm "
            "too, or this controller counts corrections into it"
        ]
