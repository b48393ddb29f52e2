"""Which runs of the real arms make the belief, which are diagnosed, and which are held out."""

from dataclasses import dataclass
from typing import NamedTuple

from exidyn.identify.model import Model
from exidyn.identify.recording import Recording
from real_data import KR300, LOADED, PANDA, UR10E, DataSet, thirds

PART = " part "


class Asked(NamedTuple):
    """Runs of one question.

    Attributes:
        fitted: Names of those that are diagnosed.
        held_out: Names of those that are only predicted.
    """

    fitted: tuple[str, ...]
    held_out: tuple[str, ...]


class Loaded(NamedTuple):
    """A body whose mass is known to the scorer alone.

    Attributes:
        mass: [kg].
        asked: Runs that carry it.
        known: Run with another body, of known mass [kg], that gave the belief its drive gains.
        drawn: Whether the links are believed to be as drawn, since every run carries the body.
    """

    mass: float
    asked: Asked
    known: tuple[str, float] | None
    drawn: bool = False


@dataclass(frozen=True, eq=False)
class Arm:
    """One arm.

    Attributes:
        data: Its recordings.
        believed: Runs of which the belief is made.
        asked: Questions, on other runs; the first one is asked with each term taken out of the belief.
        drawn: Relative standard deviation of the drawn inertias before the belief's runs [-].
        tolerance: The same after them, as the sample cases have it [-]: of their two levels the narrow one
            where the belief rests on minutes of motion, the wide one where it rests on seconds.
        terms: Effects of single joints that the belief holds.
        bodies: Payloads that are hidden.
    """

    data: DataSet
    believed: tuple[str, ...]
    asked: tuple[Asked, ...]
    drawn: float = 1.0
    tolerance: float = 0.1
    terms: tuple[str, ...] = ("coulomb_friction", "viscous_friction", "rotor_inertia")
    bodies: tuple[Loaded, ...] = ()

    @property
    def known(self) -> tuple[str, float] | None:
        """Run with a body of known mass [kg] that gives the belief its drive gains, if there is any."""
        return self.bodies[0].known if self.bodies else None

    def runs(self, names: tuple[str, ...], model: Model) -> list[Recording]:
        """Recordings, whole or in thirds, of the arm as it is believed to be."""
        return [recording(self.data, name, model) for name in names]


def recording(data: DataSet, name: str, model: Model) -> Recording:
    """One run, or "run part 2", the second third of it."""
    stem, _, part = name.partition(PART)
    run = data.run(stem)
    return thirds(run)[int(part) - 1] if part else run


def parts(name: str, *which: int) -> tuple[str, ...]:
    """Names of thirds of a run."""
    return tuple(f"{name}{PART}{part}" for part in which)


(HEAVY, HEAVY_MASS), (LIGHT, LIGHT_MASS) = LOADED
AUTHORS_MASS = 151.0
"""Of what the KR300 carries in all runs, by the identification of those who recorded it [kg]; its drawings
have neither that nor the counterbalance of its second axis."""

ARMS = {
    "ur10e": Arm(
        UR10E,
        ("id_ur-20_02_05-20sec_12harm", "id_ur-20_02_10-30sec_12harm", "id_ur-20_02_19_15harm50sec"),
        (
            Asked(("id_ur-20_02_06-20sec_10harm",), ("id_ur-20_02_05-20sec_8harm",)),
            Asked(
                ("id_ur-20_02_10-20sec_7harm", "id_ur-20_02_12-40sec_12harm"),
                ("id_ur-20_02_12-50sec_12harm",),
            ),
            Asked(("id_ur-20_01_31-unload", "id_ur-19_12_23_free"), ("id_ur-20_02_06-20sec_5harm",)),
        ),
        tolerance=0.02,
        bodies=(
            Loaded(HEAVY_MASS, Asked((HEAVY,), ("id_ur-20_01_31-load",)), (LIGHT, LIGHT_MASS)),
            Loaded(LIGHT_MASS, Asked(parts(LIGHT, 1, 2), parts(LIGHT, 3)), (HEAVY, HEAVY_MASS)),
        ),
    ),
    "kr300": Arm(
        KR300,
        ("2020-10-21_A", "2020-10-21_C"),
        (
            Asked(("2020-10-16_A", "2020-10-19_B"), ("2020-10-19_C",)),
            Asked(("2020-10-21_B", "2020-10-19_C"), ("2020-10-16_A",)),
        ),
        bodies=(
            Loaded(AUTHORS_MASS, Asked(("2020-10-16_A", "2020-10-19_B"), ("2020-10-19_C",)), None, True),
        ),
    ),
    "panda": Arm(
        PANDA,
        parts("traj1", 1),
        (Asked(parts("traj1", 2), parts("traj1", 3)), Asked(parts("traj1", 3), parts("traj1", 2))),
        drawn=3.0,  # links of 1 kg each are nobody's drawing
        terms=("coulomb_friction", "viscous_friction"),  # its sensors are behind the rotors
    ),
}
"""Key -> arm. The KR300's and the UR10e's runs are of several days; the Panda has one run."""
