"""An effect of somebody else's: asked for without a second entry, and found where it is installed."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from exidyn.identification import diagnosis
from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Robot
from exidyn.identification.diagnosis.candidates import candidates, kinds
from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.effects import EFFECTS, Effect, JointEffect, Parameter, load_installed, shape
from exidyn.identification.errors import EffectError
from exidyn.identification.robot_files.effect_rows import read_effects

from ...parts.installed_package import lay_out
from ...parts.small import two_joints
from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import record

pytestmark = pytest.mark.slow

TOY = "quadratic_viscous_friction"


@dataclass(frozen=True)
class QuadraticViscousFriction(JointEffect):
    """Torque f |v| v."""

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [Parameter(f"Fq{joint + 1}", "N m s^2/rad^2", 0.0) for joint in self.columns(robot)]

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        return self.on_joints(robot, np.abs(motion.velocity) * motion.velocity)


@dataclass(frozen=True)
class Shaped(QuadraticViscousFriction):
    """With a number that may be refined."""

    width: float = shape(0.5, "rad/s", 0.1, 2.0)


@dataclass(frozen=True, kw_only=True)
class Needy(QuadraticViscousFriction):
    """Needs a number to be asked for."""

    width: float = shape(None, "rad/s", 0.1, 2.0)


def test_an_effect_in_the_table_is_asked_for_on_each_joint(monkeypatch):
    before = {one.key for one in candidates(nominal_model())}
    for name, kind in {TOY: QuadraticViscousFriction, "shaped": Shaped, "needy": Needy}.items():
        monkeypatch.setitem(EFFECTS, name, kind)
    found = {one.key: one for one in candidates(nominal_model())}
    assert set(found) - before == {(name, (joint,), "") for name in (TOY, "shaped") for joint in (0, 1)}
    one = found["shaped", (1,), ""]
    assert one.shape == {"width": 0.5}
    assert one.bounds == Shaped.shapes()
    assert one.reshaped({"width": 0.7}).shape == {"width": 0.7}
    assert one.lower == (0.0,)


def test_an_effect_in_the_table_is_named_and_not_another_with_a_shape_of_the_same_columns(monkeypatch):
    monkeypatch.setitem(EFFECTS, TOY, QuadraticViscousFriction)
    # Three runs: in two the noise may fit an exponent beside 2 well enough to leave it open.
    runs = record([QuadraticViscousFriction(("elbow",))], {"Fq2": 1.5}, ("identify",) * 3 + ("validate",))
    found = diagnose(nominal_model(), runs, "toy")
    [finding] = found.findings
    assert (finding.effect, finding.joints) == (TOY, (1,))
    assert finding.probability > 0.9
    number = finding.parameters["Fq2"]
    assert abs(number.value - 1.5) < 3 * number.std < 0.3
    assert number.unit == "N m s^2/rad^2"
    assert TOY in found.tried


def test_nothing_but_candidates_and_words_knows_an_effect_by_its_name():
    folder, names = (
        Path(diagnosis.__file__).parent,
        set(kinds()) - {"payload"},
    )  # which is a run's role as well
    for file in folder.rglob("*.py"):
        if file.relative_to(folder).parts[0] not in ("candidates", "words"):
            assert not names & set(re.findall(r'"(\w+)"', file.read_text())), file


# Installed packages.

MODULE = '''
from dataclasses import dataclass
import numpy as np
from exidyn.identification.effects import JointEffect, Parameter

@dataclass(frozen=True)
class Churning(JointEffect):
    """Torque f |v| v."""
    def parameters(self, robot):
        return [Parameter(f"Fq{joint + 1}", "N m s^2/rad^2", 0.0) for joint in self.columns(robot)]
    def regressor(self, robot, motion):
        return self.on_joints(robot, np.abs(motion.velocity) * motion.velocity)

SOMETHING_ELSE = 3
'''


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Installs a package with one entry point."""

    def done(entry, text=MODULE, module="grease_physics"):
        lay_out(tmp_path, "exidyn.effects", entry, text, module)
        monkeypatch.syspath_prepend(tmp_path)

    known = dict(EFFECTS)
    yield done
    EFFECTS.clear()
    EFFECTS.update(known)


def test_an_effect_of_an_installed_package_is_in_robot_files_and_in_the_diagnosis(install):
    install("churning = grease_physics:Churning")
    assert "churning" in {one.effect for one in candidates(nominal_model())}
    effects, _ = read_effects([{"name": "churning", "joints": ["elbow"]}], two_joints.arm())
    assert type(effects[0]).__name__ == "Churning"
    assert type(effects[0]) is EFFECTS["churning"]
    kind = EFFECTS["churning"]
    load_installed()
    assert EFFECTS["churning"] is kind
    assert issubclass(kind, Effect)


@pytest.mark.parametrize(
    ("entry", "text", "message"),
    [
        ("churning = grease_physics:Churning", "import nothing_of_that_name", "No module named"),
        (
            "churning = grease_physics:Churning",
            "raise OSError('no licence\\nfor today')",
            "OSError: no licence",
        ),
        ("churning = grease_physics:Misspelt", MODULE, "Misspelt"),
        ("churning = grease_physics:SOMETHING_ELSE", MODULE, "is not a subclass of"),
        ("payload = grease_physics:Churning", MODULE, "the name is taken"),
    ],
)
def test_an_effect_that_cannot_be_used_is_one_line_that_names_its_package(install, entry, text, message):
    module = f"grease_physics_{abs(hash((entry, text)))}"  # a module is imported once
    install(entry.replace("grease_physics", module), text, module)
    with pytest.raises(EffectError) as error:
        [*candidates(nominal_model())]
    line = str(error.value)
    assert message in line
    assert "package grease-physics" in line
    assert entry.split(" = ")[0] in line
    assert "\n" not in line
