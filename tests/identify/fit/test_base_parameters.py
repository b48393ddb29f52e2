from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects import (
    CoulombFriction,
    CurrentOffset,
    LoadDependentFriction,
    Parameter,
    Payload,
    RigidBody,
    RotorInertia,
    ViscousFriction,
    known_parameters,
)
from exidyn.identification.fit.base_parameters import base_parameters, from_columns
from exidyn.identification.model import Model
from exidyn.identification.robot_files import robots
from exidyn.identification.robot_files.robot_file import parse_model, read_model

from ...parts.runs.robots import kinematics, random_motion, six_axis, sliding

pytestmark = pytest.mark.numerical

D2, D3, D4, R4, R6 = 0.35, 1.25, 0.055, -1.1, -0.23
"""The KR270's geometry, the paper's Table I [m]."""


@pytest.fixture(scope="module")
def kr270():
    return read_model("kr270")


@pytest.fixture(scope="module")
def base(kr270):
    return base_parameters(kr270)


def tilted():
    return Robot("tilted", kinematics("rrr", gravity=(2.0, -5.0, -8.0), seed=4))


def planar():
    """Two parallel vertical axes: gravity is never seen."""
    model = pin.Model()
    for joint, x in (("a", 0.0), ("b", 0.5)):
        parent = model.addJoint(
            model.njoints - 1, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])), joint
        )
        model.appendBodyToJoint(parent, pin.Inertia.Random(), pin.SE3.Identity())
    return Robot("planar", model)


MODELS = {
    "kr270": lambda: read_model("kr270"),
    "cobot": lambda: read_model("cobot"),
    "coupled": lambda: Model(six_axis(), (RigidBody(), RotorInertia(), ViscousFriction(), CoulombFriction())),
    "sliding": lambda: Model(sliding(), (RigidBody(), RotorInertia(), ViscousFriction())),
    "tilted": lambda: Model(tilted(), (RigidBody(), CurrentOffset())),
    "planar": lambda: Model(planar(), (RigidBody(), RotorInertia())),
}


@pytest.mark.parametrize("name", MODELS)
def test_base_columns_make_every_torque_of_independent_motions(name):
    model = MODELS[name]()
    base = base_parameters(model)
    regressor = model.regressor(random_motion(model.robot, samples=60, seed=11))
    values = np.random.default_rng(0).normal(size=len(model.names))
    torque = regressor @ values
    found = regressor[:, :, base.kept] @ (base.regrouping @ values)
    np.testing.assert_allclose(found, torque, atol=1e-9 * np.abs(torque).max())
    columns = model.regressor(random_motion(model.robot, samples=200, seed=12)).reshape(-1, len(values))
    size = np.linalg.norm(columns, axis=0)
    seen = size > 1e-12 * size.max()  # cosines of right angles leave columns of rounding
    assert len(base.kept) == np.linalg.matrix_rank(columns[:, seen] / size[seen], tol=1e-8)
    smallest_kept, largest_dropped = base.gap
    assert smallest_kept > 1e-4
    assert largest_dropped < 1e-12


def test_kr270_has_the_papers_count(base):
    """The paper's b = 66 counts six drive gains: 36 inertial, 4 rotors, 18 of friction, 2 of the spring."""
    kinds = [name.rstrip("R123456") for name in base.names]
    assert len(base.names) == 60
    assert sum(kind in ("Fv", "Fc", "Off") for kind in kinds) == 18
    assert [name for name in base.names if name.startswith("Ia")] == ["Ia3", "Ia4", "Ia5", "Ia6"]
    assert {"Kr", "K0", "ZZ1R", "XX2R", "MX2R", "MY3R"} <= set(base.names)
    assert sum(kind in ("XX", "XY", "XZ", "YZ", "ZZ", "MX", "MY") for kind in kinds) == 36


def composition(base, name):
    row = base.regrouping[base.names.index(name)]
    return {p.name: w for p, w in zip(base.parameters, row, strict=True) if w != 0}


CARRIED = {f"M{k}": D3**2 for k in (3, 4, 5, 6)}
COMPOSED = {
    "MX2R": {"MX2": 1.0} | {f"M{k}": D3 for k in (3, 4, 5, 6)},
    "XX2R": {"XX2": 1.0, "YY2": -1.0} | {k: -w for k, w in CARRIED.items()},
    "ZZ2R": {"ZZ2": 1.0, "Ia2": 1.0} | CARRIED,
    "MX3R": {"MX3": 1.0} | {f"M{k}": D4 for k in (4, 5, 6)},
    "MY3R": {"MY3": 1.0, "MZ4": 1.0} | {f"M{k}": R4 for k in (4, 5, 6)},  # alpha4 is -90 degrees
    "XX6R": {"XX6": 1.0, "YY6": -1.0},
}
"""Regroupings of the paper: links 4 to 6 are carried wholly by link 3, as links 3 to 6 by link 2."""


@pytest.mark.parametrize("name", COMPOSED)
def test_bodies_are_regrouped_as_the_paper_does(base, name):
    found = composition(base, name)
    assert found.keys() == COMPOSED[name].keys()
    for part, weight in COMPOSED[name].items():
        assert found[part] == pytest.approx(weight, rel=1e-7, abs=1e-9), part
    assert "MX2R = MX2 + 1.25 M3 + 1.25 M4 + 1.25 M5 + 1.25 M6" in base.expressions


def test_turning_inertia_of_the_column(base):
    """ZZ1R = ZZ1 + Ia1 + YY2 + YY3 + d2^2 (M2 + ...) + d3^2 m + d4^2 (...) + what wrist links add."""
    found = composition(base, "ZZ1R")
    expected = {"ZZ1": 1.0, "Ia1": 1.0, "YY2": 1.0, "YY3": 1.0, "M2": D2**2, "M3": D2**2 + D3**2}
    for name, weight in expected.items():
        assert found[name] == pytest.approx(weight, rel=1e-7), name
    # M6 goes through links 5, 4 and 3 into link 1: it counts at every d, and none of the r of the wrist
    assert found["M4"] == pytest.approx(D2**2 + D3**2 + D4**2, rel=1e-7)


def test_no_motion_reveals_what_the_first_link_cannot_show(base):
    """A vertical first axis shows only ZZ1 of link 1; MZ2, along the second axis, goes into MY1."""
    hidden = {"XX1", "XY1", "XZ1", "YY1", "YZ1", "MX1", "MY1", "MZ1", "M1", "MZ2"}
    assert set(base.without_effect) == hidden


def test_a_tilted_base_reveals_more():
    """Gravity across the first axis: its link's first moment is seen, and its rotor apart from nothing."""
    upright = base_parameters(
        Model(Robot("up", kinematics("rrr", gravity=(0, 0, -9.81), seed=4)), (RigidBody(),))
    )
    flat = base_parameters(Model(tilted(), (RigidBody(),)))
    assert len(flat.kept) == len(upright.kept)  # axes of no special direction
    first_vertical = planar()
    fallen = Robot("fallen", first_vertical.kinematics.copy())
    fallen.kinematics.gravity.linear = np.array([0.0, -9.81, 0.0])
    level = base_parameters(Model(first_vertical, (RigidBody(),)))
    tilted_base = base_parameters(Model(fallen, (RigidBody(),)))
    assert level.names == ["ZZ1R", "ZZ2", "MX2", "MY2"]
    assert tilted_base.names == ["ZZ1R", "MX1R", "MY1", "ZZ2", "MX2", "MY2"]


def test_slides_show_mass_and_load_dependent_friction_is_its_own():
    # Vertical slide: its torque is (M) (a + g), and nothing else of it is seen.
    model = pin.Model()
    model.appendBodyToJoint(
        model.addJoint(0, pin.JointModelPZ(), pin.SE3.Identity(), "lift"),
        pin.Inertia.Random(),
        pin.SE3.Identity(),
    )
    base = base_parameters(Model(Robot("lift", model), (RigidBody(),)))
    assert base.names == ["M1"]
    assert len(base.without_effect) == 9
    model = Model(six_axis(), (RigidBody(), CoulombFriction(), LoadDependentFriction()))
    names = base_parameters(model).names
    assert [p.name for p in LoadDependentFriction().parameters(model.robot) if p.name not in names] == []


@pytest.mark.parametrize("payloads", [("",), ("", "L"), ("L",)])
def test_payload_is_distinguished_only_by_runs_with_and_without(payloads):
    robot = tilted()
    model = Model(robot, (RigidBody(), Payload("L", known_parameters(5.0))))
    names = base_parameters(model, payloads).names
    seen = [name for name in names if name.rstrip("R").endswith("L")]
    assert len(seen) == {("",): 0, ("", "L"): 9, ("L",): 0}[payloads]


def test_order_of_preference_decides_what_is_regrouped():
    columns = np.random.default_rng(0).normal(size=(20, 2))
    columns = np.column_stack([columns, columns @ [2.0, -3.0]])  # the third is 2 a - 3 b
    plain = from_columns(tuple(Parameter(n, "1") for n in "abc"), columns)
    assert plain.names == ["aR", "bR"]
    np.testing.assert_allclose(plain.regrouping, [[1, 0, 2], [0, 1, -3]], atol=1e-12)
    late = from_columns((Parameter("a", "1", regroup=2), Parameter("b", "1"), Parameter("c", "1")), columns)
    assert late.names == ["bR", "cR"]
    np.testing.assert_allclose(late.regrouping, [[1.5, 1, 0], [0.5, 0, 1]], atol=1e-12)


@pytest.mark.parametrize("rounded", ["1.5708", "1.570796"])
def test_a_rounded_right_angle_makes_no_base_parameters(rounded):
    exact = read_model("kr270")
    text = (Path(robots.__file__).parent / "kr270.toml").read_text().replace("1.5707963267948966", rounded)
    found, known = base_parameters(parse_model(text)), base_parameters(exact)
    assert found.names == known.names
    np.testing.assert_allclose(
        found.regrouping @ exact.nominal_values, known.regrouping @ exact.nominal_values, rtol=1e-3, atol=0.05
    )
