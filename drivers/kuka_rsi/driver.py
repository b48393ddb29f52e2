"""KUKA controllers by Robot Sensor Interface: the controller asks every 4 or 12 ms, the driver answers.

The controller's clock is the only one. Each telegram has the axes' positions; the answer to it has how far
they should be from where they stood when the program called RSI_MOVECORR (absolute corrections).
"""

import time
from collections.abc import Mapping
from dataclasses import replace
from ipaddress import IPv4Address
from typing import Any

import numpy as np

from ..driver import Arm, Driver, Info, StopLevel
from ..errors import BadSettings, LinkLost
from ..values import Command, Sample
from .config import config_text, standard_config
from .conversation import Conversation, Keeper, Link
from .layout import ACTUAL, axes_of, layout_of
from .probe import Probe
from .samples import Remarks, Samples, info_of, simulated
from .session import Fresh, Session
from .settings import RsiSettings, config_of
from .start import check_start, cycle_of, first_telegrams
from .telegram import Answer, TelegramReader

SILENCE, LONGER = 5, 0.02
"""Cycles without a telegram after which a sample is marked, and longest time beyond one cycle [s]: fewer are
a busy network, and the loop must come round."""
LOOKED_AT = 4
"""Telegrams that are looked at before the first is answered: less than half of what any Timeout bears."""
CLOSING = 1.0
"""How long a controller is given to end RSI after the Stop channel was set [s]."""
USUAL_AXES = 6
"""Of a KUKA arm, where the settings do not list them."""
ENDED = 50
"""Cycles without a telegram after which it has."""


class KukaRsi(Driver):
    """One KUKA controller.

    `open` waits for the first telegrams and answers none of them until the arm is known to stand still where
    its program put it. From then on every telegram is answered, with a correction of zero that holds the arm
    there: at first by a thread, since the controller gives up after `timeout` unanswered cycles and whoever
    is asked to confirm a run needs longer; from the first exchange on by the exchanges. The first of them
    probe what corrections do, and only then is it `ready`.
    """

    Settings = RsiSettings

    def __init__(self, settings: RsiSettings, arm: Arm) -> None:
        super().__init__(settings, arm)
        self._config = config_of(settings)
        self._layout = layout_of(self._config, settings, arm.dof)
        self._axes = axes_of(settings)
        self._cycle = settings.cycle
        self._lower, self._upper = settings.window
        self._limits = np.asarray(self._lower).tolist(), np.asarray(self._upper).tolist()
        self._samples = Samples(self._layout, self._axes, settings)
        self._talk: Conversation | None = None
        self._keeper: Keeper | None = None
        self._start = np.full(arm.dof, np.nan)
        self._remarks: Remarks | None = None
        self._probe: Probe | None = None
        self._fault = ""

    @classmethod
    def controller_file(cls, address: str) -> str:
        try:
            IPv4Address(address)
        except ValueError:
            raise BadSettings(
                f"--for-host {address}: expected this computer's IPv4 address, such as 172.31.1.10"
            ) from None
        return config_text(standard_config(address))

    @classmethod
    def count_joints(cls, table: Mapping[str, Any]) -> int:
        return len(str(table.get("axes", "")).split()) or super().count_joints(table) or USUAL_AXES

    @property
    def sent_to_read(self) -> str:
        """A controller that gets no answers ends its program with an error."""
        if not self._commanding:
            return "nothing (ONLYSEND)"
        ending = ", and Stop at the end, which ends RSI_MOVECORR" * bool(self._layout.switch)
        return f"a correction of zero each cycle, which keeps the arm where its program put it{ending}"

    @property
    def _commanding(self) -> bool:
        return not self._config.only_send

    def open(self) -> Info:
        given, config, layout = self.settings, self._config, self._layout
        address, port = given.bind or config.address, given.port or config.port
        talk = Conversation(
            Link(address, port, given.controller),
            Session(TelegramReader(layout.names), round(1e3 * self._cycle)),
            Answer(config.sentype, config.receive, layout.corrections, layout.switch),
            [0.0] * len(layout.corrections),
            layout.delay,
        )
        try:
            here = f"{address}:{port}"
            first = first_telegrams(talk, LOOKED_AT, given.wait, given.controller, here, self._commanding)
            counting = talk.session.counting
            beginning = check_start(first, layout, None if counting else self._cycle, self._commanding)
            self._cycle = cycle_of(first) if counting else self._cycle
        except BaseException:
            talk.link.close()
            raise
        talk.silent = not self._commanding
        self._talk, self._keeper = talk, Keeper(talk, self._cycle)
        self._start = beginning.start
        self._remarks = Remarks(layout, beginning, given.controller, self._commanding)
        if self._commanding and given.probe:
            actual = layout.columns(ACTUAL)
            assert actual is not None  # without it there is no layout
            room = self._lower, self._upper
            self._probe = Probe(layout.axes, actual, self._cycle, given.timeout, *room)
        self._samples.begin(beginning, self._cycle)
        info = info_of(given, config, layout, self._axes, beginning)
        return simulated(info, self._cycle) if counting else info

    def find(self) -> None:
        """Nothing, for it is the controller that begins, once a person has started it."""

    def open_to_read(self) -> Info:
        info = self.open()
        self._probe = None  # which would move the axes
        return info

    @property
    def ready(self) -> bool:
        """Whether it is known what the controller makes of corrections."""
        return self._probe is None or self._probe.done

    def held(self) -> np.ndarray:
        return self._axes.joints(np.asarray(self._start))

    def exchange(self, command: Command | None) -> Sample:
        """A command beyond the controller's window is not sent and is a fault.

        None is sent before the driver is `ready`. `lateness` is the time from the telegram's arrival to its
        answer, or by how much the telegram itself came late after the one before, whichever is more. Where
        no telegram came, all is stale and the command has not been sent.

        Raises BadSettings for a command where the controller expects no answers, LinkLost after no telegram
        for as long as the controller waits for answers.
        """
        talk = self._taken_over()
        probing = None if self.ready else self._probe
        if probing:
            talk.correct(probing.correction.tolist())
        elif command is not None:
            self._command(talk, command)
        most = max(self._longest - talk.quiet, self._cycle)
        fresh = talk.turn(most)
        if fresh is None:
            return self._silent(talk)
        if probing:
            self._probed(talk, probing, fresh)
        sample = self._sample(talk, fresh)
        return replace(sample, sent=False) if probing and command is not None else sample

    @property
    def _longest(self) -> float:
        """How long a telegram is waited for [s]."""
        return min(SILENCE * self._cycle, self._cycle + LONGER)

    def _taken_over(self) -> Conversation:
        if self._talk is None:
            raise LinkLost("driver kuka_rsi is not open")
        if self._keeper:
            self._keeper.end()
            self._keeper = None
        return self._talk

    def _probed(self, talk: Conversation, probe: Probe, fresh: Fresh) -> None:
        """Go on with the probe, unless the network or the controller did not take the last answer."""
        if not (talk.refused or talk.repeated):
            probe.see(fresh)
        self._fault = self._fault or probe.fault
        if probe.done:
            talk.correct(probe.correction.tolist())

    def _command(self, talk: Conversation, command: Command) -> None:
        """Correct as commanded from the next answer on, if the controller would do it."""
        if not self._commanding:
            raise BadSettings(
                "driver kuka_rsi only listens (ONLYSEND is TRUE): it cannot move the arm. Let the "
                "controller's program move it, or use a configuration with ONLYSEND FALSE"
            )
        if self._fault:
            return
        corrections = (self._axes.degrees(command.position) - self._start).tolist()
        limits = zip(self._limits[0], corrections, self._limits[1], strict=True)
        inside = [low <= correction <= high for low, correction, high in limits]  # what is no number is not
        if not all(inside):
            place = inside.index(False)
            self._fault = (
                f"{self._layout.axes[place]} is commanded {corrections[place]:.4g} degrees from its start; "
                f"the controller takes {self._lower[place]:g} to {self._upper[place]:g} (AXISCORR and "
                "AXISCORRMON)"
            )
            return
        talk.correct(corrections)

    def _sample(self, talk: Conversation, fresh: Fresh) -> Sample:
        self._fault = self._fault or talk.session.restarted
        sent = not (talk.refused or talk.repeated or self._fault)
        known = {"events": self._events(talk, fresh), "fault": self._fault, "sent": sent}
        return self._samples.of_telegram(fresh, talk.session.elapsed, **known)

    def _silent(self, talk: Conversation) -> Sample:
        if talk.quiet > self.settings.timeout * self._cycle:
            raise LinkLost(
                f"no telegram from {self.settings.controller} for {talk.quiet:.2f} s: RSI has ended there. "
                "Look at the pendant's messages, then start the program again"
            )
        gone = int(talk.quiet / self._cycle)
        return self._samples.of_silence(gone, events=self._events(talk, None), fault=self._fault, sent=False)

    def _events(self, talk: Conversation, fresh: Fresh | None) -> tuple[str, ...]:
        probed = self._probe.events() if self._probe else ()
        return (*probed, *self._remarks.on(talk, fresh)) if self._remarks else probed

    def stop(self, level: StopLevel) -> None:
        """QUICK sets the Stop channel, or where there is none, answers no more; OFF answers no more.

        What the STOP object does is set in the RSI context. A controller that gets no answers stops the arm
        after `timeout` cycles with an error, and closes the brakes; until then it holds the last correction.
        """
        if self._talk is None or level < StopLevel.QUICK:
            return
        talk = self._taken_over()
        self._give_up_probe(talk)
        if self._layout.switch:
            talk.stop()
        if level >= StopLevel.OFF or not self._layout.switch:
            self._fall_silent(talk)

    def _give_up_probe(self, talk: Conversation) -> None:
        """Correct nothing where it is not known yet what that does."""
        if self._probe and not self.ready:
            self._probe.give_up()
            talk.correct(self._probe.correction.tolist())

    def _fall_silent(self, talk: Conversation) -> None:
        """Answer no more; a correction that may add up is not what the controller holds then."""
        if self._probe and not self._probe.passed:
            talk.turn(self._longest)
        talk.silent = True

    def close(self) -> None:
        """Set the Stop channel until the controller's program has ended RSI, or answer no more.

        An arm at rest stays there either way: with a Stop channel the program goes on behind
        RSI_MOVECORR, without one it ends in the controller's timeout.
        """
        if self._talk is None:
            return
        talk = self._taken_over()
        self._talk = None
        self._give_up_probe(talk)
        if self._layout.switch and not talk.silent and not talk.session.restarted:
            talk.stop()
            end = time.monotonic() + CLOSING
            while time.monotonic() < end and talk.turn(ENDED * self._cycle):
                pass
        elif not talk.silent:
            self._fall_silent(talk)
        talk.link.close()
