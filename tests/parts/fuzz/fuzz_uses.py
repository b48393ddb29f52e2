"""What is done with files that were read: a fit exported, results reported, packages made samples."""

from pathlib import Path

from exidyn.acquire.files.given_runs import read_arm
from exidyn.acquire.files.result_files import read_result
from exidyn.drivers.errors import LinkLost
from exidyn.drivers.samples import ControllerSamples
from exidyn.drivers.ur_rtde.rtde import DATA, OUTPUTS, Recipe, Unpacked
from exidyn.drivers.ur_rtde.session import FIELDS, MEASURED, STATE, obstacle, sample_of, slowed, state_of
from exidyn.drivers.values import checked
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.fit.fit_file import read_fit

from ..small.small_fit import summary

JOINTS, CYCLE = 6, 0.002


def export(path: Path) -> None:
    """As `exidyn export` does, to every format."""
    portable = Portable.of(read_arm(str(path)), "")
    for format_ in FORMATS.values():
        format_.leaves_out(portable)
        format_.text(portable)


def report(path: Path) -> None:
    """Read a result; of a fit the text page too."""
    read_result(path)
    if path.name == "fit.json":
        summary(read_fit(path))


def hear(path: Path) -> None:
    """As the driver ur_rtde and the loop do with what comes from the controller."""
    recipe, samples, arrival = None, ControllerSamples(JOINTS, len(STATE), CYCLE), 0
    try:
        for kind, body in Unpacked().add(path.read_bytes()):
            if kind == OUTPUTS:
                recipe = Recipe([*MEASURED, *FIELDS], body)
            if kind != DATA or recipe is None or not recipe.accepted:
                continue
            record, arrival = recipe.read(body), arrival + round(1e9 * CYCLE)
            words = obstacle(record), slowed(record)
            known = {"state": state_of(record), "events": words, "fault": words[0], "sent": False}
            checked(sample_of(samples, record, arrival, **known))
    except ValueError as error:  # which the driver tells as this
        raise LinkLost(f"driver ur_rtde: {error}") from error
