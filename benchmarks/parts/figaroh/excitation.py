"""FIGAROH's own optimal trajectory, for comparison.

It runs in a process of its own (`trajectory.py`), which a budget ends; its clock starts when its
`solve` does. More than FIGAROH itself would hand over counts for it: the best of all its iterates that keep
to the limits, even those of an attempt that it calls failed or that the budget cuts short.
"""

import multiprocessing
import warnings

from ..excite.arm import Arm
from ..excite.peers import Best, PeerResult
from .peer import why_absent as why_no_figaroh
from .trajectory import FigarohRun, FigarohSettings, work

GRACE = 20.0
"""How many times its budget, and one minute, the process may live before it is taken for hung: it counts CPU
seconds, on a machine that may be busy."""


def why_absent() -> str:
    """Sentence with the reason why FIGAROH's trajectory cannot be compared with; empty where it can."""
    if absent := why_no_figaroh():
        return absent
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # ndcurves registers converters that are there already
            import cyipopt  # noqa: F401
            import ndcurves  # noqa: F401
    except ImportError as missing:
        return f"FIGAROH's trajectory is left out ({missing}); pip install 'exidyn[bench]' brings it."
    return ""


def figaroh(arm: Arm, budget_seconds: float, seed: int, settings: FigarohSettings) -> PeerResult:
    """FIGAROH's optimal trajectory within a budget of CPU time from the call of its `solve` [s]."""
    spawn = multiprocessing.get_context("spawn")
    ours, theirs = spawn.Pipe(duplex=False)
    process = spawn.Process(target=work, args=(theirs, arm, budget_seconds, seed, settings))
    process.start()
    theirs.close()
    try:
        if not ours.poll(GRACE * budget_seconds + 60.0):
            raise TimeoutError(f"{settings.name} did not end long after its budget of {budget_seconds:g} s")
        run = ours.recv()
    except EOFError as error:
        raise RuntimeError(f"{settings.name} ended without a word") from error
    finally:
        ours.close()
        process.kill()
        process.join()
    if isinstance(run, str):
        raise RuntimeError(f"{settings.name} failed: {run}")
    return _result(arm, settings, run)


def _result(arm: Arm, settings: FigarohSettings, run: FigarohRun) -> PeerResult:
    best = Best(arm)
    for seconds, states in run.iterates:
        best.offer(seconds, states)
    parts = [
        f"{run.attempts} attempts, {run.accepted} accepted by itself, {len(run.iterates)} iterates",
        *(f"{run.complaints.count(line)} x '{line}'" for line in dict.fromkeys(run.complaints)),
    ]
    return best.result(settings.name, run.seconds, parts)
