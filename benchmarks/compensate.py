"""What a feedforward leaves of the torque of held-out public recordings, and what a call of it costs.

Arms: a UR10e and a KUKA KR300 (`EXIDYN_DATA` names their folder; without it only the times of the built-in
KR270 are measured). The fit is the library's own, from the training runs. Torques have passed the decimation
filter of the fit, and samples in which a joint stands do not count: what holds it is not known. Times are the
least of several rounds.
"""

import os
import shutil
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy: one thread

import numpy as np
from common import options, save, show
from parts.real.data import FOLDER, KR300, UR10E, DataSet

from exidyn.identification.arm.motion import Motion
from exidyn.identification.dynamics.dynamics import Dynamics
from exidyn.identification.feedforward.cpp_file import cpp_file
from exidyn.identification.feedforward.feedforward import SHARE, Feedforward, make_feedforward
from exidyn.identification.feedforward.python_file import python_file
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.preparation.prepare import Prepared, prepare
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model

CALLS, QUICK_CALLS = 200_000, 40_000


WHAT = ("gravity", "gravity and friction", "compensation", "inverse dynamics")
"""What is subtracted: holding torque; friction in full; friction as it is compensated, to 70 %; all."""


def left(name: str, fit: Fit, runs: Sequence[Recording]) -> dict[str, Any]:
    """A table: root mean square torque of all runs, and the share of it that is left [%]."""
    feedforward = make_feedforward(fit)
    squares = np.array([_squares(feedforward, prepare(run, fit.filtering)) for run in runs]).sum(axis=0)
    counts, measured, *rest = squares
    rms = np.sqrt(measured / np.maximum(counts, 1.0))
    shares = {what: 100.0 * np.sqrt(part / measured) for what, part in zip(WHAT, rest, strict=True)}
    joints = [f"J{j + 1}" for j in range(len(rms))]
    rows = [["torque [N m]", *rms], *([f"after {what} [%]", *values] for what, values in shares.items())]
    show(f"{name}: torque of held-out runs, and what is left of it", ["", *joints], rows)
    return {"torque_rms": rms, "left_percent": shares}


def _squares(feedforward: Feedforward, run: Prepared) -> np.ndarray:
    """Number of samples, and sums of squares of the measured torque and of each remainder, (6, n)."""
    gain = 1.0 if feedforward.gain is None else feedforward.gain
    measured = run.decimation.apply((gain * run.current) @ feedforward.robot.coupling)
    parts = [run.decimation.apply(part) for part in _predicted(feedforward, run.motion)]
    remainders = [measured, *(measured - part for part in parts)]
    return np.array([run.weight.sum(axis=0), *(np.sum(run.weight * r**2, axis=0) for r in remainders)])


def _predicted(feedforward: Feedforward, motion: Motion) -> list[np.ndarray]:
    """Torques in the order of `WHAT`, each (t, n)."""
    q, dq, warm = motion.position, motion.velocity, motion.temperature
    gravity = feedforward.gravity(q, warm)
    return [
        gravity,
        gravity + feedforward.friction(q, dq, warm),
        feedforward.compensation(q, dq, warm),
        feedforward.torque(q, dq, motion.acceleration, warm),
    ]


NAMES = {"gravity": 1, "compensation": 2, "inverse_dynamics": 3}
"""Function -> number of its arguments."""
ROUNDS = 5
MAIN = """#include "arm.hpp"
#include <chrono>
#include <cstdio>
using namespace NAMESPACE;
template <class F> double microseconds(F call) {
  double least = 1e300, sum = 0.0;
  for (int round = 0; round < ROUNDS; ++round) {
    Vector q{};
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < CALLS; ++k) {
      for (std::size_t j = 0; j < kJoints; ++j) q[j] = 1e-5 * k + 0.1 * double(j);
      sum += call(q)[0];
    }
    const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - start;
    if (spent.count() / CALLS < least) least = spent.count() / CALLS;
  }
  volatile double kept = sum;
  (void)kept;
  return least;
}
int main() {
  std::printf("%.6g ", microseconds([](const Vector& q) { return gravity(q); }));
  std::printf("%.6g ", microseconds([](const Vector& q) { return compensation(q, q); }));
  std::printf("%.6g ", microseconds([](const Vector& q) { return inverse_dynamics(q, q, q); }));
}
"""


def times(name: str, feedforward: Feedforward, calls: int) -> dict[str, Any]:
    """A table of microseconds per call; without g++ only those of Python."""
    python = {function: _python(feedforward, function, calls // 20) for function in NAMES}
    cpp = _cpp(feedforward, calls)
    rows = [[function, cpp.get(function), python[function]] for function in NAMES]
    show(f"{name}: time of a call [us], {feedforward.robot.dof} joints", ["function", "C++", "Python"], rows)
    return {"cpp_microseconds": cpp, "python_microseconds": python}


def _python(feedforward: Feedforward, function: str, calls: int) -> float:
    scope: dict[str, Any] = {}
    exec(compile(python_file(feedforward), "feedforward.py", "exec"), scope)
    call: Callable[..., np.ndarray] = scope[function]
    q = 0.1 * np.arange(feedforward.robot.dof) + 0.2
    least = np.inf
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for _ in range(calls):
            call(*[q] * NAMES[function])
        least = min(least, (time.perf_counter() - start) / calls)
    return 1e6 * least


def _cpp(feedforward: Feedforward, calls: int) -> dict[str, float]:
    """Microseconds of each function; empty without a compiler."""
    if shutil.which("g++") is None:
        return {}
    header = cpp_file(feedforward)
    space = header.partition("namespace ")[2].split()[0]
    text = MAIN.replace("NAMESPACE", space).replace("CALLS", str(calls)).replace("ROUNDS", str(ROUNDS))
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "arm.hpp").write_text(header)
        (folder / "main.cpp").write_text(text)
        program = str(folder / "main")
        subprocess.run(["g++", "-std=c++17", "-O2", str(folder / "main.cpp"), "-o", program], check=True)
        output = subprocess.run([program], capture_output=True, text=True, check=True).stdout
    return dict(zip(NAMES, map(float, output.split()), strict=True))


def of_arm(data: DataSet, quick: bool) -> tuple[dict[str, Any], Feedforward]:
    """Figures of an arm's held-out runs, and its feedforward."""
    train, held_out = (data.train[:2], data.held_out[:1]) if quick else (data.train, data.held_out)
    fit = identify([data.run(name) for name in train], filtering=data.filtering)
    return left(data.key, fit, [data.run(name) for name in held_out]), make_feedforward(fit)


def built_in() -> Feedforward:
    """The built-in KR270, with its spring balancer, at its nominal values."""
    model = read_model("kr270")
    n = model.robot.dof
    dynamics, gain = Dynamics.of(model, model.nominal_values), model.robot.drive_gain
    return Feedforward(dynamics, "N m", gain, None, np.full(n, 0.01), SHARE, (), ("nominal",))


def main() -> None:
    """All tables."""
    given = options(__doc__)
    calls = QUICK_CALLS if given.quick else CALLS
    figures: dict[str, Any] = {"times": {"kr270": times("kr270", built_in(), calls)}}
    if FOLDER.exists():
        figures["left"] = {}
        for data in (UR10E,) if given.quick else (UR10E, KR300):
            figures["left"][data.key], feedforward = of_arm(data, given.quick)
            figures["times"][data.key] = times(data.key, feedforward, calls)
    else:
        print(f"\nno public recordings in {FOLDER}: EXIDYN_DATA names their folder")
    save(given.json, figures)


if __name__ == "__main__":
    main()
