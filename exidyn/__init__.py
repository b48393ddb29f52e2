"""Identify the dynamics of robot arms: excite, record, identify, diagnose.

    import exidyn as ex

    fit = ex.identify("run.mcap", robot="arm.urdf")
    print(fit.verdict)

Functions:

    robot        Read an arm with its effects: a built-in name, robot.toml, URDF, MJCF or `pinocchio.Model`.
    read         Read one recording, written by exidyn or by other tools.
    read_all     Read all runs of a file or folder; see `read`.
    plan         Plan the most informative trajectory within the limits of the robot.
    expected_fit State what planned motions would determine, and how well: a fit of runs on a simulated arm.
    simulate     Simulate a plan in closed loop: the arm with all its effects, typical drives and sensors.
    identify     Identify the base parameters of an arm, and its drive gains if a run has a known payload.
    payload      Identify the payload on the flange: mass, center of mass and inertia with 95 % intervals.
    diagnose     Find the physics that the model lacks, with evidence and alternatives; see `identify`.
    contact      Estimate external torques along a run, and find contacts.
    gap          Improve a MuJoCo model: servos and delays, numbers of the file, and missing effects.
    compare      Compare two recordings of the same motion, by joint and by region of the motion.
    report       Write a fit or a diagnosis as one HTML page and return its path.
    load         Read a saved result: fit.json, diagnosis.json or the JSON of a comparison.

The names of `exidyn.api` are imported on first use, so that `exidyn --help` does not load Pinocchio.
"""

import sys
from importlib import import_module, metadata
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api import *  # noqa: F403

__version__ = metadata.version("exidyn")

if not Path(__file__).with_name("identification").exists():
    # In a checkout, the packages are beside this folder (see setup.py). The folder `identify` is the package
    # `identification`, since `exidyn.identify` is a function.
    __path__.append(str(Path(__file__).parents[1]))  # noqa: F405
    _spec = spec_from_file_location(
        f"{__name__}.identification", Path(__file__).parents[1] / "identify" / "__init__.py"
    )
    if _spec and _spec.loader:
        identification = sys.modules[_spec.name] = module_from_spec(_spec)
        _spec.loader.exec_module(identification)


def __getattr__(name: str) -> Any:
    if name == "__all__":
        return __dir__()
    if name.startswith("_"):  # special names, which Python itself looks up
        raise AttributeError(name)
    if name not in __dir__():
        raise AttributeError(f"exidyn has no '{name}'. It has: {', '.join(__dir__())}")
    return getattr(import_module(".api", __name__), name)


def __dir__() -> list[str]:
    return [*import_module(".api", __name__).__all__, "__version__"]
