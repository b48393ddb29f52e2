"""What gears that give way add to motors' torque, taken out of recordings before a rigid arm is fitted."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..diagnosis.candidates import kind_of
from ..diagnosis.findings.finding import Evidence, Finding
from ..diagnosis.runs.driven import Driven
from ..recordings.recording import EFFORT, Recording, Signal


def without_gears(
    recording: Recording, role: str, evidence: Evidence, findings: Sequence[Finding]
) -> Recording:
    """The recording as of an arm without those findings that are gears.

    Of all numbers of an arm some would else be fitted to what a swinging link does: its motor's inertia most
    of all.
    """
    gears = [finding for finding in findings if kind_of(finding.effect).gear]
    name = next((one for one in EFFORT if one in recording.signals), "")
    if not gears or not name:
        return recording
    run = Driven.of(evidence.model, recording, role, evidence.filtering).after(evidence.model, evidence.after)
    torque = np.sum([_torque(finding, run) for finding in gears], axis=0)
    effort = recording.signals[name]
    added = np.stack([np.interp(effort.time, run.motion.time, column) for column in torque.T], axis=1)
    gain = np.ones(len(evidence.gain_after)) if name == "torque" else evidence.gain_after
    less = Signal(effort.time, effort.values - added / gain)
    return replace(recording, signals=dict(recording.signals) | {name: less})


def _torque(finding: Finding, run: Driven) -> np.ndarray:
    """What a gear adds along a run, shape (t, n) [N m]."""
    candidate = finding.candidate
    return candidate.columns(run) @ np.array([finding.parameters[one].value for one in candidate.names])
