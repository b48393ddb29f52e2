"""What describes an arm, for commands that take either: a robot file as believed, or a fit as identified."""

from exidyn.identify.fit_file import read_fit
from exidyn.identify.identified import identified
from exidyn.identify.model import Model
from exidyn.identify.robot_file import builtin_names, read_model

ARM_HELP = "fit.json, robot.toml or .urdf, or built in: " + ", ".join(builtin_names())


def read_arm(source: str) -> Model:
    """The model of a robot file, or the one that a fit identified.

    Raises:
        RobotError: A robot file that is none, or is wrong.
        NotAFile: A fit that cannot be read.
        FitError: A fit that no arm which can exist is near.
    """
    return identified(read_fit(source)) if source.endswith(".json") else read_model(source)
