"""Gears that give way or have play, and contacts: what they ask of motors; they are distinguished."""

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from scipy import signal

from exidyn.identification.arm.motion import tangent
from exidyn.identification.diagnosis.candidates import backlash, contact_event, joint_elasticity
from exidyn.identification.diagnosis.questions.block_answer import CERTAIN_ODDS
from exidyn.identification.diagnosis.runs.driven import Driven, Unloaded
from exidyn.identification.measurements.gears import bent, loose
from exidyn.identification.preparation.filters import Decimation
from exidyn.identification.simulation.plant import Plant, Transmission

from ...parts.runs.simulated import LEVER, MASS, ROTOR, follow, pendulum, pendulum_values, stiff
from ...parts.small import two_joints

pytestmark = pytest.mark.slow

STEP = 0.002
LINK = MASS * LEVER**2
TIME = STEP * np.arange(2000)


def constant(value):
    return np.full(len(TIME), float(value))


@pytest.mark.parametrize(("frequency", "resonance"), [(2.0, 10.0), (14.0, 10.0)])
def test_an_elastic_gear_answers_a_swing_as_a_resonator(frequency, resonance):
    angular = 2 * np.pi * resonance
    load = np.sin(2 * np.pi * frequency * TIME)
    twist = bent(constant(2.0), constant(0.1 * 2.0 * angular), constant(2.0 * angular**2), load, STEP)
    ratio = frequency / resonance
    gain = 1.0 / (2.0 * angular**2) / abs(1 - ratio**2 + 0.1j * ratio)
    assert np.max(np.abs(twist.value[1000:])) == pytest.approx(gain, rel=0.02)
    assert np.max(np.abs(twist.second[1000:-5])) == pytest.approx(
        gain * (2 * np.pi * frequency) ** 2, rel=0.02
    )


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_link_of_less_than_no_inertia_gains_nothing_from_its_coriolis_torque(way):
    """As in a first fit of an arm with a body of unknown moments: 1e26 times the load, or singular."""
    inertia, coriolis = 0.17 + 0.21 * np.sin(3.0 * TIME), 0.5 * way * np.cos(3.0 * TIME)
    twist = bent(inertia, coriolis, constant(1000.0), np.sin(TIME), STEP)
    assert 0.9 < np.max(np.abs(1000.0 * twist.value)) < 5.0


def test_a_gear_that_cannot_carry_its_load_still_has_a_twist():
    for stiffness in (constant(-10.0), -10.0 + 0.1 * np.sin(TIME)):
        twist = bent(constant(3e-4), constant(1e-3), stiffness, np.sin(TIME) - 6.0, STEP)
        assert np.all(np.isfinite(twist.value))


def test_a_link_floats_through_its_play_as_its_load_pulls_it():
    load = np.where(TIME < 1.0, 3.0, -3.0)
    none, play = constant(0.0), 0.005
    twist = loose(constant(2.0), none, none, load, STEP, play, (40.0, 0.5))
    arrival = TIME[np.flatnonzero((TIME > 1.0) & (twist.value < -play))[0]] - 1.0
    assert arrival == pytest.approx(np.sqrt(2 * (2 * play) * 2.0 / 3.0), abs=2 * STEP)
    np.testing.assert_allclose(twist.value[TIME < 1.0], play)
    np.testing.assert_allclose(twist.value[-100:], -play, rtol=0.1)
    # What it has gained on the way it loses at the teeth.
    assert np.sum(twist.second) * STEP == pytest.approx(0.0, abs=1e-3)


def test_the_tangent_is_that_of_the_torque():
    model, motion = two_joints.model(), two_joints.motion(400, rate=500.0)
    values = two_joints.true_values(model)
    kinematics, _ = model.bodies_apart(values, "")
    along, row, shift = tangent(kinematics, motion), 201, 1e-6
    data = kinematics.createData()
    state = [motion.position[row], motion.velocity[row], motion.acceleration[row]]
    for which, by in enumerate(along):
        moved = [part + shift * (np.arange(2) == 1) * (place == which) for place, part in enumerate(state)]
        change = pin.rnea(kinematics, data, *moved) - pin.rnea(kinematics, data, *state)
        np.testing.assert_allclose(by[1, row], change / shift, rtol=1e-3, atol=1e-4)


def recorded(stiffness, play, swing):
    """A rod about a vertical axis that follows a swept sine: its run, and torque beyond a rigid gear's."""
    model, values = pendulum(axis="z"), pendulum_values(axis="z")
    gear = Transmission(np.array([stiffness]), np.array([0.02 * np.sqrt(stiffness * LINK)]), np.array([play]))
    plant = Plant(model, values, np.ones(1), np.zeros(1), stiff(1, LINK + ROTOR), None, gear)
    rising = np.minimum(TIME, 0.5) / 0.5
    position = (swing * rising * signal.chirp(TIME, 1.0, TIME[-1], 9.0, phi=-90.0))[:, None]
    run = follow(plant, position, np.gradient(position, STEP, axis=0))
    bodies, _ = model.bodies_apart(values, "")
    driven = Driven("", SimpleNamespace(), run.motion, np.zeros_like(position), Unloaded(bodies, run.motion))
    driven = driven.after(model, values)
    return model, driven, run.measured.current[:, 0] - driven.torque[:, 0]


def share(columns, torque):
    """Share of a torque that columns explain below 25 Hz [-]."""
    keep = Decimation.at(1.0 / STEP, 25.0)
    left, right = keep.apply(columns), keep.apply(torque)
    rest = right - left @ np.linalg.lstsq(left, right, rcond=None)[0]
    return 1.0 - float(rest @ rest / (right @ right))


def best(candidates, driven, torque):
    """The shape whose first column explains most, and how much."""
    shares = [(share(one.columns(driven)[:, 0, :1], torque), one) for one in candidates]
    return max(shares, key=lambda pair: pair[0])


def size(candidate, driven, torque):
    """Coefficient of its column by itself."""
    column = candidate.columns(driven)[:, 0, 0]
    return column @ torque / (column @ column)


def test_elasticity_and_play_are_distinguished():
    # 12 Hz on the gear; and teeth of 60 Hz with 3 mrad between them.
    soft = recorded(LINK * (2 * np.pi * 12.0) ** 2, 0.0, 0.02)
    worn = recorded(LINK * (2 * np.pi * 60.0) ** 2, 3e-3, 0.02)
    for model, driven, torque in (soft, worn):
        # Of a stiffer gear a multiple explains as much: the size of the effect tells them apart.
        sized = [one for one in joint_elasticity.gears(model) if 0.5 < size(one, driven, torque) < 2.0]
        elastic_share, spring = best(sized or joint_elasticity.gears(model), driven, torque)
        hard = [one for one in backlash.plays(model) if "resonance" not in one.shape]
        loose_share, gap = best(hard, driven, torque)
        if torque is soft[2]:
            assert elastic_share > 0.9 > 0.5 > loose_share
            assert spring.shape["resonance"] == pytest.approx(12.0, rel=joint_elasticity.STEP - 1.0)
        else:
            assert loose_share > 0.8 > 0.5 > elastic_share
            assert gap.shape["gap"] == pytest.approx(3e-3, rel=0.25)


def test_an_elastic_gear_with_play_is_neither_alone():
    model, driven, torque = recorded(LINK * (2 * np.pi * 16.0) ** 2, 6e-3, 0.05)
    soft = [one for one in backlash.plays(model) if "resonance" in one.shape]
    share_of_both, gap = best(soft, driven, torque)
    hard = [one for one in backlash.plays(model) if "resonance" not in one.shape]
    assert share_of_both > best(hard, driven, torque)[0]
    assert share_of_both > best(joint_elasticity.gears(model), driven, torque)[0]
    assert gap.shape["gap"] == pytest.approx(6e-3, rel=0.6)


def test_a_force_on_the_flange_does_the_work_that_its_torques_do():
    model, motion = two_joints.model(), two_joints.motion(5)
    robot, speed = model.robot, np.array([0.3, -0.7])
    places = []
    for ahead in (-1e-6, 1e-6):
        data = robot.kinematics.createData()
        pin.forwardKinematics(robot.kinematics, data, motion.position[2] + ahead * speed)
        places.append(data.oMi[2].act(robot.flange.translation))
    velocity = speed @ contact_event.jacobian(model, motion)[2]
    np.testing.assert_allclose(velocity, (places[1] - places[0]) / 2e-6, atol=1e-8)


def windows(push, white=0.5, seed=3):
    """All windows of a run whose residual is white noise and a force for half a second."""
    model, rate = two_joints.model(), 50.0
    motion = two_joints.motion(1000, rate=rate)
    start, reach = motion.time[400], contact_event.jacobian(model, motion)
    torque = (reach @ np.array(push)) * contact_event.share(motion.time, start, 0.6)[:, None]
    residual = white * np.random.default_rng(seed).normal(size=torque.shape) - torque
    prediction = SimpleNamespace(
        rows=SimpleNamespace(runs=(slice(0, 1000),), weight=np.ones((1000, 2))),
        weighting=SimpleNamespace(independent=np.ones(2), variance=np.full(2, white**2)),
        residual=residual,
    )
    prepared = SimpleNamespace(name="run", decimation=SimpleNamespace(stride=1))
    run = SimpleNamespace(prepared=prepared, motion=motion, centres=np.arange(1000), torque=residual)
    return (
        model,
        run,
        start,
        list(contact_event.contacts(model, prediction, [run], [contact_event.FlangeTorque.of(model, run)])),
    )


def test_a_contact_is_found_where_it_was():
    model, run, start, every = windows([30.0, 0.0, -10.0])
    best = max(every, key=lambda one: one.gain)
    assert abs(best.start + 0.5 * best.duration - start - 0.3) < 0.1
    assert best.among > 200
    assert best.gain > 20.0
    assert best.gain_without_best_joint > 5.0
    assert best.force[[0, 2]] == pytest.approx([30.0, -10.0], rel=0.35)
    columns = contact_event.candidate(model, best).columns(run)
    assert not np.any(columns[run.motion.time < best.start])
    exact = (
        -contact_event.jacobian(model, run.motion)
        * contact_event.share(run.motion.time, best.start, best.duration)[:, None, None]
    )
    np.testing.assert_allclose(columns, exact)


@pytest.mark.parametrize("seed", range(3))
def test_no_contact_is_found_in_noise(seed):
    *_, every = windows([0.0, 0.0, 0.0], seed=seed)
    assert max(one.gain for one in every) < CERTAIN_ODDS
