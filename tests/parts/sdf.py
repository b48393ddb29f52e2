"""A URDF as libsdformat reads it, where that is."""

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import CoulombFriction, RigidBody, RotorInertia, ViscousFriction
from exidyn.identification.export import Portable
from exidyn.identification.model import Model

from ..identify.simulation.test_plant_forces import drawn
from .runs.simulated import known
from .system_needs import SDFORMAT, sdformat

READER = Path(__file__).with_name("sdf_reader.cpp")
EFFECTS = (RigidBody(), RotorInertia(), ViscousFriction(), CoulombFriction())


def portable(robot, *more, limited=True, **changed):
    n = robot.dof
    limits = Limits(*np.outer([-2.0, 1.5, 3.0, 9.0, 90.0, 40.0], np.arange(1.0, n + 1.0)))
    robot = replace(robot, **({"limits": limits} if limited else {}), **changed)
    model = Model(robot, (*EFFECTS, *more))
    return Portable.of(known(model, drawn(model)))


def read_by_libsdformat(text, tmp_path):
    """Rows of links and joints as that library has them, by name."""
    SDFORMAT.require()
    command = ["pkg-config", "--cflags", "--libs", sdformat()]
    flags = subprocess.run(command, check=True, capture_output=True, text=True)
    program, model = tmp_path / "reader", tmp_path / "arm.sdf"
    made = ["g++", "-std=c++17", "-O0", str(READER), "-o", str(program), *flags.stdout.split()]
    subprocess.run(made, check=True, capture_output=True)
    model.write_text(text)
    read = subprocess.run([program, model], capture_output=True, text=True)
    assert read.returncode == 0, read.stderr
    assert not read.stderr
    rows = [line.split() for line in read.stdout.splitlines()]
    return {(kind, name): np.array(numbers, float) for kind, name, *numbers in rows}
