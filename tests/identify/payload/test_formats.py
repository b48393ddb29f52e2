"""Forms of controllers: independent code reads each back as the same mass, center and inertia."""

import re
from itertools import product

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from exidyn.identification.payload.body import Body
from exidyn.identification.payload.formats import FORMATS, angles_of

NUMBER = r"-?\d+\.\d+"


def random_body(seed: int) -> Body:
    """A body of a few points, so that its inertia is possible."""
    random = np.random.default_rng(seed)
    points, mass = random.normal(size=(6, 3)) * [0.1, 0.2, 0.05] + [0.02, -0.03, 0.1], 2.805
    weights = random.dirichlet(np.ones(6)) * mass
    center = weights @ points / mass
    arms = points - center
    inertia = sum(w * (a @ a * np.eye(3) - np.outer(a, a)) for w, a in zip(weights, arms, strict=True))
    return Body(mass, center, np.asarray(inertia))


BODIES = [random_body(seed) for seed in range(3)]


def numbers_in(text: str) -> list[float]:
    """All decimal numbers of a text."""
    return [float(number) for number in re.findall(NUMBER, text)]


def test_parameters_are_those_of_pinocchio_and_inverse():
    for body in BODIES:
        m, mx, my, mz, xx, xy, yy, xz, yz, zz = pin.Inertia(
            body.mass, body.center, body.inertia
        ).toDynamicParameters()
        np.testing.assert_allclose(body.parameters, [xx, xy, xz, yy, yz, zz, mx, my, mz, m], atol=1e-12)
    for body in BODIES:
        again = Body.of(body.parameters)
        np.testing.assert_allclose(again.inertia, body.inertia, atol=1e-12)
        np.testing.assert_allclose(again.center, body.center, atol=1e-12)


@pytest.mark.parametrize("body", BODIES)
def test_principal_axes_rebuild_the_inertia(body: Body) -> None:
    moments, axes = body.principal
    np.testing.assert_allclose(axes @ np.diag(moments) @ axes.T, body.inertia, atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)


def from_ur(text: str) -> pin.Inertia:
    """A body from URScript: xx, yy, zz, xy, xz, yz."""
    mass, x, y, z, xx, yy, zz, xy, xz, yz = numbers_in(text)
    return pin.Inertia(mass, np.array([x, y, z]), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


def from_franka(text: str) -> pin.Inertia:
    """A body from libfranka: the inertia column by column."""
    mass, *others = numbers_in(text)
    return pin.Inertia(mass, np.array(others[:3]), np.reshape(others[3:], (3, 3), order="F"))


def from_kuka(text: str) -> pin.Inertia:
    """A body from KRL: mm, and axes turned by A, B, C about the new axes."""
    mass, x, y, z, a, b, c, *moments = numbers_in(text.splitlines()[0].partition("=")[2])
    axes = Rotation.from_euler("ZYX", [a, b, c], degrees=True).as_matrix()
    return pin.Inertia(mass, 1e-3 * np.array([x, y, z]), axes @ np.diag(moments) @ axes.T)


def from_abb(text: str) -> pin.Inertia:
    """A body from RAPID: mm, and axes as a quaternion of unit length."""
    mass, x, y, z, q1, q2, q3, q4, *moments = numbers_in(text)
    assert np.hypot.reduce([q1, q2, q3, q4]) == pytest.approx(1.0, abs=1e-8)
    axes = Rotation.from_quat([q2, q3, q4, q1]).as_matrix()  # SciPy has the scalar last
    return pin.Inertia(mass, 1e-3 * np.array([x, y, z]), axes @ np.diag(moments) @ axes.T)


def from_urdf(text: str) -> pin.Inertia:
    """A body from URDF, as Pinocchio reads it."""
    robot = (
        '<robot name="r"><link name="base"/>'
        '<joint name="j" type="revolute"><parent link="base"/><child link="payload"/><axis xyz="0 0 1"/>'
        f'<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>{text}</robot>'
    )
    return pin.buildModelFromXML(robot).inertias[1]


def from_mjcf(text: str) -> pin.Inertia:
    """A body from MJCF, as MuJoCo reads it."""
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{text}</worldbody></mujoco>")
    axes = Rotation.from_quat(np.roll(model.body_iquat[1], -1)).as_matrix()
    inertia = axes @ np.diag(model.body_inertia[1]) @ axes.T
    return pin.Inertia(float(model.body_mass[1]), model.body_ipos[1], inertia)


READERS = {name: globals()[f"from_{name}"] for name in FORMATS}


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("body", BODIES)
def test_every_form_is_read_back_as_the_same_body(name: str, body: Body) -> None:
    inertia = READERS[name](FORMATS[name](body, "tool0"))
    assert inertia.mass == pytest.approx(body.mass, abs=1e-6)
    np.testing.assert_allclose(inertia.lever, body.center, atol=1e-6)
    np.testing.assert_allclose(inertia.inertia, body.inertia, atol=5e-6)  # moments of six decimals


@pytest.mark.parametrize("name", FORMATS)
def test_every_form_of_a_tilted_bar_needs_the_force_of_its_points(name: str) -> None:
    """Newton's law on eight points, which have all moments of a bar of 0.4 x 0.1 x 0.06 m: no inertia."""
    corners = np.array(list(product((-1.0, 1.0), repeat=3))) * [0.4, 0.1, 0.06] / np.sqrt(12.0)
    tilt, center, mass = Rotation.from_euler("xyz", [0.5, -0.8, 1.1]), np.array([0.05, -0.12, 0.2]), 3.0
    moments = mass / 12.0 * np.array([0.1**2 + 0.06**2, 0.4**2 + 0.06**2, 0.4**2 + 0.1**2])
    bar = Body(mass, center, tilt.as_matrix() @ np.diag(moments) @ tilt.as_matrix().T)
    assert np.abs(bar.inertia[np.triu_indices(3, 1)]).min() > 0.002  # no sign and no place can hide

    lift, spin, turn = np.array([[0.3, -9.0, 4.0], [2.0, -1.0, 3.0], [-5.0, 7.0, 6.0]])
    points = center + tilt.apply(corners)
    forces = mass / 8.0 * (lift + np.cross(turn, points) + np.cross(spin, np.cross(spin, points)))
    expected = np.concatenate([forces.sum(axis=0), np.cross(points, forces).sum(axis=0)])

    inertia, motion = READERS[name](FORMATS[name](bar, "tool0")), pin.Motion(np.zeros(3), spin)
    force = inertia * pin.Motion(lift, turn) + motion.cross(inertia * motion)
    np.testing.assert_allclose(force.vector, expected, atol=1e-4)  # six decimals, at up to 9 m/s^2


@pytest.mark.parametrize("degrees", [(30.0, 90.0, 0.0), (10.0, -90.0, 0.0), (-170.0, 20.0, 100.0)])
def test_angles_rebuild_the_rotation_even_where_two_axes_coincide(degrees: tuple[float, ...]) -> None:
    rotation = Rotation.from_euler("ZYX", degrees, degrees=True).as_matrix()
    again = Rotation.from_euler("ZYX", angles_of(rotation), degrees=True).as_matrix()
    np.testing.assert_allclose(again, rotation, atol=1e-9)


@pytest.mark.parametrize("name", FORMATS)
def test_no_number_has_an_exponent_and_every_form_states_its_units(name: str) -> None:
    small = Body(1e-5, np.array([1e-5, 0.0, 0.0]), 1e-9 * np.eye(3))
    text = FORMATS[name](small, "arm/tool0\n-->")
    assert not re.search(r"\de[-+]?\d", text)
    assert "in frame arm/tool0" in text
    assert "kg" in FORMATS[name].title
