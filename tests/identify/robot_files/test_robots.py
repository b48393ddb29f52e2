"""The built-in robots: the KR270 against the paper's tables, the cobot against the UR10; their comments."""

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.rigid_regressor import INERTIAL
from exidyn.identification.robot_files.commented import commented_text
from exidyn.identification.robot_files.robot_file import builtin_names, model_text, parse_model, read_model

ALPHA = np.array([np.pi, np.pi / 2, 0.0, -np.pi / 2, np.pi / 2, -np.pi / 2])
D = np.array([0.0, 0.35, 1.25, 0.055, 0.0, 0.0])
R = np.array([-0.75, 0.0, 0.0, -1.1, 0.0, -0.23])
OFFSET = np.array([0.0, 0.0, np.pi / 2, 0.0, 0.0, -np.pi / 2])
"""The paper's Table I."""

TABLE_III = {
    "ZZ1": 1190.0, "XX2": -623.0, "ZZ2": 1510.0, "MX2": 344.0, "XX3": 99.6, "ZZ3": 120.0, "MX3": 14.5,
    "MY3": -102.0, "Ia3": 680.0, "Ia4": 170.0, "Ia5": 209.0, "Ia6": 131.0,
    "Fv1": 1090.0, "Fv2": 2630.0, "Fv3": 102.0, "Fv4": 526.0, "Fv5": 845.0, "Fv6": 782.0,
    "Fc1": 301.0, "Fc2": 642.0, "Fc3": 402.0, "Fc4": 185.0, "Fc5": 199.0, "Fc6": 305.0,
    "Off2": -153.0, "Kr": 50400.0, "K0": -78500.0,
}  # fmt: skip
PER_CENT = {"XX2": 16.0}
"""Allowed deviation where it is more than 2 %; kr270.toml gives the reason."""


def regrouped(values: dict[str, float]) -> dict[str, float]:
    """Khalil's regrouping for revolute joints, tip to base: YY, MZ, M of a link go to the one before."""
    v = dict(values)
    for j in range(6, 0, -1):
        yy, mz, m = (v[f"{name}{j}"] for name in ("YY", "MZ", "M"))
        v |= {f"YY{j}": 0.0, f"MZ{j}": 0.0, f"M{j}": 0.0, f"XX{j}": v[f"XX{j}"] - yy}
        s, c, d, r, i = np.sin(ALPHA[j - 1]), np.cos(ALPHA[j - 1]), D[j - 1], R[j - 1], j - 1
        along = yy + 2 * r * mz + r**2 * m
        first = mz + r * m
        moved = {"XX": along, "YY": c**2 * along + d**2 * m, "ZZ": s**2 * along + d**2 * m, "M": m}
        moved |= {"XY": d * s * first, "XZ": -d * c * first, "YZ": c * s * along}
        moved |= {"MX": d * m, "MY": -s * first, "MZ": c * first}
        if i:
            v |= {f"{name}{i}": v[f"{name}{i}"] + change for name, change in moved.items()}
    # links 1 and 2 turn about their own axes as the rotors of joints 1 and 2 do
    for j in (1, 2):
        v |= {f"ZZ{j}": v[f"ZZ{j}"] + v[f"Ia{j}"], f"Ia{j}": 0.0}
    return v


@pytest.fixture(scope="module")
def kr270():
    return read_model("kr270")


@pytest.fixture(scope="module")
def base_values(kr270):
    return regrouped(dict(zip(kr270.names, kr270.nominal_values, strict=True)))


def test_gains_and_base_values_are_those_of_the_tables(kr270):
    data = kr270.robot.kinematics.createData()
    position = np.array([0.3, -1.1, 0.7, -0.4, 0.9, 1.3])
    pin.forwardKinematics(kr270.robot.kinematics, data, position)
    expected = pin.SE3.Identity()
    for j in range(6):
        tilt = pin.SE3(pin.rpy.rpyToMatrix(ALPHA[j], 0, 0), np.zeros(3))
        turn = pin.SE3(pin.rpy.rpyToMatrix(0, 0, OFFSET[j] + position[j]), np.array([D[j], 0, 0]))
        expected = expected * tilt * turn * pin.SE3(np.eye(3), np.array([0, 0, R[j]]))
        assert data.oMi[j + 1].isApprox(expected, 1e-12)
    np.testing.assert_array_equal(kr270.robot.drive_gain, [-276, -427, -402, -295, -306, 215])


def test_base_values_make_the_same_torque(kr270, base_values):
    """The regrouping of this test is right: it changes no torque, on any motion."""
    position, velocity, acceleration = np.random.default_rng(1).standard_normal((3, 50, 6))
    regressor = kr270.regressor(Motion.of(np.arange(50.0), position, velocity, acceleration))
    values = np.array([base_values[name] for name in kr270.names])
    torque = regressor @ kr270.nominal_values
    np.testing.assert_allclose(regressor @ values, torque, atol=1e-9 * np.abs(torque).max())
    assert np.count_nonzero(values != kr270.nominal_values) > 10


@pytest.mark.parametrize("name", TABLE_III)
def test_base_values_are_near_table_iii(base_values, name):
    assert base_values[name] == pytest.approx(TABLE_III[name], rel=PER_CENT.get(name, 2.0) / 100)


def test_balancer_carries_the_arm_with_half_its_payload(kr270):
    """Arm forward with 135 kg: the balancer leaves motor 2 less than half of the torque."""
    position = np.array([[0.0, -0.3, 0.3, 0.0, 0.0, 0.0]])
    still = Motion.of(np.zeros(1), position, 0 * position, 0 * position)
    nominal = dict(zip(kr270.names, kr270.nominal_values, strict=True))
    regressor = dict(zip(kr270.names, kr270.regressor(still)[0, 1], strict=True))
    weight = sum(regressor[f"{name}{j}"] * nominal[f"{name}{j}"] for name in INERTIAL for j in range(1, 7))
    data = kr270.robot.kinematics.createData()
    pin.computeJointJacobians(kr270.robot.kinematics, data, position[0])
    jacobian = pin.getJointJacobian(kr270.robot.kinematics, data, 6, pin.LOCAL_WORLD_ALIGNED)
    weight += 135 * 9.81 * jacobian[2, 1]
    balancer = regressor["Kr"] * nominal["Kr"] + regressor["K0"] * nominal["K0"]
    assert abs(weight + balancer) < 0.5 * abs(weight)


@pytest.mark.parametrize("name", builtin_names())
def test_bodies_are_physically_consistent_with_margin(name):
    for inertia in list(read_model(name).robot.kinematics.inertias)[1:]:
        moments = np.linalg.eigvalsh(inertia.inertia)
        spread = (moments.sum() / 2 - moments) / inertia.mass  # mean square distances along the axes
        assert np.sqrt(spread.min()) > 0.01  # 1 cm
        assert np.linalg.norm(inertia.lever) < 0.5


@pytest.mark.parametrize("name", builtin_names())
def test_limits_are_all_there_and_torque_holds_the_arm(name):
    model = read_model(name)
    limits = model.robot.limits
    assert np.all(np.isfinite([getattr(limits, key) for key in vars(limits)]))
    position = np.random.default_rng(2).uniform(
        limits.position_lower, limits.position_upper, (500, model.robot.dof)
    )
    still = Motion.of(np.arange(500.0), position, 0 * position, 0 * position)
    assert np.all(np.abs(model.torque(still, model.nominal_values)) < 0.8 * limits.torque)


def test_cobot_reaches_where_the_ur10_does():
    robot = read_model("cobot").robot
    data = robot.kinematics.createData()
    pin.forwardKinematics(robot.kinematics, data, np.zeros(6))
    # standard DH at zero: x = a2 + a3, y = -(d4 + d6), z = d1 - d5
    np.testing.assert_allclose(data.oMi[6].translation, [-1.1843, -0.256141, 0.0116], atol=1e-12)


@pytest.mark.parametrize("name", builtin_names())
def test_each_key_has_a_comment_above(name):
    seen, before = set(), ""
    for line in commented_text(read_model(name)).splitlines():
        key = line.partition(" = ")[0]
        if line.startswith("["):
            seen = seen if line == "[[link]]" else set()
        elif line and not line.startswith("#") and key not in seen:
            assert before.startswith("# "), line
            seen.add(key)
        before = line


@pytest.mark.parametrize("name", builtin_names())
def test_it_reads_back_as_the_same_robot(name):
    model = read_model(name)
    assert model_text(parse_model(commented_text(model))) == model_text(model)


def test_values_are_named_with_their_units(kr270):
    text = commented_text(kr270)
    assert "# Nominal values of Kr [N/m]; K0 [N]" in text
    assert "# Distance of the fixed end from the joint's axis [m]" in text
    assert "# Nominal values of Fc1, Fc2, Fc3, Fc4, Fc5, Fc6 [N m]" in text
