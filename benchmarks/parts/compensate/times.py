"""Time of one call of the written functions, in C++ and in Python, the least of several rounds."""

import shutil
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from common import show

from exidyn.identification.feedforward.cpp_file import cpp_file
from exidyn.identification.feedforward.feedforward import Feedforward
from exidyn.identification.feedforward.python_file import python_file

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
