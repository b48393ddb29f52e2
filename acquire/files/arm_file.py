"""What describes an arm, for commands that take any: a robot file, a fit, or a recording."""

from exidyn.identify.fit.fit_file import read_fit
from exidyn.identify.fit.identified import identified
from exidyn.identify.model import Model
from exidyn.identify.recordings.mcap.mcap_file import read_recording
from exidyn.identify.robot_files.robot_file import builtin_names, read_model

ARM_HELP = "fit.json, robot.toml, .urdf, .xacro, recording (.mcap), or built in: "
ARM_HELP += ", ".join(builtin_names())


def read_arm(source: str) -> Model:
    """The model of a robot file, the one that a fit identified, or the one inside a recording.

    Raises:
        RobotError: A robot file that is none, or is wrong.
        NotAFile: A fit or a recording that cannot be read.
        FitError: A fit that no arm which can exist is near.
    """
    if source.endswith(".mcap"):
        return read_recording(source).model
    return identified(read_fit(source)) if source.endswith(".json") else read_model(source)
