"""Files of a feedforward: Python and C++ compute the torque of the fit, from hostile names too."""

import subprocess
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.api import save_feedforward
from exidyn.identification.arm.robot import Robot, ServoLaw
from exidyn.identification.dynamics.dynamics import Dynamics
from exidyn.identification.dynamics.program import writable
from exidyn.identification.effects import EFFECTS, RigidBody
from exidyn.identification.errors import FitError, WrongShape
from exidyn.identification.feedforward.cpp_file import cpp_file
from exidyn.identification.feedforward.feedforward import Feedforward, make_feedforward, remarks
from exidyn.identification.feedforward.python_file import python_file
from exidyn.identification.model import Model

from ...parts.runs.robots import kinematics, random_motion, six_axis
from ...parts.small import small_fit
from ...parts.small.hostile_names import NAMES, model, values
from ...parts.system_needs import COMPILER
from ..effects.test_effects import default

CLOSE = 1e-12
"""Largest difference of a file from the fit, over the largest torque."""


def module(text):
    """A written Python file as a namespace."""
    scope = {}
    exec(compile(text, "feedforward.py", "exec"), scope)
    return scope


def compiled(text, main, folder):
    """Output of a program that includes a written header, compiled with all warnings as errors."""
    COMPILER.require()
    (folder / "arm.hpp").write_text(text)
    (folder / "main.cpp").write_text(f'#include "arm.hpp"\n#include <cstdio>\n{main}')
    program = folder / "main"
    flags = ["-std=c++17", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror"]
    made = subprocess.run(
        ["g++", *flags, str(folder / "main.cpp"), "-o", str(program)], capture_output=True, text=True
    )
    assert made.returncode == 0, made.stderr
    return subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout


def numbers(rows):
    """A C++ array of joint vectors."""
    return ", ".join("{{" + ", ".join(map(repr, map(float, row))) + "}}" for row in rows)


def everything(servo=None):
    """Feedforward of an arm with every effect, and its model and values."""
    keys = [key for key in EFFECTS if key not in ("hysteresis", "torque_curve")]
    arm = Model(six_axis(), tuple(default(key) for key in keys))
    given = np.random.default_rng(6).normal(size=len(arm.names))
    dynamics = writable(Dynamics.of(arm, given, "L"))
    n = arm.robot.dof
    gain = np.linspace(-3.0, 3.0, n)
    feedforward = Feedforward(dynamics, "N m", gain, servo, np.linspace(0.01, 0.1, n), 0.7, (), ("run",))
    return feedforward, arm, given


SERVO = ServoLaw.of(
    np.linspace(10.0, 60.0, 6), np.zeros(6), np.array([np.inf, 5.0, 1.0, 9.0, 9.0, 9.0]), np.zeros(6)
)


def test_python_computes_the_torque_of_the_fit():
    fit = small_fit.fit()
    q, dq, ddq = np.random.default_rng(0).normal(size=(3, 20, 2))
    for payload in ("", "L"):
        feedforward = make_feedforward(fit, payload)
        written = module(python_file(feedforward))
        expected = fit.torque(q, dq, ddq, payload)
        torque = [written["inverse_dynamics"](*row) for row in zip(q, dq, ddq, strict=True)]
        np.testing.assert_allclose(torque, expected, rtol=CLOSE, atol=CLOSE * np.abs(expected).max())
        np.testing.assert_allclose(feedforward.torque(q, dq, ddq), expected, rtol=CLOSE, atol=CLOSE)
        held = fit.torque(q, 0.0 * q, 0.0 * q, payload)
        np.testing.assert_allclose([written["gravity"](row) for row in q], held, rtol=CLOSE, atol=CLOSE * 100)
        rows = zip(q, dq, strict=True)
        friction = [written["friction_compensation"](*row) for row in rows]
        np.testing.assert_allclose(friction, feedforward.friction_compensation(q, dq), rtol=CLOSE, atol=CLOSE)
        current = expected / fit.estimate.gain
        np.testing.assert_allclose(written["current"](expected[0]), current[0], rtol=CLOSE)


def test_python_has_every_effect():
    feedforward, arm, given = everything(SERVO)
    motion = random_motion(arm.robot, payload="L")
    expected = arm.torque(arm.loaded(motion), given)
    written = module(python_file(feedforward))
    rows = zip(motion.position, motion.velocity, motion.acceleration, motion.temperature, strict=True)
    torque = np.array([written["inverse_dynamics"](*row) for row in rows])
    np.testing.assert_allclose(torque, expected, rtol=CLOSE, atol=CLOSE * np.abs(expected).max())
    offset = written["position_offset"](motion.position[3], motion.temperature[3])
    expected_offset = feedforward.position_offset(motion.position[3], motion.temperature[3])
    np.testing.assert_allclose(offset, expected_offset, rtol=CLOSE)
    assert np.all(np.abs(offset * SERVO.stiffness) <= SERVO.limit * (1.0 + CLOSE))


def test_cpp_computes_the_same(tmp_path):
    feedforward, arm, given = everything(SERVO)
    motion = random_motion(arm.robot, payload="L")
    q, dq, ddq, warm = motion.position, motion.velocity, motion.acceleration, motion.temperature
    main = f"""
using namespace exidyn_six_axis;
constexpr Vector q[] = {{{numbers(q)}}}, dq[] = {{{numbers(dq)}}}, ddq[] = {{{numbers(ddq)}}},
                 warm[] = {{{numbers(warm)}}};
void print(const Vector& values) {{
  for (double value : values) std::printf("%.17g ", value);
  std::puts("");
}}
int main() {{
  for (std::size_t k = 0; k < {len(q)}; ++k) {{
    const Vector torque = inverse_dynamics(q[k], dq[k], ddq[k], warm[k]);
    print(torque);
    print(compensation(q[k], dq[k], warm[k]));
    print(current(torque));
    print(position_offset(q[k], warm[k]));
  }}
}}
"""
    output = compiled(cpp_file(feedforward), main, tmp_path)
    rows = np.array([[float(word) for word in line.split()] for line in output.splitlines()])
    expected = arm.torque(arm.loaded(motion), given)
    results = (
        expected,
        feedforward.compensation(q, dq, warm),
        feedforward.current(expected),
        feedforward.position_offset(q, warm),
    )
    for place, result in enumerate(results):
        np.testing.assert_allclose(rows[place::4], result, rtol=CLOSE, atol=CLOSE * np.abs(result).max())


def test_both_files_compute_rnea_plus_friction(tmp_path):
    """Pinocchio and the formula of friction: nothing of exidyn's torque is in the expected values."""
    robot = Robot("serial", kinematics())
    arm = Model(robot, (RigidBody(), *(default(key) for key in ("viscous_friction", "coulomb_friction"))))
    viscous, dry = np.random.default_rng(8).uniform(1.0, 20.0, (2, robot.dof))
    values = np.concatenate([arm.nominal_values[: 10 * robot.dof], viscous, dry])
    feedforward = Feedforward(Dynamics.of(arm, values), "N m", None, None, np.full(6, 0.1), 0.7, (), ("run",))
    q, dq, ddq = np.random.default_rng(9).normal(size=(3, 50, robot.dof))
    data, reversal = robot.kinematics.createData(), default("coulomb_friction").reversal
    links = np.array([pin.rnea(robot.kinematics, data, *row) for row in zip(q, dq, ddq, strict=True)])
    expected = links + viscous * dq + dry * np.tanh(dq / reversal)

    written = module(python_file(feedforward))
    torque = [written["inverse_dynamics"](*row) for row in zip(q, dq, ddq, strict=True)]
    np.testing.assert_allclose(torque, expected, rtol=CLOSE, atol=CLOSE * np.abs(expected).max())
    main = f"""
constexpr exidyn_serial::Vector q[] = {{{numbers(q)}}}, dq[] = {{{numbers(dq)}}}, ddq[] = {{{numbers(ddq)}}};
int main() {{
  for (int k = 0; k < {len(q)}; ++k)
    for (double value : exidyn_serial::inverse_dynamics(q[k], dq[k], ddq[k])) std::printf("%.17g ", value);
}}
"""
    output = np.array(compiled(cpp_file(feedforward), main, tmp_path).split(), float).reshape(q.shape)
    np.testing.assert_allclose(output, expected, rtol=CLOSE, atol=CLOSE * np.abs(expected).max())


def test_an_effect_without_a_form_is_left_out_and_named():
    fit = small_fit.fit()
    hysteresis = default("hysteresis")
    arm = fit.model + hysteresis
    dynamics = Dynamics.of(arm, np.ones(len(arm.names)))
    assert [effect for effect, _ in dynamics.left_out] == [hysteresis]
    [sentence, *_] = remarks(replace(fit, model=arm), dynamics)
    assert sentence.startswith("not included: hysteresis: up to 1 N m")
    feedforward = replace(make_feedforward(fit), remarks=(sentence,))
    for written in (python_file(feedforward), cpp_file(feedforward)):
        assert "hysteresis: up to" in written
    effect = default("viscous_friction")

    class Stepped(type(effect)):
        def profiles(self, at):
            return (1.0 if at.velocity > 0.0 else -1.0,)

    arm = Model(six_axis(), (default("link_inertia"), Stepped()))
    dynamics = writable(Dynamics.of(arm, np.ones(len(arm.names))))
    assert [type(effect) for effect, _ in dynamics.left_out] == [Stepped]


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_names_are_data_in_python(name):
    arm = model(name)
    feedforward = replace(
        make_feedforward(small_fit.fit()), dynamics=Dynamics.of(arm, values(arm)), remarks=(name,)
    )
    written = module(python_file(feedforward))
    assert (written["ROBOT"], written["JOINTS"]) == (arm.robot.name, arm.robot.joints)
    assert np.all(np.isfinite(written["gravity"](np.ones(2))))


def test_names_are_data_in_cpp(tmp_path):
    main, text = "int main() { for (int k = 0; k < 1; ++k) {", ""
    for place, name in enumerate(NAMES):
        arm = model(name)
        feedforward = replace(
            make_feedforward(small_fit.fit()),
            dynamics=Dynamics.of(arm, values(arm)),
            remarks=(name,),
            source=(name,),
        )
        header = cpp_file(feedforward)
        start = header.index("namespace ")
        space = header[start:].split()[1]
        assert space.startswith("exidyn")
        renamed = header.replace(space, f"arm{place}").replace(
            f"{space.upper()}_FEEDFORWARD_HPP", f"ARM{place}"
        )
        (tmp_path / f"arm{place}.hpp").write_text(renamed)
        text += f'#include "arm{place}.hpp"\n'
        main += f'\nstd::printf("%s\\n", arm{place}::kNames[1]);'
    output = compiled(text, main + "}}", tmp_path)
    for name in ('it\'s "quoted"1', "ünïcödé 関節 \U0001f9be1", "{name} {0} {{ }} {joints!r}"):
        assert name in output


def test_files_are_saved_by_their_ending(tmp_path):
    feedforward = make_feedforward(small_fit.fit())
    assert save_feedforward(feedforward, tmp_path / "arm.py").read_text() == python_file(feedforward)
    assert save_feedforward(feedforward, tmp_path / "arm.hpp").read_text() == cpp_file(feedforward)
    with pytest.raises(FitError, match=r"arm\.m: the name must end in \.py, \.hpp, \.h"):
        save_feedforward(feedforward, tmp_path / "arm.m")


def test_bad_values_are_refused():
    fit = small_fit.fit()
    with pytest.raises(FitError, match="no payload 'X'. Payloads of the fit: L"):
        make_feedforward(fit, "X")
    with pytest.raises(FitError, match="share of friction is 100 %; it must be at least 0 and below 100 %"):
        make_feedforward(fit, share=1.0)
    with pytest.raises(FitError, match="band of velocity is 0 rad/s; it must be above 0"):
        make_feedforward(fit, band=0.0)
    with pytest.raises(WrongShape, match="expected 2 joints"):
        make_feedforward(fit).gravity(np.zeros(3))
    with pytest.raises(FitError, match="stiffness of its position servos is not known"):
        make_feedforward(fit).position_offset(np.zeros(2))
