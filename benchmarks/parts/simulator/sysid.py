"""Beside mujoco.sysid, by the same logs: numbers of a file that are wrong, and a delay of every servo.

Plain MuJoCo is the real arm; armature, damping, frictionloss and delay of every joint are drawn. mujoco.sysid
is told which numbers are wrong, and its simulation has their very physics. exidyn is told nothing: it fits
every number of the model, on the first motion, and decides by a second. A third judges both files.
"""

import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Any
from zlib import crc32

import mujoco
import numpy as np
from common import Kept, show

from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.in_mujoco.gap import gap
from exidyn.identification.in_mujoco.replay import POSITION
from exidyn.identification.in_mujoco.trial import Source
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import Recording

from .arms import SEEDS, TORQUE, Arm, logged, moved
from .concealed import described
from .concealed_gap import tool_error
from .real_arm import Item, places_of, set_number
from .score import said
from .speed import COULOMB, usual_torque

MODELS = ("ur10e", "panda_nohand", "iiwa14")
"""Models whose servos state a damping: one by `dampratio` would change with the armature."""
QUICK = ("iiwa14",)
SECONDS, QUICK_SECONDS = 20.0, 8.0
"""Duration of each run."""
SHARES = {"armature": (0.3, 2.0), "damping": (0.3, 2.0), "frictionloss": COULOMB}
"""Range of each number of a joint, over `starts`."""
NONE = {"armature": 0.1, "damping": 1.0}  # numbers for joints of which the file states none
DELAYS = (0.005, 0.03)
"""Range of the delays of servos [s]."""
LONGEST = 0.06
"""Upper bound of the search for a delay [s]."""
WIDEST = 10.0
"""Bounds of the search, over the largest number drawn."""
SENSORS = {"position": mujoco.mjtSensor.mjSENS_JOINTPOS, "torque": mujoco.mjtSensor.mjSENS_JOINTACTFRC}


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """Errors on the third motion and times of both, for every arm."""
    try:
        from mujoco.sysid import optimize  # noqa: F401
    except ImportError:
        print('beside mujoco.sysid: skipped, its libraries are missing; pip install "mujoco[sysid]"')
        return {}
    seconds = QUICK_SECONDS if quick else SECONDS
    by_arm = {
        name: kept.of(
            f"sysid, {name}, {seconds:g} s",
            lambda name=name: compared(folder / "mjcf" / f"{name}.xml", seconds),
        )
        for name in (QUICK if quick else MODELS)
    }
    head = ["arm", "the file", "exidyn", "sysid", "CPU exidyn [s]", "CPU sysid [s]"]
    keys = ("original_mm", "mm", "sysid_mm", "cpu", "sysid_cpu")
    rows = [[name, *(arm[key] for key in keys)] for name, arm in by_arm.items()]
    show("Tool point after 2 s on the third motion [mm]", head, rows)
    return {
        "sysid_error_ratio": max(arm["mm"] / arm["sysid_mm"] for arm in by_arm.values()),
        "sysid_cpu_ratio": max(arm["cpu"] / arm["sysid_cpu"] for arm in by_arm.values()),
        "beside_sysid": by_arm,
    }


def compared(path: Path, seconds: float) -> dict[str, Any]:
    """Both on one arm."""
    nominal = described(path)
    with tempfile.TemporaryDirectory() as scratch:
        real = Path(scratch) / path.name
        real.write_text(real_arm(path, nominal))
        arm = Arm(path.stem, real, nominal, _delays(path, nominal), TORQUE)
        motions = {role: moved(arm, seconds, seed) for role, seed in SEEDS.items()}
        true = arm.real().text()
    logs = {role: logged(arm, motion, SEEDS[role], role) for role, motion in motions.items()}
    judge = partial(tool_error, robot=nominal.robot, motion=motions["third"])
    text, cpu = timed(lambda: by_exidyn(path, nominal, logs))
    figures = {"original_mm": judge(path.read_text()), "true_mm": judge(true), "mm": judge(text), "cpu": cpu}
    sensed = motions["identify"]._replace(torque=motions["identify"].sensed)
    log = logged(arm, sensed, SEEDS["identify"], "identify")
    text, cpu = timed(partial(by_sysid, path, nominal, log, tuple(SENSORS)))
    return figures | {"sysid_mm": judge(text), "sysid_cpu": cpu}


def _delays(path: Path, nominal: Model) -> tuple[Item, ...]:
    """A delay of every servo."""
    draw = np.random.default_rng(crc32(f"{path.stem} delays".encode()))
    every = range(nominal.robot.dof)
    return tuple(Item("delay", (joint,), {"seconds": draw.uniform(*DELAYS)}) for joint in every)


def real_arm(path: Path, nominal: Model) -> str:
    """The file with other numbers in every joint, the same each time."""
    spec, draw = mujoco.MjSpec.from_file(str(path)), np.random.default_rng(crc32(path.stem.encode()))
    for name, numbers in starts(path, nominal).items():
        for key, start in numbers.items():
            set_number(spec.joint(name), key, draw.uniform(*SHARES[key]) * start)
    spec.compile()
    return str(spec.to_xml())


def starts(path: Path, nominal: Model) -> dict[str, dict[str, float]]:
    """Numbers of which those of the real arm are shares, by joint."""
    model, numbers = mujoco.MjModel.from_xml_path(str(path)), {}
    for name, torque in zip(nominal.robot.joints, usual_torque(nominal), strict=True):
        dof = int(model.joint(name).dofadr[0])
        stated = {key: float(getattr(model, f"dof_{key}")[dof]) or NONE[key] for key in NONE}
        numbers[name] = stated | {"frictionloss": float(torque)}
    return numbers


def by_exidyn(path: Path, nominal: Model, logs: dict[str, Recording]) -> str:
    """The file by exidyn, which is told nothing, from two motions."""
    source = Source(path.read_bytes(), str(path.parent), path.name)
    given = [(role, logs[role]) for role in ("identify", HELD_OUT)]
    return said(gap(source, nominal, given, POSITION), path.read_text()).file.decode()


def by_sysid(path: Path, nominal: Model, log: Recording, names: Sequence[str]) -> str:
    """The file by mujoco.sysid, from the file's numbers."""
    from mujoco import sysid

    spec = _measured(path, nominal.robot.joints, names)
    model, position = spec.compile(), log.signals["position"]
    servos = [place.actuator for place in places_of(model, nominal.robot.joints)]
    control = np.zeros((len(position), model.nu))
    control[:, servos] = log.signals["command"].values
    seen = np.hstack([log.signals[kind].values for kind in names])
    sequence = sysid.ModelSequences(
        "arm", spec, "log", _at_rest(model, servos, log),
        sysid.TimeSeries.from_control_names(position.time, control, model),
        # It stamps a sensor's reading in a state with the time of the next.
        sysid.TimeSeries.from_names(position.time + model.opt.timestep, seen, model),
    )  # fmt: skip
    told = _parameters(sysid, starts(path, nominal), servos).move_off_bounds()
    residual = sysid.build_residual_fn(models_sequences=[sequence], n_threads=1)
    with redirect_stdout(StringIO()):  # it prints every step
        fitted, _ = sysid.optimize(initial_params=told, residual_fn=residual, verbose=False)
    written = _measured(path, nominal.robot.joints, ())
    for parameter in fitted.values():
        parameter.modifier(written, parameter)
    written.compile()
    return str(written.to_xml())


def _measured(path: Path, joints: Sequence[str], names: Sequence[str]) -> Any:
    """The file with buffers for delays, and with sensors of these kinds."""
    spec = mujoco.MjSpec.from_file(str(path))
    step = spec.option.timestep
    for servo in spec.actuators:
        servo.nsample, servo.interp = int(np.ceil(LONGEST / step)) + 2, 1
    for kind in names:
        for joint in joints:
            spec.add_sensor(name=f"{kind} {joint}", type=SENSORS[kind], objtype=mujoco.mjtObj.mjOBJ_JOINT,
                            objname=joint)  # fmt: skip
    return spec


def _at_rest(model: mujoco.MjModel, servos: Sequence[int], log: Recording) -> np.ndarray:
    """State of the first sample: at rest, with its command in the buffers of all servos."""
    data = mujoco.MjData(model)
    places = places_of(model, log.robot.joints)
    data.qpos[[place.qpos for place in places]] = log.signals["position"].values[0]
    for servo, command in zip(servos, log.signals["command"].values[0], strict=True):
        count = int(model.actuator_history[servo, 0])
        past = model.opt.timestep * np.arange(-count, 0)
        mujoco.mj_initCtrlHistory(model, data, servo, past, np.full((count, 1), command))
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    return state


def _parameters(sysid: Any, first: dict[str, dict[str, float]], servos: Sequence[int]) -> Any:
    """Which numbers differ, from where the file has them, and within which bounds."""
    told = sysid.ParameterDict()
    for (joint, numbers), servo in zip(first.items(), servos, strict=True):
        for key, start in numbers.items():
            most = WIDEST * SHARES[key][1] * start
            begin = start if key != "frictionloss" else 1e-3 * most  # no file of these has any

            def modifier(spec: Any, parameter: Any, joint: str = joint, key: str = key) -> None:
                set_number(spec.joint(joint), key, float(parameter.value[0]))

            name = f"{joint} {key}"
            told.add(sysid.Parameter(name, begin, min_value=0.0, max_value=most, modifier=modifier))

        def later(spec: Any, parameter: Any, servo: int = servo) -> None:
            spec.actuators[servo].delay = float(parameter.value[0])

        limits = {"min_value": 0.0, "max_value": LONGEST}
        told.add(sysid.Parameter(f"{joint} delay", 0.1 * LONGEST, modifier=later, **limits))
    return told


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """The result of a function, and its CPU time [s]."""
    began = time.process_time()
    return work(), time.process_time() - began
