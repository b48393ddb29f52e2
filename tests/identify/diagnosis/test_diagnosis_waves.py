"""Friction that varies with position: by less than there is of it, because friction cannot push."""

import numpy as np

from exidyn.identification.diagnosis.candidates import hypotheses
from exidyn.identification.diagnosis.questions.candidate import Thinned
from exidyn.identification.diagnosis.questions.question import ask
from exidyn.identification.effects.smooth_sign import smooth_sign

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import TRUE
from ...parts.small.small_search import problem, record


def credible_waves(share: float) -> list[float]:
    """Amplitudes of waves that an elbow may have, whose dry friction varies by a share of its mean."""

    def varied(role, motion, current):
        wave = share * TRUE["Fc2"] * smooth_sign(motion.velocity[:, 1]) * np.cos(motion.position[:, 1])
        return current + np.outer(wave, [0.0, 1.0]) / two_joints.GAIN

    at = problem(record(change=varied))
    waves = [one for one in hypotheses("position_dependent_friction", at.model) if one.joints == (1,)]
    pairs = [(one, Thinned.of(one, at.runs)) for one in waves if one.shape.get("harmonic") == 1.0]
    return [float(np.hypot(*answer.values)) for answer in ask(at.without_findings, pairs)]


def test_friction_varies_by_less_than_there_is_of_it():
    [amplitude] = credible_waves(0.6)
    assert abs(amplitude - 0.6 * TRUE["Fc2"]) < 0.1
    assert credible_waves(-3.0) == []
