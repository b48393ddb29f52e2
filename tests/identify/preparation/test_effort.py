"""What a run needs besides positions."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.errors import NotRecorded
from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.recordings.recording import Signal

from ...parts.small.two_joint_files import run


def test_a_run_of_a_controller_that_sent_no_currents_is_refused_in_a_sentence():
    whole = run("empty")
    none = Signal(np.zeros(0), np.zeros((0, 2)))
    signals = {name: signal for name, signal in whole.signals.items() if name != "torque"}
    with pytest.raises(NotRecorded, match="neither motor currents nor torques were recorded"):
        prepare(replace(whole, signals={**signals, "current": none}))


def test_torques_do_where_the_currents_are_empty():
    whole = run("empty")
    none = Signal(np.zeros(0), np.zeros((0, 2)))
    torque = whole.signals["current"]
    assert (
        prepare(replace(whole, signals={**whole.signals, "current": none, "torque": torque})).measures
        == "torque"
    )


def test_a_run_that_was_stopped_before_its_first_command_is_prepared_without():
    whole = run("empty")
    none = Signal(np.zeros(0), np.zeros((0, 2)))
    run_without = prepare(replace(whole, signals={**whole.signals, "command": none}))
    np.testing.assert_array_equal(run_without.motion.position, prepare(whole).motion.position)
