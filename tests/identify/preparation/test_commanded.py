"""What was commanded in a run, where its recording has that."""

from dataclasses import replace

import numpy as np

from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.recordings.recording import Signal

from ...parts.small.two_joint_files import run


def test_a_run_that_was_stopped_before_its_first_command_is_prepared_without():
    whole = run("empty")
    still = Signal(whole.signals["position"].time, whole.signals["position"].values)
    none = Signal(np.zeros(0), np.zeros((0, 2)))
    assert prepare(replace(whole, signals={**whole.signals, "command": still})).commanded is not None
    assert prepare(replace(whole, signals={**whole.signals, "command": none})).commanded is None
