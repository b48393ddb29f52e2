"""Trial: versions of the user's file, simulated with the commands of runs and compared with them.

The runs are those of the arm alone, since its file has no payload.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..diagnosis.runs.usable import HELD_OUT
from ..errors import RecordingError
from ..model import Model
from ..preparation.prepare import Filtering
from ..recordings.recording import Recording
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_drives import servo_law
from .distances import Distances, distances
from .replay import POSITION, Run, Simulator
from .switched_off import weight

Recordings = Sequence[tuple[str, Recording]]
"""Role and recording of each run."""


class Source(NamedTuple):
    """The user's file: its text, the folder of the files that it refers to, and its name in errors."""

    text: bytes
    folder: str
    where: str


@dataclass(frozen=True, eq=False)
class Trial:
    """Runs, and how a version of a file is simulated with their commands."""

    source: Source  # the file
    model: Model  # the arm that it describes, with the drive gains of the recordings
    runs: Sequence[Run]  # runs that are simulated
    commands: str  # what is commanded, "position" or "torque"
    held: bool = False  # whether commands are held from sample to sample; otherwise they are interpolated

    @cached_property
    def weight(self) -> np.ndarray:
        """Gravity of the file and its compensation, see `switched_off.weight`."""
        return weight(compile_mjcf(self.source.text.decode(), self.source.folder))

    @cached_property
    def numerical_inertia(self) -> np.ndarray:
        """Standard deviation of each joint's armature because simulations go in steps, shape (n,) [kg m^2].

        A servo's damping acts up to half a step early or late, as an inertia of kv times half a step does. So
        an armature that differs by less may be a matter of the step, here or where the log comes from.
        """
        compiled = compile_mjcf(self.source.text.decode(), self.source.folder)
        law = servo_law(compiled, self.model.robot.joints) if self.commands == POSITION else None
        step = float(compiled.opt.timestep)
        return np.zeros(self.model.robot.dof) if law is None else 0.5 * step * np.asarray(law.damping)

    def simulator(self, text: bytes, arm: Model | None = None, attach: bool = False) -> Simulator:
        """The simulation of a version of the file, with the effects of an arm attached if requested."""
        arm, folder = arm or self.model, self.source.folder
        return Simulator(text.decode(), folder, arm, self.commands, attach, self.held, self.weight)

    def distances(self, text: bytes, arm: Model | None = None, attach: bool = False) -> Distances:
        """Distances between the runs and the simulation of a version of the file."""
        with self.simulator(text, arm, attach) as simulator:
            return distances(simulator, self.model.robot, self.runs)


def require_unloaded(recordings: Recordings) -> None:
    """Require that runs can be simulated: some are fitted, and some judge."""
    if not any(role == HELD_OUT for role, _ in recordings):
        raise RecordingError(
            "no run is held out to decide which findings help: add one that is not fitted, --validate RUN"
        )
    for held_out, words in ((True, "held-out"), (False, "fitted")):
        if not _unloaded(recordings, held_out):
            raise RecordingError(
                f"every {words} run carries a payload, which the file does not have: add a {words} run "
                "without a payload"
            )


def simulated_runs(recordings: Recordings, filtering: Filtering, held_out: bool) -> tuple[Run, ...]:
    """Held-out or fitted runs without a payload, prepared for replay."""
    return tuple(Run.of(run, filtering) for run in _unloaded(recordings, held_out))


def _unloaded(recordings: Recordings, held_out: bool) -> list[Recording]:
    return [run for role, run in recordings if (role == HELD_OUT) == held_out and run.payload is None]
