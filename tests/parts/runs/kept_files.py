"""Valid files of the rounds of a study."""

import json
from functools import cache
from pathlib import Path

from exidyn.acquire.study.rounds import CHOICE, ROBOT
from exidyn.identification.robot_files.robot_file import model_text

from ..small import two_joints
from ..small.small_choice import choice
from .parser_files import Files


@cache
def study() -> Files:
    """Two rounds, the second of which ended it, and the arm that it is about."""
    folder = Path("round-01") / "diagnosis" / CHOICE, Path("round-02") / "diagnosis" / CHOICE
    tables = choice("run", 10.0), choice("undecidable", 20.0)
    for table in tables:
        table["shapes"] = [["joint_elasticity", [1], "", {"resonance": 5.4, "damping_ratio": 0.01}]]
        table["findings"] = [["joint_spring", [2]]]
    files = {str(path): json.dumps(table).encode() for path, table in zip(folder, tables, strict=True)}
    return files | {ROBOT: model_text(two_joints.model()).encode()}
