"""The library: `import exidyn as ex`.

A run is a `Recording`, the path of a file, a pandas table, or a mapping of arrays as `Recording.from_arrays`
takes them. An arm is a `Model`, the name of a built-in one, or the path of a robot.toml, URDF or MJCF.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.acquire.files.given_runs import distinct_bodies
from exidyn.acquire.files.report_files import read_result
from exidyn.acquire.run.simulated import simulated
from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.diagnose import diagnose as _diagnose
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.effects import EFFECTS, known_parameters
from exidyn.identification.errors import ExidynError, RecordingError, UnknownKey
from exidyn.identification.export import FORMATS
from exidyn.identification.fit.estimators import ESTIMATORS
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit as _read_fit
from exidyn.identification.fit.identification import identify as _identify
from exidyn.identification.model import Model
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.from_arrays import from_dataframe
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.comparison import Comparison
from exidyn.identification.simulation.comparison import compare as _compare
from exidyn.identification.simulation.plant import Transmission
from exidyn.trajectories.planning.planner import plan as _plan
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import read_plan

__all__ = [
    "EFFECTS", "ESTIMATORS", "FORMATS", "Comparison", "Diagnosis", "Fit", "Model", "Plan", "Recording",
    "compare", "diagnose", "identify", "load", "plan", "read", "read_all", "read_fit", "report", "robot",
    "simulate",
]  # fmt: skip

Run = Any
"""A recording, a path, a pandas table, or a mapping of arrays."""
Arm = Model | Path | str


def robot(source: Arm) -> Model:
    """A robot with its effects: by the name of a built-in one, from robot.toml or from a URDF.

    Raises:
        RobotError: There is no such robot or file, or it is wrong.
    """
    return source if isinstance(source, Model) else read_model(source)


def read(source: Run, robot: Arm | None = None, **options: Any) -> Recording:
    """One recording: of exidyn's own, or imported from a file of other tools.

    Args:
        source: A file.
        robot: Where the file does not name it.
        options: Of the importer, such as the names of a table's columns.

    Raises:
        NotAFile: The file is of no known kind.
        RecordingError: There are several runs; `read_all` gives them.
    """
    found = read_all(source, robot, **options)
    if len(found) != 1:
        names = ", ".join(one.name for one in found)
        raise RecordingError(f"{source} has {len(found)} runs: {names}; read_all gives them all")
    return found[0]


def read_all(source: Run, robot: Arm | None = None, **options: Any) -> list[Recording]:
    """All runs of a file or a folder, see `read`."""
    if isinstance(source, Recording):
        return [source]
    if isinstance(source, Path | str):
        return import_source(source, None if robot is None else _robot(robot), **options)
    if robot is None:
        raise RecordingError("arrays and tables do not name their robot: give robot= or urdf=")
    if isinstance(source, Mapping):
        return [Recording.from_arrays(robot, **source, **options)]
    if hasattr(source, "to_numpy"):
        return from_dataframe(source, _robot(robot), **options)
    raise RecordingError(
        f"a {type(source).__name__} is no run; expected a Recording, a path, a pandas table or arrays by name"
    )


_robot = robot  # its name is an argument below


def plan(robot: Arm, *, search_seconds: float = 60.0, seed: int = 0, **wishes: Any) -> Plan:
    """The most informative trajectory that keeps to the robot's limits.

    Args:
        robot: The arm.
        search_seconds: Time for the search [s].
        seed: Of the search.
        wishes: Of `Wishes`: seconds, criterion, harmonics, period, margins, start, tick, clearances.

    Raises:
        UnknownKey: A wish that there is not.
        TrajectoryError: No motion keeps to all limits, or they are not stated.
    """
    valid = tuple(Wishes.__dataclass_fields__)
    for name in wishes:
        if name not in valid:
            raise UnknownKey(name, "plan: wish", valid)
    [found] = _plan(_robot(robot), Wishes(**wishes), seconds=search_seconds, seed=seed)
    return found


def identify(
    runs: Run | Sequence[Run] = (),
    validate: Run | Sequence[Run] = (),
    robot: Arm | None = None,
    estimator: str = "",
    filtering: Filtering = Filtering(),  # noqa: B008
    *,
    t: Any = None,
    q: Any = None,
    torque: Any = None,
    current: Any = None,
    degrees: bool = False,
    urdf: Path | str | None = None,
    payload: Run | Sequence[Run] = (),
    mass: float | None = None,
    com: Sequence[float] | None = None,
    **options: Any,
) -> Fit:
    """Base parameters of an arm, and its drive gains where a run carries a known payload.

    Args:
        runs: To fit.
        validate: Only predicted.
        robot: The arm, which replaces the one inside the recordings; arrays and tables need one.
        estimator: A name in `ESTIMATORS`; maximum likelihood with a known payload by default, else weighted.
        filtering: Filters; chosen from the data where none is given.
        t: Time of one more run to fit, given as arrays, shape (t,) [s].
        q: Positions of that run, shape (t, n) [rad].
        torque: Joint torques of that run, shape (t, n) [N m]; give these or the currents.
        current: Motor currents of that run, shape (t, n) [A].
        degrees: Whether the positions of that run are in degrees.
        urdf: Path of the robot's file; another name for `robot`.
        payload: Further runs to fit, in which the arm carries a body on the flange.
        mass: Mass of the body in the `payload` runs [kg]; without such runs, of the body in the run `t`, `q`.
        com: Center of mass of that body from the flange's origin, in the flange's axes, shape (3,) [m].
        options: drop, fitted_shapes, progress: see `exidyn.identification.fit.identification.identify`.

    Example:
        >>> fit = ex.identify(t=t, q=q, torque=torque, urdf="arm.urdf")
        >>> print(fit.verdict, fit["Fv1"].interval)

    Raises:
        UnknownKey: There is no such estimator.
        ExidynError: The runs cannot carry a fit; the message gives the reason.
    """
    if estimator and estimator not in ESTIMATORS:
        raise UnknownKey(estimator, "identify: estimator", tuple(ESTIMATORS))
    arm = urdf if robot is None else robot
    loaded = [_carrying(run, mass, com) for run in _runs(payload, arm)]
    fitted = [*_runs(runs, arm), *loaded]
    if t is not None or q is not None:
        body = {} if loaded or mass is None else {"mass": mass, "com": com}
        arrays = {"t": t, "q": q, "torque": torque, "current": current, "degrees": degrees}
        fitted += _runs({**arrays, **body}, arm)
    held_out = _runs(validate, arm)
    runs_used = distinct_bodies([*fitted, *held_out])
    return _identify(
        runs_used[: len(fitted)],
        runs_used[len(fitted) :],
        model=None if arm is None else _robot(arm),
        estimator=ESTIMATORS[estimator] if estimator else None,
        filtering=filtering,
        **options,
    )


def read_fit(path: Path | str) -> Fit:
    """A fit that `Fit.save` or `exidyn identify` has written.

    Raises:
        NotAFile: There is none at that path, or it is of another kind.
    """
    return _read_fit(path)


def diagnose(
    runs: Run | Sequence[Run],
    validate: Run | Sequence[Run] = (),
    robot: Arm | None = None,
    filtering: Filtering = Filtering(),  # noqa: B008
    as_recorded: bool = False,
) -> Diagnosis:
    """Which physics the model leaves out, with what evidence and which alternatives; see `identify`.

    `as_recorded` takes columns, units and signs as they are stated, however unlikely.

    Raises:
        ExidynError: The runs cannot be used; the message gives the reason.
    """
    fitted, held_out = _runs(runs, robot), _runs(validate, robot)
    if not fitted:
        raise RecordingError("nothing to diagnose; give at least one recording besides those for validation")
    model = fitted[0].model if robot is None else _robot(robot)
    roles = [(run.settings.get("role", ""), run) for run in fitted]
    every = [*roles, *((HELD_OUT, run) for run in held_out)]
    return _diagnose(model, every, filtering=filtering, as_recorded=as_recorded)


def simulate(
    robot: Arm,
    plan: Plan | Path | str,
    *,
    payload: KnownPayload | None = None,
    stiffness: float | Sequence[float] = np.inf,
    damping: float | Sequence[float] = 0.0,
    backlash: float | Sequence[float] = 0.0,
    tick: float = 0.002,
    seed: int = 0,
    exact: bool = False,
) -> Recording:
    """A planned motion in closed loop: the arm with all its effects, typical drives and sensors.

    Args:
        robot: The arm.
        plan: Its motion.
        payload: A payload of the model that is on the flange.
        stiffness: Of the gears, one number or one a joint [N m/rad].
        damping: Likewise [N m s/rad].
        backlash: Likewise, whole width [rad].
        tick: From sample to sample [s].
        seed: Of the sensors' noise.
        exact: Sensors without noise and steps.

    Raises:
        ExidynError: The motion is of another arm, or the arm cannot be simulated.
    """
    arm = _robot(robot)
    n = arm.robot.dof
    gears = Transmission(
        *(np.broadcast_to(np.array(one, float), (n,)) for one in (stiffness, damping, backlash))
    )
    planned = plan if isinstance(plan, Plan) else read_plan(Path(plan))
    return simulated(arm, planned, arm, payload, gears, tick=tick, seed=seed, exact=exact)


def compare(simulated: Run, recorded: Run, robot: Arm | None = None) -> Comparison:
    """Where two recordings of one motion differ, by joint and by region of the motion.

    Raises:
        RecordingError: They are not of one motion.
    """
    return _compare(read(simulated, robot), read(recorded, robot))


def load(path: Path | str) -> Fit | Diagnosis | Comparison:
    """A result that was saved: fit.json, diagnosis.json or the JSON of a comparison.

    A diagnosis comes without the samples of its runs, so that it has no model and no plots.

    Example:
        >>> ex.load("exidyn-diagnosis/diagnosis.json").findings
        (Finding joint_spring of joint 2, 98.7 %: Ks2 11.93 ± 0.18 N m/rad,)

    Raises:
        NotAFile: It is no result, of another format, or damaged; the message names the field.
    """
    return read_result(Path(path))


def report(result: Fit | Diagnosis, path: Path | str) -> Path:
    """Write a fit or a diagnosis as one HTML page; gives its path.

    Raises:
        ExidynError: It is neither.
    """
    if not isinstance(result, Fit | Diagnosis):
        raise ExidynError(f"report: {type(result).__name__} has no page; expected a Fit or a Diagnosis")
    return result.report(path)


def _runs(given: Run | Sequence[Run], robot: Arm | None) -> list[Recording]:
    """Recordings, whatever stands for them."""
    several = given if isinstance(given, Sequence) and not isinstance(given, str) else [given]
    return [recording for one in several for recording in read_all(one, robot)]


def _carrying(run: Recording, mass: float | None, com: Sequence[float] | None) -> Recording:
    """Add a body of this mass to the run; without a mass, keep the body that its file states."""
    if mass is None:
        return run if run.payload else replace(run, payload=KnownPayload())
    name = run.payload.name if run.payload else KnownPayload().name
    return replace(run, payload=KnownPayload(name, known_parameters(mass, com)))
