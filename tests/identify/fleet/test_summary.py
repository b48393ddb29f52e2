"""What is kept of a run that carries a body."""

from dataclasses import replace

import numpy as np

from exidyn.identification.effects import Payload, known_parameters
from exidyn.identification.fleet.kind import Kind
from exidyn.identification.fleet.summary import summarised
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.simulation.simulate import simulate

from ...parts.small import two_joints

BODY = known_parameters(6.0, (0.1, 0.0, 0.1), (0.02, 0.0, 0.0, 0.02, 0.0, 0.02))


def recorded(payload=None):
    plant = two_joints.model(*([Payload("part", BODY)] if payload else []))
    time = np.arange(0.0, 10.0, 0.004)
    values = two_joints.true_values(plant)
    return simulate(
        plant,
        values,
        two_joints.GAIN,
        two_joints.trajectory(10.0).at(time),
        two_joints.model(),
        payload=payload,
    )


def by_load(kind, payload=None):
    """Length of each joint's column of friction by load."""
    factors = summarised(recorded(payload), kind).factors
    places = [kind.base.names.index(name) for name in ("mu1", "mu2")]
    return np.array([np.linalg.norm(factors[joint][:, place]) for joint, place in enumerate(places)])


def test_gears_bear_a_body_that_nobody_knows():
    kind = Kind.of(recorded())
    empty, known, found = (
        by_load(kind, one) for one in (None, KnownPayload("part", BODY), KnownPayload("part"))
    )
    assert np.all(known > 1.3 * empty)
    np.testing.assert_allclose(found, known, rtol=0.05)


def test_what_a_body_could_make_up_says_nothing_of_the_arm():
    kind = Kind.of(recorded())
    values, gain = kind.base.regrouping @ kind.model.nominal_values, kind.gain
    said = summarised(recorded(KnownPayload("part")), kind)
    normal, _ = said.normal(kind, values, gain)
    count = len(values)
    usual, _ = replace(said, known=True).normal(kind, values, gain)
    along = kind.body.T @ normal[:count, :count] @ kind.body
    scale = np.max(np.abs(kind.body.T @ usual[:count, :count] @ kind.body))
    assert np.max(np.abs(along)) < 1e-9 * scale
    assert normal[-1, -1] > 0.0
