"""Exported models, loaded by the programs they are for, need the same torque; what they lack is reported."""

import json
from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import (
    EFFECTS,
    CoulombFriction,
    CurrentOffset,
    JointSpring,
    Payload,
    RigidBody,
    RotorInertia,
    SpringBalancer,
    StribeckFriction,
    ViscousFriction,
)
from exidyn.identification.errors import FitError, RobotError
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.export.portable import possible
from exidyn.identification.fit.agreement import agreement
from exidyn.identification.fit.estimators.consistent import pseudo_inertia
from exidyn.identification.fit.identified import identified
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import parse_model

from ...parts.runs.robots import random_motion, six_axis, sliding
from ...parts.runs.simulated import known
from ...parts.small.small_fit import fit, other_run, plain_fit
from ..effects.test_effects import default
from ..simulation.test_plant_forces import drawn

pytestmark = pytest.mark.numerical

ROBOTS = {"six axis": six_axis, "sliding": sliding}
BALANCER = SpringBalancer("joint4", 0.7, 0.18, -1.6)
SAYABLE = (RotorInertia(), ViscousFriction(), CoulombFriction(), CurrentOffset(), BALANCER)
SLOWEST = 0.1
"""Of the tested motion [rad/s]: thirty times the velocity over which dry friction reverses."""


def values_of(model):
    """Values that an arm could have: those of `drawn`, and bodies that can exist."""
    values = drawn(model)
    for body in model.inertias:
        values[body] = possible(values[body], 10.0)
    return values


def full(robot, *more):
    """A model of what MuJoCo can represent, and more, at values that could be an arm's."""
    model = Model(robot, (RigidBody(), *SAYABLE, *more))
    return known(model, values_of(model))


def sliding_motion(robot, payload=""):
    """Unrelated samples that stay away from reversals."""
    motion = random_motion(robot, payload=payload)
    sign = np.where(motion.velocity < 0, -1.0, 1.0)
    return replace(motion, velocity=sign * np.clip(np.abs(motion.velocity), SLOWEST, 2.0))


def torque_of(model, motion):
    return model.torque(motion, model.nominal_values)


def in_mujoco(text, motion):
    """Torque (t, n) that the motors of an MJCF arm have to give."""
    model = mujoco.MjModel.from_xml_string(text)
    data, torque = mujoco.MjData(model), np.empty_like(motion.position)
    for row in range(len(motion)):
        data.qpos[:], data.qvel[:] = motion.position[row], motion.velocity[row]
        data.qacc[:] = motion.acceleration[row]
        mujoco.mj_inverse(model, data)
        torque[row] = data.qfrc_inverse - model.actuator_biasprm[:, 0]
    return torque


def in_pinocchio(text, motion):
    """Torque (t, n) of a URDF's bodies and friction."""
    # Pinocchio gives a joint without limits two positions, of which none is tested here.
    model = pin.buildModelFromXML(text.replace('"continuous"', '"revolute"'))
    data = model.createData()
    friction = model.upperDryFrictionLimit
    rows = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    bodies = np.array([pin.rnea(model, data, *row) for row in rows])
    return bodies + model.damping * motion.velocity + friction * np.sign(motion.velocity)


def close(found, expected, share=1e-6):
    np.testing.assert_allclose(found, expected, atol=share * np.abs(expected).max())


@pytest.fixture(params=ROBOTS.values(), ids=ROBOTS.keys())
def robot(request):
    return request.param()


@pytest.mark.parametrize("more", [(), (JointSpring(("joint2", "joint5")),)], ids=["usual", "springs"])
def test_mujoco_needs_the_torque_of_the_model(robot, more):
    model = full(robot, *more)
    motion = sliding_motion(robot)
    portable = Portable.of(model)
    close(in_mujoco(FORMATS["mjcf"].text(portable), motion), torque_of(model, motion))
    assert not [s for s in FORMATS["mjcf"].leaves_out(portable) if "friction" in s or "spring" in s]


@pytest.mark.parametrize("stiffness", [0.0, 300.0])
def test_a_balancer_with_preload_of_either_sign(stiffness):
    robot = six_axis()
    for preload in (-200.0, 0.0, 150.0):
        model = Model(robot, (RigidBody(), BALANCER))
        values = values_of(model)
        values[-2:] = stiffness, preload
        motion = sliding_motion(robot)
        text = FORMATS["mjcf"].text(Portable.of(known(model, values)))
        close(in_mujoco(text, motion), model.torque(motion, values))


def test_dry_friction_in_mujoco_turns_over_the_same_velocity():
    robot = six_axis()
    model = Model(robot, (RigidBody(), RotorInertia(), CoulombFriction(reversal=0.02)))
    still = sliding_motion(robot)[:2]
    slow = np.full_like(still.velocity, 0.002)
    motion = replace(still, position=np.zeros_like(slow), velocity=slow, acceleration=0.0 * slow)
    values = values_of(model)
    without = np.where([name.startswith("Fc") for name in model.names], 0.0, values)
    with_it, bare = (
        in_mujoco(FORMATS["mjcf"].text(Portable.of(known(model, v))), motion) for v in (values, without)
    )
    friction = values[[name.startswith("Fc") for name in model.names]]
    np.testing.assert_allclose((with_it - bare)[0], 0.1 * friction, rtol=1e-3)


def test_pinocchio_needs_the_torque_of_what_urdf_states(robot):
    model = Model(robot, (RigidBody(), ViscousFriction(), CoulombFriction()))
    model = known(model, values_of(model))
    motion = sliding_motion(robot)
    text, missing = (what(Portable.of(model)) for what in (FORMATS["urdf"].text, FORMATS["urdf"].leaves_out))
    if any("gravity" in sentence for sentence in missing):
        # reported, and so to be set by whoever loads it
        upright = robot.kinematics.copy()
        upright.gravity.linear = np.array([0.0, 0.0, -9.81])
        model = replace(model, robot=replace(robot, kinematics=upright))
    close(in_pinocchio(text, motion), torque_of(model, motion))
    assert any("gravity" in sentence for sentence in missing) == (robot.name == "sliding")


@pytest.mark.parametrize("key", EFFECTS)
def test_what_mujoco_does_not_reproduce_is_reported(key):
    robot = six_axis()
    more = () if key in ("link_inertia", "rotor_inertia") else (default(key),)
    model = Model(robot, (RigidBody(), RotorInertia(), *more))
    model = known(model, values_of(model))
    form, portable = FORMATS["mjcf"], Portable.of(model, "L" if key == "payload" else "")
    motion = replace(model.loaded(sliding_motion(robot)), payload="L" if key == "payload" else "")
    expected = torque_of(model, motion)
    wrong = np.abs(in_mujoco(form.text(portable), motion) - expected).max() / np.abs(expected).max()
    reported = [sentence for sentence in form.leaves_out(portable) if sentence.startswith(key)]
    assert (wrong > 1e-5) == bool(reported), wrong
    assert all("up to" in sentence for sentence in reported)


def test_urdf_reports_what_it_lacks():
    missing = "\n".join(FORMATS["urdf"].leaves_out(Portable.of(full(six_axis(), StribeckFriction()))))
    for words in (
        "rotor_inertia: joint1",
        "constant torque",
        "spring_balancer of joint4",
        "stribeck_friction",
    ):
        assert words in missing
    assert "viscous" not in missing


def test_a_robot_file_or_json_is_the_whole_model(robot):
    model = full(robot, StribeckFriction())
    motion = random_motion(robot)
    portable = Portable.of(model)
    back = parse_model(FORMATS["toml"].text(portable))
    np.testing.assert_allclose(torque_of(back, motion), torque_of(model, motion), rtol=1e-9, atol=1e-9)
    assert FORMATS["toml"].leaves_out(portable) == FORMATS["json"].leaves_out(portable) == []
    model = full(robot, StribeckFriction(joints=None))
    motion = random_motion(robot)
    table = json.loads(FORMATS["json"].text(Portable.of(model)))
    np.testing.assert_allclose(
        torque_of(rebuilt(table), motion), torque_of(model, motion), rtol=1e-9, atol=1e-9
    )
    assert table["joints"][0]["limits"]["torque"] is None


def rebuilt(table):
    """A model from nothing but the JSON."""
    kinematics, joints = pin.Model(), {None: 0}
    kinematics.gravity.linear = np.array(table["gravity"])
    for row in table["joints"]:
        kind = {"revolute": pin.JointModelRevoluteUnaligned, "prismatic": pin.JointModelPrismaticUnaligned}
        place = pin.SE3(np.array(row["rotation"]), np.array(row["origin"]))
        joint = kind[row["kind"]](np.array(row["axis"]))
        index = joints[row["name"]] = kinematics.addJoint(joints[row["parent"]], joint, place, row["name"])
        link = row["link"]
        about = np.array(link["inertia_about_center_of_mass"])
        body = pin.Inertia(link["mass"], np.array(link["center_of_mass"]), about)
        kinematics.appendBodyToJoint(index, body, pin.SE3.Identity())
    effects, values = [], {}
    for row in table["effects"]:
        values |= {one["name"]: one["value"] for one in row.pop("parameters", [])}
        effects.append(EFFECTS[row.pop("name")](**row))
    model = Model(Robot("rebuilt", kinematics), tuple(effects))
    return known(
        model, np.array([values.get(n, v) for n, v in zip(model.names, model.nominal_values, strict=True)])
    )


@pytest.mark.parametrize("form", ["mjcf", "urdf"])
def test_a_payload_becomes_part_of_the_last_link(form):
    model = Model(six_axis(), (RigidBody(), Payload("tool")))
    model = known(model, values_of(model))
    motion = sliding_motion(model.robot, "tool")
    text = FORMATS[form].text(Portable.of(model, "tool"))
    close({"mjcf": in_mujoco, "urdf": in_pinocchio}[form](text, motion), torque_of(model, motion))
    bare = FORMATS[form].text(Portable.of(model))
    empty = replace(motion, payload="")
    close({"mjcf": in_mujoco, "urdf": in_pinocchio}[form](bare, empty), torque_of(model, empty))
    with pytest.raises(RobotError, match="no payload 'gripper'. Payloads of the model: tool"):
        Portable.of(model, "gripper")


def test_bodies_that_cannot_be_are_moved_and_reported():
    model = Model(six_axis(), (RigidBody(), RotorInertia()))
    values = values_of(model)
    values[0:10], values[10:16] = 0.0, -1.0
    portable = Portable.of(known(model, values))
    assert "joint1, joint2 are physically inconsistent" in "\n".join(FORMATS["json"].leaves_out(portable))
    mujoco.MjModel.from_xml_string(FORMATS["mjcf"].text(portable))
    again = Portable.of(portable.model)
    assert not again.remarks
    np.testing.assert_allclose(
        again.model.nominal_values, portable.model.nominal_values, rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("ulps", [-8, -1, 1, 8])
def test_a_body_that_was_moved_is_possible_to_the_last_bit(ulps):
    """As another processor rounds: the largest parameter and the body itself, a little more or less."""
    alone = values_of(Model(six_axis(), (RigidBody(),)))[:10]
    assert possible(alone, 10.0) is alone
    random = np.random.default_rng(3)
    for impossible in (np.zeros(10), -np.ones(10), *random.normal(size=(50, 10))):
        moved = possible(impossible, 10.0)
        assert possible(moved, 10.0) is moved
        nearly = moved * (1 + ulps * np.finfo(float).eps)
        assert possible(nearly, 10.0 * (1 - ulps * np.finfo(float).eps)) is nearly


def test_an_identified_model_predicts_what_the_fit_does():
    found, run = identified(fit()), other_run()
    base = (fit().structure or fit().base).regrouping @ found.nominal_values
    estimate = replace(fit().estimate, values=base[[fit().structure.names.index(n) for n in kept_names()]])
    ours, theirs = fit().agree(run), agreement(run, estimate, *parts(run))
    change = np.sqrt(np.mean((ours.predicted - theirs.predicted) ** 2, axis=0))
    assert np.all(change < 0.2 * ours.noise)  # far below what the run itself could show
    bodies = found.nominal_values[:20].reshape(2, 10)
    assert all(np.linalg.eigvalsh(pseudo_inertia(body))[0] > 0 for body in bodies)


def kept_names():
    by_column = dict(zip(fit().structure.kept, fit().structure.names, strict=True))
    return [by_column[column] for column in fit().base.kept]


def parts(run):
    from exidyn.identification.fit.equations import decimated_regressor

    return decimated_regressor(fit().model, fit().base, run, run.motion)


def test_an_identified_model_has_what_was_found_as_nominal():
    found, was = identified(fit()), fit()
    np.testing.assert_array_equal(found.robot.drive_gain, was.estimate.gain)
    assert found.stated["Fv1"].value == pytest.approx(was.value("Fv1"), rel=1e-3)
    std = was.estimate.std[was.names.index("Fv1")]
    assert found.stated["Fv1"].std == pytest.approx(std, rel=0.05)
    assert set(was.dropped) & set(found.stated)
    for name in set(was.dropped) & set(found.stated):
        assert abs(found.stated[name].value) <= abs(was.dropped[name]) + 1e-9


def test_a_fit_reaches_mujoco():
    model = identified(fit())
    motion = sliding_motion(model.robot)
    inside = replace(motion, position=np.clip(motion.position, -2.4, 2.4))
    portable = Portable.of(model)
    missing = "\n".join(FORMATS["mjcf"].leaves_out(portable))
    asymmetry = np.zeros_like(inside.position)
    for effect, own in portable.others:
        asymmetry += effect.regressor(model.robot, inside) @ own
    found = in_mujoco(FORMATS["mjcf"].text(portable), inside) + asymmetry
    close(found, torque_of(model, inside))
    assert "friction_asymmetry: up to" in missing


def test_torques_that_are_currents_are_refused():
    was = plain_fit()
    robot = replace(was.model.robot, drive_gain=np.ones(2))
    estimate = replace(was.estimate, covariance=was.estimate.covariance * 0.0)
    unscaled = replace(was, model=replace(was.model, robot=robot), estimate=estimate)
    with pytest.raises(FitError, match="drive gains are unknown"):
        identified(unscaled)


def test_motors_have_the_torque_limits_and_joints_their_range():
    robot = six_axis()
    bounds = [-1.0, 1.5, 3.0, 12.0, 200.0, 80.0]
    limited = replace(robot, limits=Limits(*np.outer(bounds, np.ones(6))))
    arm = mujoco.MjModel.from_xml_string(FORMATS["mjcf"].text(Portable.of(full(limited))))
    np.testing.assert_array_equal(arm.actuator_ctrlrange, 80.0 * np.outer(np.ones(6), [-1.0, 1.0]))
    np.testing.assert_array_equal(arm.jnt_range, np.outer(np.ones(6), [-1.0, 1.5]))
