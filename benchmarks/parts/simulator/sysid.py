"""Beside mujoco.sysid, of the same logs: numbers of a file that are other ones in the real arm.

MuJoCo is the real arm, armature, damping and frictionloss of every joint drawn anew. mujoco.sysid is told
which numbers those are, and its simulation has their very physics; it begins at the file's and fits by
rollouts of whole runs. exidyn is told nothing, and fits every number of the model. Both files are then
simulated alike.
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

from exidyn.identification.export.mjcf_patch import patch
from exidyn.identification.export.portable import Portable
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.identified import identified, standard_parameters
from exidyn.identification.in_mujoco.distances import Distances, distances
from exidyn.identification.in_mujoco.replay import POSITION, Run, Simulator, servos
from exidyn.identification.model import Model
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.recording import Recording

from .concealed import Case, described, record
from .effect_arms import COULOMB, usual_torque

MODELS = ("ur10e", "panda_nohand", "iiwa14")
"""Whose servos have a damping of their own in the file: one by `dampratio` would change with the armature."""
QUICK = ("iiwa14",)
SECONDS, QUICK_SECONDS = 20.0, 6.0
"""Of each run: one is fitted, another one judges."""
SHARES = {"armature": (0.3, 2.0), "damping": (0.3, 2.0), "frictionloss": COULOMB}
"""Of each joint: of the file's number, or of that below where it has none; dry friction of the rms torque."""
NONE = {"armature": 0.1, "damping": 1.0}
WIDEST = 10.0
"""Bounds of the search, over the largest number drawn."""
SIGNALS = (("position",), ("position", "torque"))
"""That it is given; a quick run has the latter alone, which is the better on all three arms."""
SENSORS = {"position": mujoco.mjtSensor.mjSENS_JOINTPOS, "torque": mujoco.mjtSensor.mjSENS_JOINTACTFRC}


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """Held-out errors and times of both, of every arm."""
    try:
        from mujoco.sysid import optimize  # noqa: F401
    except ImportError:
        print('beside mujoco.sysid: skipped, its libraries are missing; pip install "mujoco[sysid]"')
        return {}
    seconds = QUICK_SECONDS if quick else SECONDS
    found = {
        name: kept.of(
            f"sysid, {name}, {seconds:g} s",
            lambda name=name: compared(folder / "mjcf" / f"{name}.xml", seconds),
        )
        for name in (QUICK if quick else MODELS)
    }
    head = ["arm", "the file", "exidyn", "sysid", "CPU exidyn [s]", "CPU sysid [s]"]
    rows = [[name, *(one[key] for key in ("before_mm", "mm", "sysid_mm", "cpu", "sysid_cpu"))]
            for name, one in found.items()]  # fmt: skip
    show("Tool point after 2 s on a run held out [mm]", head, rows)
    return {
        "error_over_sysid": max(one["mm"] / one["sysid_mm"] for one in found.values()),
        "cpu_over_sysid": max(one["cpu"] / one["sysid_cpu"] for one in found.values()),
        "beside_sysid": found,
    }


def compared(path: Path, seconds: float) -> dict[str, Any]:
    """Both on one arm; of sysid the better of positions alone and of torque beside them."""
    nominal = described(path)
    with tempfile.TemporaryDirectory() as scratch:
        real = Path(scratch) / path.name
        real.write_text(real_arm(path, nominal))
        case = Case(path.stem, real, nominal, None, ())
        logs = [record(case, seconds, seed, name) for seed, name in enumerate(("identify", "other"))]
        true = real.read_text()
    judge = [Run.of(logs[1], Filtering())]
    found: dict[str, Any] = {"before_mm": _tool(path.read_text(), path, nominal, judge)}
    (text, arm), found["cpu"] = timed(lambda: by_fit(path, nominal, logs[0]))
    found["mm"] = _tool(text.decode(), path, nominal, judge)
    found["attached_mm"] = _tool(text.decode(), path, arm, judge, attach=True)
    found["true_mm"] = _tool(true, path, nominal, judge)
    told = {}
    for names in SIGNALS if seconds == SECONDS else SIGNALS[-1:]:
        text, cpu = timed(partial(by_sysid, path, nominal, logs[0], names))
        told[" and ".join(names)] = {"mm": _tool(text, path, nominal, judge), "cpu": cpu}
    best = min(told.values(), key=lambda one: float(one["mm"]))
    return found | {"sysid_mm": best["mm"], "sysid_cpu": best["cpu"], "sysid_by": told}


def real_arm(path: Path, nominal: Model) -> str:
    """The file with other numbers in every joint, the same ones each time."""
    spec, draw = mujoco.MjSpec.from_file(str(path)), np.random.default_rng(crc32(path.stem.encode()))
    for name, numbers in starts(path, nominal).items():
        for key, start in numbers.items():
            _set(spec.joint(name), key, draw.uniform(*SHARES[key]) * start)
    spec.compile()
    return str(spec.to_xml())


def starts(path: Path, nominal: Model) -> dict[str, dict[str, float]]:
    """By joint, numbers of which those of the real arm are shares."""
    model, found = mujoco.MjModel.from_xml_path(str(path)), {}
    for name, torque in zip(nominal.robot.joints, usual_torque(nominal), strict=True):
        dof = int(model.joint(name).dofadr[0])
        own = {key: float(getattr(model, f"dof_{key}")[dof]) or NONE[key] for key in NONE}
        found[name] = own | {"frictionloss": float(torque)}
    return found


def _set(joint: Any, key: str, value: float) -> None:
    """Set a number of a joint, which is one of three where it is a ball's."""
    if np.ndim(getattr(joint, key)):
        getattr(joint, key)[0] = value
    else:
        setattr(joint, key, value)


def by_fit(path: Path, nominal: Model, log: Recording) -> tuple[bytes, Model]:
    """The file and the arm by exidyn's fit."""
    fit = identify([log], [], model=nominal)
    arm, text = identified(fit), path.read_bytes()
    made = patch(Portable.of(arm), standard_parameters(fit), text, str(path.parent), path.name)
    return made.text, arm


def by_sysid(path: Path, nominal: Model, log: Recording, names: Sequence[str]) -> str:
    """The file by mujoco.sysid, from the file's numbers."""
    from mujoco import sysid

    joints = nominal.robot.joints
    spec = mujoco.MjSpec.from_file(str(path))
    for kind in names:
        for joint in joints:
            spec.add_sensor(name=f"{kind} {joint}", type=SENSORS[kind], objtype=mujoco.mjtObj.mjOBJ_JOINT,
                            objname=joint)  # fmt: skip
    model, position = spec.compile(), log.signals["position"]
    velocity = np.gradient(position.values, position.time, axis=0)
    initial = sysid.create_initial_state(model, position.values[0], velocity[0], np.zeros(model.na))
    control = np.zeros((len(position), model.nu))
    control[:, servos(model, joints)] = log.signals["command"].values
    seen = np.hstack([log.signals[kind].values for kind in names])
    sequence = sysid.ModelSequences(
        "arm", spec, "log", initial, sysid.TimeSeries.from_control_names(position.time, control, model),
        sysid.TimeSeries.from_names(position.time, seen, model),
    )  # fmt: skip
    told = _parameters(sysid, starts(path, nominal)).move_off_bounds()
    residual = sysid.build_residual_fn(models_sequences=[sequence], n_threads=1)
    with redirect_stdout(StringIO()):  # it prints every step
        found, _ = sysid.optimize(initial_params=told, residual_fn=residual, verbose=False)
    written = mujoco.MjSpec.from_file(str(path))
    for parameter in found.values():
        parameter.modifier(written, parameter)
    written.compile()
    return written.to_xml()


def _parameters(sysid: Any, first: dict[str, dict[str, float]]) -> Any:
    """Which numbers differ, from where the file has them, and within which bounds."""
    told = sysid.ParameterDict()
    for joint, numbers in first.items():
        for key, start in numbers.items():
            most = WIDEST * SHARES[key][1] * start
            begin = start if key != "frictionloss" else 1e-3 * most  # no file of these has any

            def modifier(spec: Any, parameter: Any, joint: str = joint, key: str = key) -> None:
                _set(spec.joint(joint), key, float(parameter.value[0]))

            name = f"{joint} {key}"
            told.add(sysid.Parameter(name, begin, min_value=0.0, max_value=most, modifier=modifier))
    return told


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """What it gives, and its CPU time [s]."""
    began = time.process_time()
    return work(), time.process_time() - began


def _tool(text: str, path: Path, arm: Model, runs: Sequence[Run], attach: bool = False) -> float:
    """Error of the tool point after the longest horizon [mm]."""
    with Simulator(text, str(path.parent), arm, POSITION, attach) as simulator:
        found: Distances = distances(simulator, arm.robot, runs)
    return 1e3 * float(found.tool[-1])
