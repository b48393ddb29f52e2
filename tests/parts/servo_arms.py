"""Runs of a two-joint arm in plain MuJoCo, whose servos follow commands with a delay."""

from typing import Any

import numpy as np

from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.recordings.servo_error import LAW, servo_of, servo_words, with_servo_error
from exidyn.identification.robot_files.mjcf import mjcf_kinematics
from exidyn.identification.robot_files.robot_file import described_model

ARM = """<mujoco model="two">
  <compiler angle="radian"/>
  <option timestep="0.001" integrator="implicitfast"/>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <inertial mass="4" pos="0.15 0 0.02" diaginertia="0.03 0.06 0.06"/>
      <joint name="shoulder" axis="0 1 0" range="-2 2" damping="1" armature="0.1"/>
      <body name="lower" pos="0.4 0 0">
        <inertial mass="2" pos="0.1 0 0.01" diaginertia="0.01 0.02 0.02"/>
        <joint name="elbow" axis="0 1 0" range="-2 2" damping="0.5" armature="0.05"/>
        <site name="flange" pos="0.3 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="a" joint="shoulder" kp="800" kv="40"/>
    <position name="b" joint="elbow" kp="400" kv="20"/>
  </actuator>
</mujoco>
"""
"""The user's file."""
DELAYED = {
    'kp="800" kv="40"': 'kp="600" kv="60" delay="0.02" nsample="21" interp="linear"',
    'kp="400" kv="20"': 'kp="300" kv="30" delay="0.02" nsample="21" interp="linear"',
    'damping="1"': 'damping="1" frictionloss="2"',
}
"""What differs in the real arm."""
PERIOD = 0.004
SECONDS = 8.0


def real_arm() -> str:
    """The file of the real arm."""
    text = ARM
    for old, new in DELAYED.items():
        text = text.replace(old, new)
    return text


def described(text: str = ARM) -> Model:
    """The arm that a file describes."""
    import mujoco

    compiled = mujoco.MjModel.from_xml_string(text)
    return described_model("two", mjcf_kinematics(compiled, "two.xml", ("shoulder", "elbow")))


def log(text: str, seed: int, name: str, nominal: Model | None = None) -> Recording:
    """A run with commands, positions and the torque of the servos."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    data, time = mujoco.MjData(model), np.arange(0.0, SECONDS, PERIOD)
    command, position, torque = _commands(time, seed), *np.empty((2, len(time), 2))
    data.qpos[:] = data.ctrl[:] = command[0]
    mujoco.mj_step(model, data, 1500)
    steps = round(PERIOD / model.opt.timestep)
    for row in range(len(time)):
        position[row] = data.qpos
        for step in range(steps):
            data.ctrl[:] = command[row] + step / steps * (command[min(row + 1, len(time) - 1)] - command[row])
            mujoco.mj_step(model, data)
            if step == 0:
                torque[row] = data.qfrc_actuator
    noise = np.random.default_rng(seed)
    torque += 0.01 * np.std(torque, axis=0) * noise.normal(size=torque.shape)
    position = np.round(position * 2**17 / (2 * np.pi)) * (2 * np.pi) / 2**17
    signals = {"position": position, "torque": torque, "command": command}
    return Recording(name, nominal or described(), {key: Signal(time, rows) for key, rows in signals.items()})


def _commands(time: np.ndarray, seed: int) -> np.ndarray:
    """Sums of sines that begin at rest, shape (t, 2) [rad]."""
    draw = np.random.default_rng(seed)
    fade = np.minimum(time / 1.0, 1.0)[:, None]
    rates = 2 * np.pi * np.array([0.2, 0.5, 0.9])
    size = draw.uniform(0.5, 1.0, (3, 2)) * np.array([0.5, 0.25, 0.12])[:, None]
    phase = draw.uniform(0.0, 2 * np.pi, (3, 2))
    return fade * np.sum(size * np.sin(rates[:, None] * time[:, None, None] + phase), axis=1)


def commands_alone(run: Recording) -> Recording:
    """The run as `exidyn import --effort command` reads one without torque."""
    from dataclasses import replace

    servo = servo_of(run.robot, None, None)
    signals: Any = {name: signal for name, signal in run.signals.items() if name != "torque"}
    settings = dict(run.settings) | {LAW: servo_words(servo)}
    return replace(run, signals=with_servo_error(signals, servo, run.name), settings=settings)
