"""Modified-DH tables against their formula, and against a URDF of the same arm."""

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.rigid_regressor import INERTIAL
from exidyn.identification.errors import BrokenTree, RobotError, UnknownKey
from exidyn.identification.robot_files.mdh import mdh_kinematics, parse_mdh

pytestmark = pytest.mark.numerical

BODY = dict(M=5.0, MX=0.5, MY=-0.3, MZ=0.2, XX=1.0, XY=0.1, XZ=-0.05, YY=1.2, YZ=0.02, ZZ=0.9)
ROWS = [
    {"alpha": 0.3, "d": 0.2, "theta_offset": 0.4, "r": 0.5, **BODY},
    {"alpha": -1.2, "d": 0.1, "theta_offset": -0.7, "r": 0.3, "sigma": 1, **BODY},
    {"alpha": 0.8, "d": -0.4, "theta_offset": 1.1, "r": -0.2, **BODY},
]


def turn_x(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])


def turn_z(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def shift(x, z):
    moved = np.eye(4)
    moved[[0, 2], 3] = x, z
    return moved


def test_frames_follow_khalils_formula():
    model = mdh_kinematics(ROWS, "arm").model
    position = np.array([0.6, 0.25, -0.9])
    data = model.createData()
    pin.forwardKinematics(model, data, position)
    expected = np.eye(4)
    for row, q, placement in zip(ROWS, position, list(data.oMi)[1:], strict=True):
        slides = row.get("sigma", 0) == 1
        angle, along = row["theta_offset"] + (0 if slides else q), row["r"] + (q if slides else 0)
        expected = expected @ turn_x(row["alpha"]) @ shift(row["d"], 0) @ turn_z(angle) @ shift(0, along)
        np.testing.assert_allclose(placement.homogeneous, expected, atol=1e-14)
    inertia = mdh_kinematics(ROWS, "arm").model.inertias[2]
    m, mx, my, mz, xx, xy, yy, xz, yz, zz = inertia.toDynamicParameters()
    found = dict(zip(INERTIAL, (xx, xy, xz, yy, yz, zz, mx, my, mz, m), strict=True))
    assert found == pytest.approx(BODY, abs=1e-14)


def test_a_fixed_row_adds_its_body_and_is_the_flange():
    tool = {"sigma": 2, "alpha": 0.5, "r": 0.1, "M": 2.0, "XX": 0.01, "YY": 0.01, "ZZ": 0.01}
    plain, tooled = mdh_kinematics(ROWS, "arm"), mdh_kinematics([*ROWS, tool], "arm")
    assert tooled.model.nv == 3
    assert tooled.model.inertias[3].mass == pytest.approx(plain.model.inertias[3].mass + 2.0)
    expected = turn_x(0.5) @ shift(0, 0.1)
    np.testing.assert_allclose(tooled.flange.homogeneous, expected, atol=1e-15)
    assert plain.flange.isIdentity()


def test_antecedents_make_a_tree():
    rows = [
        {"joint": "trunk"},
        {"joint": "left"},
        {"joint": "right", "antecedent": "trunk"},
        {"antecedent": 1},
    ]
    assert list(mdh_kinematics(rows, "tree").model.parents) == [0, 0, 1, 1, 1]
    assert list(mdh_kinematics([{}, {"antecedent": 0}], "two arms").model.parents) == [0, 0, 0]


@pytest.mark.parametrize(
    ("row", "error", "message"),
    [
        ({"alhpa": 1.0}, UnknownKey, "alpha"),
        ({"sigma": 3}, RobotError, "0 \\(revolute\\), 1 \\(prismatic\\), 2 \\(fixed\\)"),
        ({"antecedent": "elbow"}, BrokenTree, "elbow.*joint1"),
        ({"antecedent": 7}, BrokenTree, "7"),
        ({"joint": 1}, BrokenTree, "joint1"),
        ({"M": -1.0}, BrokenTree, "-1"),
        ({"MX": 1.0}, RobotError, "M is 0"),
        ({"M": 1.0, "MX": 1.0, "XX": 0.1, "YY": 0.1, "ZZ": 0.1}, BrokenTree, "principal moment"),
        ({"M": 1.0, "MX": 1.0, "XX": 0.1, "YY": 0.1, "ZZ": 2.0}, BrokenTree, "origin.*: YY is 0.1, but.* 1$"),
        ({"M": 1.0, "XX": 1, "YY": 1, "ZZ": 1, "XY": 2.0}, BrokenTree, "XY, XZ or YZ too large"),
        ({"alpha": 90.0}, RobotError, "alpha is 90 rad.*degrees = true"),
        ({"theta_offset": -180}, RobotError, "theta_offset is -180 rad.*degrees = true"),
        ({"degrees": "yes"}, RobotError, "degrees: expected true or false"),
        ({"Ia": -2.0}, RobotError, "Ia.*-2"),
        ({"sigma": 2, "Ia": 2.0}, RobotError, "fixed"),
        ({"r": "long"}, RobotError, "long"),
    ],
)
def test_a_wrong_row_is_named(row, error, message):
    with pytest.raises(error, match=f"(?s)mdh row 2.*{message}"):
        mdh_kinematics([{}, row], "arm")


def test_rows_may_be_in_degrees():
    turned = {key: np.degrees(ROWS[0][key]) for key in ("alpha", "theta_offset")}
    found = mdh_kinematics([ROWS[0] | turned | {"degrees": True}], "arm").model.jointPlacements[1]
    expected = mdh_kinematics(ROWS[:1], "arm").model.jointPlacements[1]
    np.testing.assert_allclose(found.homogeneous, expected.homogeneous, atol=1e-15)


def test_another_convention_is_refused():
    with pytest.raises(RobotError, match="mdh-khalil"):
        parse_mdh('convention = "craig"\n[[link]]\n', "arm")
