"""Time of the check of recordings as a share of identify's, on a simulated recording of seven joints."""

import time
from collections.abc import Callable

import numpy as np

from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.recording import Recording, Signal

from .arms import SEVEN, fourier, model_of, torques
from .engine import check_before_fit

SECONDS, BRIEF, RATE = 60.0, 15.0, 500.0
"""Duration of the recording [s], the same with --quick, and its sampling rate [Hz]."""


def check_share(quick: bool) -> dict[str, float]:
    """CPU seconds of identify and of its check, and their ratio."""
    motion = fourier(SEVEN.middle, np.arange(0.0, BRIEF if quick else SECONDS, 1 / RATE), 4, 0.3)
    signals = {"position": motion.position, "torque": torques(SEVEN, motion)}
    model = model_of(SEVEN)
    run = Recording("seven", model, {name: Signal(motion.time, values) for name, values in signals.items()})
    whole, check = _seconds(lambda: identify([run])), _seconds(lambda: check_before_fit([run], model))
    return {"identify_cpu_s": whole, "check_cpu_s": check, "check_share_of_identify": check / whole}


def _seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin
