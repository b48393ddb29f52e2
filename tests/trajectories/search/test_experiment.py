"""Information: what runs show about base parameters, and its gradient by the motion."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import Payload
from exidyn.identification.effects import known_parameters as known
from exidyn.identification.model import Model
from exidyn.trajectories.errors import NothingToIdentify
from exidyn.trajectories.random_motion import random_fourier
from exidyn.trajectories.search.experiment import Experiment, with_drive_gains

from ...parts.plans.excitation import limits, shifted, smooth_model
from ...parts.runs.robots import random_motion, six_axis
from ...parts.small import two_joints

pytestmark = pytest.mark.numerical

NOISE = np.array([0.7, 0.2])


def experiment(**options):
    of = smooth_model(Payload("L", known(3.0, (0.1, 0.0, 0.05))))
    return Experiment.of(of, **{"payloads": ("", "L"), "noise": NOISE} | options)


def motion(seed=0):
    return random_motion(two_joints.arm(), samples=30, seed=seed)


def regressor(of, payload, at):
    """Rows of one run over their noise, without anything of the code under test."""
    full = of.model.regressor(replace(at, payload=payload))
    return (full[:, :, of.base.kept] / NOISE[None, :, None]).reshape(-1, len(of.base.kept))


@pytest.mark.parametrize("share", [1.0, 0.03])
def test_information_is_that_of_the_rows_of_all_runs(share):
    of, at = experiment(), motion()
    rows = np.concatenate([regressor(of, payload, at) for payload in ("", "L")])
    np.testing.assert_allclose(of.information(at, share), share * rows.T @ rows, rtol=1e-10, atol=1e-9)


def test_information_of_runs_and_of_earlier_ones_adds_up():
    of, at = experiment(), motion()
    alone = [replace(of, payloads=(payload,)).information(at) for payload in ("", "L")]
    np.testing.assert_allclose(of.information(at), sum(alone), rtol=1e-12)
    assert not np.allclose(*alone, rtol=0.01)
    more = replace(of, known=alone[1])
    np.testing.assert_allclose(more.information(at, 0.1), alone[1] + 0.1 * sum(alone), rtol=1e-12)


def test_sizes_of_columns_are_those_of_random_motions():
    """Four of them, both runs together, at ten times the samples: rows over their noise, squares added up."""
    of, time = experiment(), np.arange(3.0, 13.0, 0.01)
    motions = [random_fourier(limits(), 16.0, seed=seed).at(time) for seed in range(4)]
    square = sum(np.sum(regressor(of, p, at) ** 2, axis=0) for at in motions for p in ("", "L"))
    np.testing.assert_allclose(of.column_rms(limits()), np.sqrt(square / 4000), rtol=0.03)


@pytest.mark.parametrize("arm", ["two joints", "coupled wrist"])
def test_pull_is_the_gradient_through_every_run(arm):
    of, at = experiment(), motion()
    if arm == "coupled wrist":
        of = Experiment.of(coupled(), ("", "L"), np.arange(1.0, 7.0))
        at = random_motion(of.model.robot, samples=10)
    random = np.random.default_rng(1)
    by = random.normal(size=(len(of.base.kept),) * 2)
    by = by + by.T
    gradient = of.pull(at, by, 0.2)
    shift, along = shifted(lambda moved: np.sum(by * of.information(moved, 0.2)), at, random)
    found = sum(np.sum(getattr(gradient, name) * by_name) for name, by_name in shift.items())
    assert found == pytest.approx(along, rel=1e-6)


def coupled():
    """Six joints with a coupled wrist, a body on the flange, and gains unknown."""
    body = Payload("L", known(3.0, (0.1, 0.0, 0.05)))
    return with_drive_gains(replace(smooth_model(body), robot=six_axis()))


def test_rows_of_a_coupled_wrist_are_its_motors():
    """Of n equal noises; the gain of a drive is that of its motor's torque, which is what it multiplies."""
    of = coupled()
    at = replace(random_motion(of.robot, samples=10), payload="L")
    experiment = Experiment.of(of, ("L",), np.arange(1.0, 7.0))
    nominal = replace(of, effects=of.effects[:-1])
    on_motors = nominal.torque(at, nominal.nominal_values) @ np.linalg.inv(of.robot.coupling)
    columns = np.zeros((10, 6, len(of.names)))
    for drive in range(6):
        columns[:, drive, len(nominal.names) + drive] = on_motors[:, drive]
    regressor = nominal.regressor(at)
    for joint in range(6):
        for drive in range(6):
            share = np.linalg.inv(of.robot.coupling)[joint, drive]
            columns[:, drive, : len(nominal.names)] += share * regressor[:, joint]
    columns = columns[:, :, experiment.base.kept] / np.arange(1.0, 7.0)[:, None]
    np.testing.assert_allclose(experiment.columns(at)[0], columns, rtol=1e-9, atol=1e-9)


def test_there_must_be_something_to_identify():
    with pytest.raises(NothingToIdentify, match="two joints: the model has no effects"):
        Experiment.of(Model(two_joints.arm(), ()))
    with pytest.raises(NothingToIdentify, match="two joints: no parameter .* makes any torque"):
        Experiment.of(Model(two_joints.arm(), (Payload("L"),)), ("",))
