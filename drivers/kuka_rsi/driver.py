"""KUKA controllers by Robot Sensor Interface: the controller asks every 4 or 12 ms, the driver answers.

The controller keeps the only clock. Each telegram contains the positions of the axes. The answer contains
absolute corrections: the desired distances from the positions at which the program called RSI_MOVECORR.
"""

from collections.abc import Mapping
from ipaddress import IPv4Address
from typing import Any

import numpy as np

from ..driver import Arm, Driver, Info, StopLevel
from ..errors import BadSettings, LinkLost
from ..values import Command, Sample
from .config import config_text, standard_config
from .conversation import Conversation, Keeper, Link
from .probe import Probe
from .samples import Remarks, Samples, info_of, simulated
from .session import Fresh, Session
from .settings import ACTUAL, Axes, RsiSettings, config_of, layout_of
from .start import check_start, cycle_of, first_telegrams
from .telegram import Answer, TelegramReader

SILENCE, LONGER = 5, 0.02
"""Number of cycles without a telegram after which a sample is stale, and maximum wait beyond one cycle [s]: a
busy network delays telegrams, but the loop must continue."""
LOOKED_AT = 4
"""Number of telegrams checked before the first is answered: less than half of any Timeout."""
CLOSING = 1.0
"""Maximum time for a controller to end RSI after the Stop channel was set [s]."""
USUAL_AXES = 6
"""Number of axes of a KUKA arm if the settings do not list them."""
ENDED = 50
"""Number of cycles without a telegram after which RSI has ended."""


class KukaRsi(Driver):
    """One KUKA controller.

    `open` waits for the first telegrams and answers none until the arm is known to stand still at its
    programmed pose. From then on every telegram is answered with a correction of zero, which holds the arm.
    At first a thread answers, because the controller stops after `timeout` unanswered cycles and confirming a
    run takes longer; later the exchanges answer. The first exchanges probe the effect of corrections, and
    then the driver is `ready`.
    """

    Settings = RsiSettings

    def __init__(self, settings: RsiSettings, arm: Arm) -> None:
        super().__init__(settings, arm)
        self._config = config_of(settings)
        self._layout = layout_of(self._config, settings, arm.dof)
        self._axes = Axes(settings)
        self._cycle = settings.cycle
        self._lower, self._upper = settings.window
        self._limits = np.asarray(self._lower).tolist(), np.asarray(self._upper).tolist()
        self._samples = Samples(self._layout, self._axes, settings, self.clock)
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
                f"--for {address}: expected this computer's IPv4 address, such as 172.31.1.10"
            ) from None
        return config_text(standard_config(address))

    @classmethod
    def count_joints(cls, table: Mapping[str, Any]) -> int:
        return len(str(table.get("axes", "")).split()) or super().count_joints(table) or USUAL_AXES

    @property
    def sent_to_read(self) -> str:
        """Answers that hold the arm: a controller without answers ends its program with an error."""
        if not self._commanding:
            return "nothing (ONLYSEND)"
        ending = ", and Stop at the end, which ends RSI_MOVECORR" * bool(self._layout.switch)
        return f"a correction of zero each cycle, which keeps the arm where its program put it{ending}"

    @property
    def _commanding(self) -> bool:
        return not self._config.only_send

    def open(self) -> Info:
        settings, config, layout = self.settings, self._config, self._layout
        address, port = settings.bind or config.address, settings.port or config.port
        talk = Conversation(
            Link(address, port, settings.controller, self.clock),
            Session(TelegramReader(layout.names), round(1e3 * self._cycle)),
            Answer(config.sentype, config.receive, layout.corrections, layout.switch),
            [0.0] * len(layout.corrections),
            layout.delay,
        )
        try:
            here = f"{address}:{port}"
            first = first_telegrams(
                talk, LOOKED_AT, settings.wait, settings.controller, here, self._commanding
            )
            counting = talk.session.counting
            beginning = check_start(first, layout, None if counting else self._cycle, self._commanding)
            self._cycle = cycle_of(first) if counting else self._cycle
        except BaseException:
            talk.link.close()
            raise
        talk.silent = not self._commanding
        self._talk, self._keeper = talk, Keeper(talk, self._cycle)
        self._start = beginning.start
        self._remarks = Remarks(layout, beginning, settings.controller, self._commanding)
        if self._commanding and settings.probe:
            actual = layout.columns(ACTUAL)
            assert actual is not None  # `layout_of` requires it
            room = self._lower, self._upper
            self._probe = Probe(layout.axes, actual, self._cycle, settings.timeout, *room)
        self._samples.begin(beginning, self._cycle)
        info = info_of(settings, config, layout, self._axes, beginning)
        return simulated(info, self._cycle) if counting else info

    def find(self) -> None:
        """Do nothing: the controller begins the communication once its program is started."""

    def open_to_read(self) -> Info:
        info = self.open()
        self._probe = None  # the probe would move the axes
        return info

    @property
    def ready(self) -> bool:
        """Whether the effect of corrections is known."""
        return self._probe is None or self._probe.done

    def held(self) -> np.ndarray:
        return self._axes.joints(np.asarray(self._start))

    def exchange(self, command: Command | None) -> Sample:
        """Wait for a telegram and answer it with the command.

        A command outside the controller's window is not sent and is a fault. No command is sent before the
        driver is `ready`. `lateness` is the time from the telegram's arrival to its answer, or the delay of
        the telegram relative to the previous one, whichever is larger. Without a telegram, the sample is
        stale and the command was not sent.

        Raises BadSettings for a command if the controller expects no answers, LinkLost if no telegram has
        come for as long as the controller waits for answers.
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
        self._fault = self._fault or talk.session.restarted
        withheld = probing is not None and command is not None
        sent = not (talk.refused or talk.repeated or self._fault or withheld)
        known = {"events": self._events(talk, fresh), "fault": self._fault, "sent": sent}
        return self._samples.of_telegram(fresh, talk.session.elapsed, **known)

    @property
    def _longest(self) -> float:
        """Maximum time to wait for a telegram [s]."""
        return min(SILENCE * self._cycle, self._cycle + LONGER)

    def _taken_over(self) -> Conversation:
        if self._talk is None:
            raise LinkLost("driver kuka_rsi is not open")
        if self._keeper:
            self._keeper.end()
            self._keeper = None
        return self._talk

    def _probed(self, talk: Conversation, probe: Probe, fresh: Fresh) -> None:
        """Advance the probe, unless the network or the controller did not take the last answer."""
        if not (talk.refused or talk.repeated):
            probe.see(fresh)
        self._fault = self._fault or probe.fault
        if probe.done:
            talk.correct(probe.correction.tolist())

    def _command(self, talk: Conversation, command: Command) -> None:
        """Correct as commanded from the next answer on, if the controller's window allows it."""
        if not self._commanding:
            raise BadSettings(
                "driver kuka_rsi only listens (ONLYSEND is TRUE): it cannot move the arm. Let the "
                "controller's program move it, or use a configuration with ONLYSEND FALSE"
            )
        if self._fault:
            return
        corrections = (self._axes.degrees(command.position) - self._start).tolist()
        limits = zip(self._limits[0], corrections, self._limits[1], strict=True)
        inside = [low <= correction <= high for low, correction, high in limits]  # false for NaN
        if not all(inside):
            place = inside.index(False)
            self._fault = (
                f"{self._layout.axes[place]} is commanded {corrections[place]:.4g} degrees from its start; "
                f"the controller allows {self._lower[place]:g} to {self._upper[place]:g} (AXISCORR and "
                "AXISCORRMON)"
            )
            return
        talk.correct(corrections)

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
        """Stop the arm: QUICK sets the Stop channel, or ends the answers without one; OFF ends the answers.

        The RSI context defines the effect of the STOP object. A controller without answers stops the arm
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
        """Set the corrections to zero if their effect is not known yet."""
        if self._probe and not self.ready:
            self._probe.give_up()
            talk.correct(self._probe.correction.tolist())

    def _fall_silent(self, talk: Conversation) -> None:
        """End the answers, after one more answer if corrections may add up, so that zero is held."""
        if self._probe and not self._probe.passed:
            talk.turn(self._longest)
        talk.silent = True

    def close(self) -> None:
        """Set the Stop channel until the controller's program has ended RSI, or end the answers.

        An arm at rest stays at rest in both cases: with a Stop channel the program continues after
        RSI_MOVECORR, without one it ends by the controller's timeout.
        """
        if self._talk is None:
            return
        talk = self._taken_over()
        self._talk = None
        self._give_up_probe(talk)
        if self._layout.switch and not talk.silent and not talk.session.restarted:
            talk.stop()
            end = self.clock.monotonic() + CLOSING
            while self.clock.monotonic() < end and talk.turn(ENDED * self._cycle):
                pass
        elif not talk.silent:
            self._fall_silent(talk)
        talk.link.close()
