"""The library: `import exidyn as ex`.

A run is a `Recording`, the path of a file, a pandas table, or a mapping with the arguments of
`Recording.from_arrays`. An arm is a `Model`, a `pinocchio.Model`, the name of a built-in arm, or the path of
a robot.toml, URDF or MJCF.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pinocchio as pin

from exidyn.acquire.files.given_runs import distinct_bodies
from exidyn.acquire.files.result_files import read_result
from exidyn.acquire.files.simulated_arm import simulated_arm
from exidyn.acquire.run.expected_fit import ExpectedFit
from exidyn.acquire.run.expected_fit import expected_fit as _expected_fit
from exidyn.acquire.run.simulated import simulated
from exidyn.identification.contact import BANDWIDTH
from exidyn.identification.contact.contact import Contact
from exidyn.identification.contact.contact import contact as _contact
from exidyn.identification.contact.observer import Observer
from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.diagnosis.diagnose import diagnose as _diagnose
from exidyn.identification.diagnosis.improved.improved import found_model
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.diagnosis.words.diagnosis_file import as_json
from exidyn.identification.diagnosis.words.verdict import verdict as diagnosis_verdict
from exidyn.identification.effects import EFFECTS, known_parameters
from exidyn.identification.errors import ExidynError, FitError, RecordingError, UnknownKey
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.feedforward.cpp_file import cpp_file
from exidyn.identification.feedforward.feedforward import Feedforward, make_feedforward
from exidyn.identification.feedforward.python_file import python_file
from exidyn.identification.fit.estimators import ESTIMATORS
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit, write_fit
from exidyn.identification.fit.identification import identify as _identify
from exidyn.identification.fit.identified import identified
from exidyn.identification.fit.verdict import verdict as fit_verdict
from exidyn.identification.in_mujoco.gap import Gap
from exidyn.identification.in_mujoco.gap import gap as _gap
from exidyn.identification.in_mujoco.trial import Source
from exidyn.identification.model import Model
from exidyn.identification.pages.diagnosis_document import report_html as diagnosis_page
from exidyn.identification.pages.fit_document import report_html as fit_page
from exidyn.identification.payload.payload_estimate import PayloadEstimate
from exidyn.identification.payload.weigh import weigh as _weigh
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.recordings.tables.import_table import from_dataframe
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.comparison import Comparison
from exidyn.identification.simulation.comparison import compare as _compare
from exidyn.identification.simulation.plant import Transmission
from exidyn.trajectories.clearances.clearance import Clearance
from exidyn.trajectories.limits.usable_limits import Margins
from exidyn.trajectories.planning.planner import plan as _plan
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import read_plan, write_plan

__all__ = [
    "EFFECTS", "ESTIMATORS", "FORMATS", "Comparison", "Contact", "Diagnosis", "ExpectedFit", "Fit", "Gap",
    "Model", "Observer", "PayloadEstimate", "Plan", "Recording", "compare", "contact", "diagnose",
    "expected_fit", "gap", "identify", "load", "payload", "plan", "read", "read_all", "report",
    "robot", "simulate",
]  # fmt: skip

Run = Any
"""A recording, a path, a pandas table, or a mapping of arrays."""
Arm: TypeAlias = Model | pin.Model | Path | str


def robot(source: Arm) -> Model:
    """Read an arm with its effects: a built-in name, robot.toml, URDF, MJCF or `pinocchio.Model`.

    Raises:
        RobotError: The robot or file does not exist or has errors.
    """
    return source if isinstance(source, Model) else read_model(source)


def read(source: Run, robot: Arm | None = None, **options: Any) -> Recording:
    """Read one recording, written by exidyn or by other tools.

    Args:
        source: The run, usually the path of its file.
        robot: The arm; required if the file does not contain it.
        options: Options of the importer, such as the column names of a table.

    Raises:
        NotAFile: The format of the file is unknown.
        RecordingError: The file has several runs; use `read_all`.
    """
    recordings = read_all(source, robot, **options)
    if len(recordings) != 1:
        names = ", ".join(recording.name for recording in recordings)
        raise RecordingError(f"{source} has {len(recordings)} runs: {names}; read_all gives them all")
    return recordings[0]


def read_all(source: Run, robot: Arm | None = None, **options: Any) -> list[Recording]:
    """Read all runs of a file or folder; see `read`."""
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
        f"a {type(source).__name__} is not a run; give a Recording, a path, a pandas table or named arrays"
    )


_robot = robot  # its name is an argument below


def plan(
    robot: Arm, *, seconds: float = Wishes.seconds, criterion: str | None = None, fit: Fit | None = None,
    bodies: Sequence[tuple[tuple[str, float], ...]] = (), focus: Sequence[str] = (),
    start: np.ndarray | None = None, window: np.ndarray | None = None, margins: Margins = Margins(),  # noqa: B008
    clearances: Sequence[Clearance] = (), sure: float = Wishes.sure, harmonics: int = Wishes.harmonics,
    period: float | None = None, tick: float = Wishes.tick, rest: float = Wishes.rest,
    search_seconds: float = 60.0, search_iterations: int | None = None, seed: int = 0,
) -> Plan:  # fmt: skip
    """Plan the most informative trajectory within the limits of the robot.

    Args:
        robot: The arm.
        seconds: Duration of the whole run, with rests and leads [s].
        criterion: Name of the criterion; by default the condition number, with `bodies` the drive gains, and
            with `fit` the worst relative standard deviation.
        fit: Fit of earlier runs.
        bodies: Known parameters of the payload of each further run, from `known_parameters`.
        focus: Names, or beginnings of names, of the base parameters to optimize; "gain" for the drive gains.
        start: Pose at start and end, shape (n,) [rad].
        window: Largest distance from the start, shape (n,) [rad].
        margins: Safety margins to the limits.
        clearances: Collisions and regions.
        sure: Share of the likely arms that keep to the torque limits [-].
        harmonics: Number of harmonics of each joint.
        period: Base period [s]; several are tried by default.
        tick: Sampling period of the controller [s].
        rest: Least rest at each end [s].
        search_seconds: Duration of the search [s].
        search_iterations: Iterations of each start of the search. They replace `search_seconds`, so that a
            slow or busy computer plans the same motion.
        seed: Seed of the search.

    Raises:
        TrajectoryError: Limits are not stated, or no motion respects all of them.
    """
    wishes = Wishes(
        seconds=seconds, criterion=criterion, fit=fit, bodies=bodies, focus=focus, start=start, window=window,
        margins=margins, clearances=clearances, sure=sure, harmonics=harmonics, period=period, tick=tick,
        rest=rest,
    )  # fmt: skip
    [best] = _plan(_robot(robot), wishes, seconds=search_seconds, iterations=search_iterations, seed=seed)
    return best


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
    """Identify the base parameters of an arm, and its drive gains if a run has a known payload.

    Args:
        runs: Runs to fit.
        validate: Validation runs, which are only predicted.
        robot: The arm, which replaces the arm inside the recordings; required for arrays and tables.
        estimator: A name in `ESTIMATORS`; by default maximum likelihood with a known payload, and
            weighted least squares without.
        filtering: Filters; unset values are chosen from the data.
        t: Time of one more run to fit, given as arrays, shape (t,) [s].
        q: Positions of that run, shape (t, n) [rad].
        torque: Joint torques of that run, shape (t, n) [N m]; give either torques or currents.
        current: Motor currents of that run, shape (t, n) [A].
        degrees: Whether the positions of that run are in degrees.
        urdf: Path of the robot file; another name for `robot`.
        payload: Further runs to fit, in which the arm carries a payload.
        mass: Mass of the payload in the `payload` runs [kg]; without such runs, in the run `t`, `q`.
        com: Center of mass of that payload in the flange frame, shape (3,) [m].
        options: drop, fitted_shapes, repeat, progress; see
            `exidyn.identification.fit.identification.identify`.

    Example:
        >>> fit = ex.identify(t=t, q=q, torque=torque, urdf="arm.urdf")
        >>> print(fit.verdict, fit["Fv1"].interval)

    Raises:
        UnknownKey: The estimator does not exist.
        ExidynError: The runs cannot be fitted; the message gives the reason.
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


def payload(
    runs: Run | Sequence[Run],
    fit: Fit | Path | str | None = None,
    empty: Run | Sequence[Run] = (),
    robot: Arm | None = None,
    com: Sequence[float] | None = None,
    filtering: Filtering = Filtering(),  # noqa: B008
    as_recorded: bool = False,
) -> PayloadEstimate:
    """Identify the payload on the flange: mass, center of mass and inertia with 95 % intervals.

    Args:
        runs: Runs with the payload, the same in all.
        fit: Fit of the arm without it, or the path of its file; gives the narrowest intervals.
        empty: Runs without the payload; without a fit, the payload is the difference.
        robot: The arm, which replaces the arm inside the recordings; required for arrays and tables without
            a fit. With neither fit nor empty runs, its tolerances make the intervals wide.
        com: Center of mass in the flange frame if it is known, shape (3,) [m]. An arm of one or two joints
            does not determine mass and center both.
        filtering: Filters; unset values are chosen from the data.
        as_recorded: Whether to skip the check of columns, units and signs.

    Example:
        >>> tool = ex.payload("loaded.mcap", fit="exidyn-fit/fit.json")
        >>> tool.mass.value, tool.mass.low, tool.mass.high
        (2.81, 2.76, 2.86)
        >>> print(tool.text("ur"))

    Raises:
        ExidynError: The runs cannot be used; the message gives the reason.
    """
    fitted = read_fit(fit) if isinstance(fit, Path | str) else fit
    arm = fitted.model if robot is None and fitted is not None else robot
    return _weigh(
        _runs(runs, arm),
        fit=fitted,
        empty=_runs(empty, arm),
        model=None if robot is None else _robot(robot),
        com=com,
        filtering=filtering,
        as_recorded=as_recorded,
    )


def diagnose(
    runs: Run | Sequence[Run],
    validate: Run | Sequence[Run] = (),
    robot: Arm | None = None,
    filtering: Filtering = Filtering(),  # noqa: B008
    as_recorded: bool = False,
) -> Diagnosis:
    """Find the physics that the model lacks, with evidence and alternatives; see `identify`.

    With `as_recorded`, columns, units and signs are used as stated, however unlikely.

    Raises:
        ExidynError: The runs cannot be used; the message gives the reason.
    """
    fitted, held_out = _runs(runs, robot), _runs(validate, robot)
    if not fitted:
        raise RecordingError("nothing to diagnose; give at least one recording besides those for validation")
    model = fitted[0].model if robot is None else _robot(robot)
    roles = [(run.settings.get("role", ""), run) for run in fitted]
    recordings = [*roles, *((HELD_OUT, run) for run in held_out)]
    return _diagnose(model, recordings, filtering=filtering, as_recorded=as_recorded)


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
    """Simulate a plan in closed loop: the arm with all its effects, typical drives and sensors.

    Args:
        robot: The arm.
        plan: Planned motion, or the path of its file.
        payload: Payload of the model that is on the flange.
        stiffness: Stiffness of the gears, one value or one per joint [N m/rad].
        damping: Damping of the gears, one value or one per joint [N m s/rad].
        backlash: Total backlash of the gears, one value or one per joint [rad].
        tick: Sampling period [s].
        seed: Seed of the sensor noise.
        exact: Whether sensors have neither noise nor quantization.

    Raises:
        ExidynError: The plan belongs to another arm, or the arm cannot be simulated.
    """
    arm = _robot(robot)
    n = arm.robot.dof
    gears = Transmission(
        *(np.broadcast_to(np.array(value, float), (n,)) for value in (stiffness, damping, backlash))
    )
    planned = plan if isinstance(plan, Plan) else read_plan(Path(plan))
    return simulated(arm, planned, arm, payload, gears, tick=tick, seed=seed, exact=exact)


def expected_fit(
    robot: Arm,
    plan: Plan | Path | str | Sequence[Plan | Path | str],
    *,
    mass: float | None = None,
    com: Sequence[float] | None = None,
    seed: int = 0,
) -> ExpectedFit:
    """State what planned motions would determine, and how well: a fit of runs on a simulated arm.

    Args:
        robot: The arm; the simulated one has values off by up to their tolerances.
        plan: One planned motion or several.
        mass: Mass of a payload with which each motion is run as well [kg].
        com: Its center of mass in the flange frame, shape (3,) [m].
        seed: Seed of the sensors' noise.

    Example:
        >>> expected = ex.expected_fit("robot.toml", "trajectory.toml")
        >>> expected.sentences, expected.open

    Raises:
        ExidynError: The arm cannot be simulated, or the motions are too poor to identify it.
    """
    sources = [plan] if isinstance(plan, Plan | Path | str) else list(plan)
    plans = [source if isinstance(source, Plan) else read_plan(Path(source)) for source in sources]
    bodies = [] if mass is None else [known_parameters(mass, com)]
    return _expected_fit(plans, _robot(robot), bodies, seed=seed)


def compare(simulated: Run, recorded: Run, robot: Arm | None = None) -> Comparison:
    """Compare two recordings of the same motion, by joint and by region of the motion.

    Raises:
        RecordingError: The recordings are different motions.
    """
    return _compare(read(simulated, robot), read(recorded, robot))


def gap(
    mjcf: Path | str,
    runs: Run | Sequence[Run],
    validate: Run | Sequence[Run],
    *,
    commands: str = "",
    judge: str = "tool",
    filtering: Filtering = Filtering(),  # noqa: B008
    as_recorded: bool = False,
) -> Gap:
    """Improve a MuJoCo model: servos and delays, numbers of the file, and missing effects.

    Args:
        mjcf: Path of the MJCF.
        runs: Runs to fit.
        validate: Runs that are only simulated; they decide what is written.
        commands: "position" or "torque"; by default, what the file and the runs support.
        judge: Whose error decides, "tool" or "joints".
        filtering: Filters; unset values are chosen from the data.
        as_recorded: Whether to skip the check of columns, units and signs.

    Example:
        >>> result = ex.gap("arm.xml", "run.mcap", validate="other.mcap")
        >>> Path("arm-identified.xml").write_bytes(result.file.text)
        >>> for change in result.servos:
        ...     print(change.joint, change.quantity, change.old, change.new, change.half)

    Raises:
        ExidynError: The file or the runs cannot be used; the message gives the reason.
    """
    path = Path(mjcf)
    fitted, held_out = _runs(runs, path), _runs(validate, path)
    if not fitted:
        raise RecordingError("no run to fit; give at least one recording besides those for validation")
    recordings = [(run.settings.get("role", ""), run) for run in fitted]
    recordings += [(HELD_OUT, run) for run in held_out]
    source = Source(path.read_bytes(), str(path.resolve().parent), str(path))
    model = simulated_arm(path, fitted[0].robot)
    return _gap(source, model, recordings, commands, filtering, as_recorded=as_recorded, judge_by=judge)


def contact(
    fit: Fit | Path | str,
    run: Run,
    free: Run | Sequence[Run] = (),
    *,
    payload: str | None = None,
    alarms_per_hour: float = 1.0,
    bandwidth: float = BANDWIDTH,
) -> Contact:
    """Estimate external torques along a run, and find contacts.

    Args:
        fit: The fit, or the path of its file.
        run: The run.
        free: Runs without contact that the fit has not used, for the threshold.
        payload: Name of the payload on the flange, "" for none; by default that of the recording. The weight
            of a payload that is not named is an external force.
        alarms_per_hour: Accepted false alarms [1/h].
        bandwidth: Bandwidth of the observer [Hz].

    Example:
        >>> result = ex.contact("fit.json", "run.mcap", free="other.mcap")
        >>> for alarm in result.alarms:
        ...     print(alarm.start, alarm.torque)

    Raises:
        ExidynError: The runs cannot be used; the message gives the reason.
    """
    result = fit if isinstance(fit, Fit) else read_fit(fit)
    others = _runs(free, result.model)
    return _contact(result, read(run, result.model), others, payload, alarms_per_hour, bandwidth)


def load(path: Path | str) -> Fit | Diagnosis | Comparison:
    """Read a saved result: fit.json, diagnosis.json or the JSON of a comparison.

    The file of a diagnosis does not contain the samples of its runs, so it gives no model and no plots.

    Example:
        >>> ex.load("exidyn-diagnosis/diagnosis.json").findings
        (Finding joint_spring of joint 2, 98.7 %: Ks2 11.93 ± 0.18 N m/rad,)

    Raises:
        NotAFile: The file is not a result, has another format, or is damaged; the message names the field.
    """
    return read_result(Path(path))


def report(result: Fit | Diagnosis, path: Path | str) -> Path:
    """Write a fit or a diagnosis as one HTML page and return its path.

    Raises:
        ExidynError: The result is neither a fit nor a diagnosis.
    """
    if not isinstance(result, Fit | Diagnosis):
        raise ExidynError(f"report: {type(result).__name__} has no page; expected a Fit or a Diagnosis")
    page = fit_page(result) if isinstance(result, Fit) else diagnosis_page(result)
    Path(path).write_text(page, encoding="utf-8")
    return Path(path)


def _runs(runs: Run | Sequence[Run], robot: Arm | None) -> list[Recording]:
    """Recordings of one or several runs in any accepted form."""
    sources = runs if isinstance(runs, Sequence) and not isinstance(runs, str) else [runs]
    return [recording for source in sources for recording in read_all(source, robot)]


def _carrying(run: Recording, mass: float | None, com: Sequence[float] | None) -> Recording:
    """The run with a payload of this mass; without a mass, with the payload that its file states."""
    if mass is None:
        return run if run.payload else replace(run, payload=KnownPayload())
    name = run.payload.name if run.payload else KnownPayload().name
    return replace(run, payload=KnownPayload(name, known_parameters(mass, com)))


# Methods of results that need pages, files or exports. Results are values that do not know those layers, so
# their methods are bound here.


def save(result: Fit | Diagnosis | Plan, path: Path | str) -> Path:
    """Write a fit or a diagnosis as JSON for `ex.load`, or a plan for `exidyn record`; returns the path."""
    if isinstance(result, Fit):
        return write_fit(result, path)
    if isinstance(result, Plan):
        return write_plan(result, path)
    Path(path).write_text(json.dumps(as_json(result), indent=1, allow_nan=False), encoding="utf-8")
    return Path(path)


def verdict(result: Fit | Diagnosis) -> str:
    """Sentences: how well a fit explains each joint and what it leaves open, or the missing effects."""
    return "\n".join(fit_verdict(result) if isinstance(result, Fit) else diagnosis_verdict(result))


def export(fit: Fit, format: str, path: Path | str | None = None, payload: str = "") -> str:
    """Identified model as text for a simulator, also written to a file if a path is given.

    Args:
        fit: The fit.
        format: Name in `FORMATS`, such as urdf, mjcf, json or toml.
        path: File to write.
        payload: Name of a payload of the model that becomes part of the last link.

    Raises:
        UnknownKey: There is no such format; the message lists the valid ones.
    """
    if format not in FORMATS:
        raise UnknownKey(format, "export: format", tuple(FORMATS))
    text = FORMATS[format].text(Portable.of(identified(fit), payload))
    if path is not None:
        Path(path).write_bytes(text.encode())
    return text


def model_with_findings(diagnosis: Diagnosis) -> Model:
    """The model with all findings that a model can hold.

    Raises:
        ExidynError: The diagnosis comes from a file and has no model.
    """
    model = found_model(diagnosis)
    if model is None:
        raise ExidynError("this diagnosis was read from a file, which does not contain its model")
    return model


def save_feedforward(feedforward: Feedforward, path: Path | str) -> Path:
    """Write a Python file (.py) or a C++ header (.hpp, .h) and return its path.

    Raises:
        FitError: The ending is another one.
    """
    path, texts = Path(path), {".py": python_file, ".hpp": cpp_file, ".h": cpp_file}
    if path.suffix not in texts:
        raise FitError(f"{path}: the name must end in {', '.join(texts)}")
    path.write_text(texts[path.suffix](feedforward), encoding="utf-8")
    return path


METHODS: dict[type, dict[str, Any]] = {
    Fit: {
        "verdict": property(verdict),
        "identified": property(identified),
        "feedforward": make_feedforward,
        "export": export,
        "save": save,
        "report": report,
    },
    Plan: {"save": save},
    Feedforward: {"python": python_file, "cpp": cpp_file, "save": save_feedforward},
    Diagnosis: {
        "verdict": property(verdict),
        "model": property(model_with_findings),
        "to_json": as_json,
        "save": save,
        "report": report,
    },
}
"""Result -> its methods; the classes declare them for type checkers."""
for _result, _methods in METHODS.items():
    for _name, _method in _methods.items():
        setattr(_result, _name, _method)
