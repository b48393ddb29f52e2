"""Trial: versions of the user's file, simulated with the commands of runs and compared with them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ..model import Model
from .distances import Distances, distances
from .replay import Run, Simulator


class Source(NamedTuple):
    """The user's file: its text, the folder of the files that it refers to, and its name in errors."""

    text: bytes
    folder: str
    where: str


@dataclass(frozen=True, eq=False)
class Trial:
    """Runs, and how a version of a file is simulated with their commands.

    Attributes:
        source: The file.
        model: The arm that it describes, with the drive gains of the recordings.
        runs: Runs that are simulated.
        commands: What is commanded, "position" or "torque".
        held: Whether commands are held from sample to sample; otherwise they are interpolated.
    """

    source: Source
    model: Model
    runs: Sequence[Run]
    commands: str
    held: bool = False

    def simulator(self, text: bytes, arm: Model | None = None, attach: bool = False) -> Simulator:
        """The simulation of a version of the file, with the effects of an arm attached if requested."""
        return Simulator(text.decode(), self.source.folder, arm or self.model, self.commands, attach, self.held)

    def distances(self, text: bytes, arm: Model | None = None, attach: bool = False) -> Distances:
        """Distances between the runs and the simulation of a version of the file."""
        with self.simulator(text, arm, attach) as simulator:
            return distances(simulator, self.model.robot, self.runs)
