"""Currents that are recorded cycles later than positions are named a delay, and by how much."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.diagnosis import diagnose
from exidyn.identification.diagnosis.candidates.time_delay import delays
from exidyn.identification.diagnosis.runs.driven import Driven
from exidyn.identification.diagnosis.runs.rows import CLOCKS
from exidyn.identification.errors import NotRecorded
from exidyn.identification.preparation.filters import earlier
from exidyn.identification.preparation.prepare import ABOVE, REST, Filtering
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.recordings.servo_error import LAW

from ...parts.small.small_diagnosis import nominal_model, recordings

pytestmark = pytest.mark.slow


def later(run: Recording, seconds: float) -> tuple[str, Recording]:
    current = run.signals["current"]
    moved = earlier(current.time, current.values, np.full(2, -seconds))
    return run.settings["role"], replace(run, signals={**run.signals, "current": Signal(current.time, moved)})


@pytest.mark.long
def test_currents_that_come_late_are_a_delay_of_all_drives():
    seconds = 0.013
    runs = [later(run, seconds) for run in recordings(spring=0.0)]
    [finding] = diagnose(nominal_model(), runs, "late").findings
    assert (finding.effect, finding.joints) == ("time_delay", ())
    delay = finding.parameters["delay"]
    assert delay.value == pytest.approx(seconds, abs=3e-4)
    assert abs(delay.value - seconds) < CLOCKS + 3 * delay.std  # clocks may be as wrong as that


def test_a_torque_computed_from_the_positions_has_no_delay_and_no_noise_of_standstill():
    run = next(iter(recordings(spring=0.0)))
    signals = {name: signal for name, signal in run.signals.items() if name != "current"}
    run = replace(run, signals=signals | {"torque": run.signals["current"]})
    measured, computed = (
        Driven.of(nominal_model(), replace(run, settings=settings), "identify", Filtering())
        for settings in ({}, {LAW: "servos of a file"})
    )
    assert (measured.prepared.noise_source, computed.prepared.noise_source) == (REST, ABOVE)
    for candidate in delays(nominal_model()):
        assert np.any(candidate.columns(measured))
        with pytest.raises(NotRecorded, match="computed"):
            candidate.columns(computed)
