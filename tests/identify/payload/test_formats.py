"""Forms of controllers: independent code reads each back as the same mass, center and inertia."""

import re

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from exidyn.identification.payload.body import Body
from exidyn.identification.payload.formats import FORMATS
from exidyn.identification.payload.formats.kuka import angles_of

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


BODIES = [random_body(seed) for seed in range(5)]


def numbers_in(text: str) -> list[float]:
    """All decimal numbers of a text."""
    return [float(number) for number in re.findall(NUMBER, text)]


def test_parameters_and_body_are_inverse() -> None:
    for body in BODIES:
        again = Body.of(body.parameters)
        np.testing.assert_allclose(again.inertia, body.inertia, atol=1e-12)
        np.testing.assert_allclose(again.center, body.center, atol=1e-12)


def test_parameters_are_those_of_pinocchio() -> None:
    for body in BODIES:
        m, mx, my, mz, xx, xy, yy, xz, yz, zz = pin.Inertia(
            body.mass, body.center, body.inertia
        ).toDynamicParameters()
        np.testing.assert_allclose(body.parameters, [xx, xy, xz, yy, yz, zz, mx, my, mz, m], atol=1e-12)


@pytest.mark.parametrize("body", BODIES)
def test_principal_axes_rebuild_the_inertia(body: Body) -> None:
    moments, axes = body.principal
    np.testing.assert_allclose(axes @ np.diag(moments) @ axes.T, body.inertia, atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_axes_of_the_flange_stay() -> None:
    moments, axes = Body(1.0, np.zeros(3), np.diag([0.3, 0.1, 0.25])).principal
    np.testing.assert_allclose(axes, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(moments, [0.3, 0.1, 0.25])


@pytest.mark.parametrize("body", BODIES)
def test_universal_robots(body: Body) -> None:
    mass, x, y, z, xx, yy, zz, xy, xz, yz = numbers_in(FORMATS["ur"](body))
    inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    assert mass == pytest.approx(body.mass, abs=1e-6)
    np.testing.assert_allclose([x, y, z], body.center, atol=1e-6)
    np.testing.assert_allclose(inertia, body.inertia, atol=1e-6)


@pytest.mark.parametrize("body", BODIES)
def test_franka(body: Body) -> None:
    mass, *others = numbers_in(FORMATS["franka"](body))
    assert mass == pytest.approx(body.mass, abs=1e-6)
    np.testing.assert_allclose(others[:3], body.center, atol=1e-6)
    np.testing.assert_allclose(np.reshape(others[3:], (3, 3), order="F"), body.inertia, atol=1e-6)


@pytest.mark.parametrize("body", BODIES)
def test_kuka(body: Body) -> None:
    line = FORMATS["kuka"](body).splitlines()[0]
    mass, x, y, z, a, b, c, jx, jy, jz = numbers_in(line.partition("=")[2])
    axes = Rotation.from_euler("ZYX", [a, b, c], degrees=True).as_matrix()  # intrinsic: about new axes
    assert mass == pytest.approx(body.mass, abs=1e-6)
    np.testing.assert_allclose([x, y, z], 1e3 * body.center, atol=1e-3)
    np.testing.assert_allclose(axes @ np.diag([jx, jy, jz]) @ axes.T, body.inertia, atol=5e-6)


@pytest.mark.parametrize("degrees", [(30.0, 90.0, 0.0), (10.0, -90.0, 0.0), (-170.0, 20.0, 100.0)])
def test_angles_rebuild_the_rotation_even_where_two_axes_coincide(degrees: tuple[float, ...]) -> None:
    rotation = Rotation.from_euler("ZYX", degrees, degrees=True).as_matrix()
    again = Rotation.from_euler("ZYX", angles_of(rotation), degrees=True).as_matrix()
    np.testing.assert_allclose(again, rotation, atol=1e-9)


@pytest.mark.parametrize("body", BODIES)
def test_abb(body: Body) -> None:
    mass, x, y, z, q1, q2, q3, q4, ix, iy, iz = numbers_in(FORMATS["abb"](body))
    axes = Rotation.from_quat([q2, q3, q4, q1]).as_matrix()  # SciPy has the scalar last
    assert mass == pytest.approx(body.mass, abs=1e-6)
    assert np.hypot.reduce([q1, q2, q3, q4]) == pytest.approx(1.0, abs=1e-8)
    np.testing.assert_allclose([x, y, z], 1e3 * body.center, atol=1e-3)
    np.testing.assert_allclose(axes @ np.diag([ix, iy, iz]) @ axes.T, body.inertia, atol=5e-6)


@pytest.mark.parametrize("body", BODIES)
def test_pinocchio_reads_the_urdf(body: Body) -> None:
    text = (
        '<robot name="r"><link name="base"/>'
        '<joint name="j" type="revolute"><parent link="base"/><child link="payload"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
        f"{FORMATS['urdf'](body)}</robot>"
    )
    inertia = pin.buildModelFromXML(text).inertias[1]
    assert inertia.mass == pytest.approx(body.mass, abs=1e-6)
    np.testing.assert_allclose(inertia.lever, body.center, atol=1e-6)
    np.testing.assert_allclose(inertia.inertia, body.inertia, atol=1e-8)


@pytest.mark.parametrize("body", BODIES)
def test_mujoco_reads_the_mjcf(body: Body) -> None:
    text = f"<mujoco><worldbody>{FORMATS['mjcf'](body)}</worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    axes = Rotation.from_quat(np.roll(model.body_iquat[1], -1)).as_matrix()
    assert model.body_mass[1] == pytest.approx(body.mass, abs=1e-6)
    np.testing.assert_allclose(model.body_ipos[1], body.center, atol=1e-6)
    np.testing.assert_allclose(axes @ np.diag(model.body_inertia[1]) @ axes.T, body.inertia, atol=1e-8)


@pytest.mark.parametrize("name", FORMATS)
def test_no_number_has_an_exponent_and_every_form_states_its_units(name: str) -> None:
    small = Body(1e-5, np.array([1e-5, 0.0, 0.0]), 1e-9 * np.eye(3))
    assert not re.search(r"\de[-+]?\d", FORMATS[name](small))
    assert "kg" in (FORMATS[name].__doc__ or "").partition("\n")[0]
