r"""Parameter files of BAM (github.com/Rhoban/bam): friction models M1 to M6 of one servo, as JSON.

BAM's friction is at most

.. math:: b + s\, e^{-|\dot q / v_s|^\alpha} + g(\tau_m, \tau_e) + F_v |\dot q|

with motor torque :math:`\tau_m` and external torque :math:`\tau_e`. In M3 and M4, g is
:math:`c\, |\tau_e - \tau_m|`; in M5 and M6, :math:`|c_e \tau_e - c_m \tau_m|`. In balance, the load is
:math:`\tau_m = -\tau_e`, so that the coefficient of `LoadDependentFriction` is :math:`2 c` or
:math:`c_e + c_m`.
"""

from collections.abc import Mapping, Sequence
from json import JSONDecodeError, loads
from pathlib import Path
from typing import Any

from ..errors import RobotError
from .toml_fields import check_keys, read_text, string, strings

MODELS = ("m1", "m2", "m3", "m4", "m5", "m6")
LOAD = {"load_friction_base": 2.0, "load_friction_motor": 1.0, "load_friction_external": 1.0}
"""Load coefficient of BAM -> its share in the coefficient of `LoadDependentFriction`."""
NO_EFFECT = (
    "load_friction_stribeck",
    "load_friction_motor_stribeck",
    "load_friction_external_stribeck",
    "load_friction_motor_quad",
    "load_friction_external_quad",
)
"""Parameters that no effect has."""
NEEDED = ("friction_base", "friction_viscous", "armature")


def with_bam_rows(
    rows: Sequence[Mapping[str, Any]], joints: Sequence[str], folder: Path
) -> tuple[list[Mapping[str, Any]], list[str]]:
    """Replace `[[effect]]` rows that name a BAM file by the rows of its effects.

    Such a row has no other key than `joints`, which are all by default. Beside the rows is a sentence for
    each file on the parts that they do not have.
    """
    expanded: list[Mapping[str, Any]] = []
    sentences: list[str] = []
    for row in rows:
        if "bam" not in row:
            expanded.append(row)
            continue
        check_keys(row, ("bam", "joints"), "effect bam")
        path = folder / string(row["bam"], "effect bam")
        table = read_bam(read_text(path), str(path))
        chosen = strings(row["joints"], "effect bam joints") if "joints" in row else list(joints)
        expanded += bam_effect_rows(table, chosen)
        if missing := left_out_of_bam(table):
            sentences.append(f"{path}: not taken: {'; '.join(missing)}")
    return expanded, sentences


def read_bam(text: str, where: str) -> dict[str, Any]:
    """Parameters of a BAM file."""
    try:
        table = loads(text)
    except JSONDecodeError as error:
        raise RobotError(f"{where}: not JSON: {error}") from error
    if not isinstance(table, dict) or table.get("model") not in MODELS:
        raise RobotError(f"{where}: not a parameter file of BAM, whose model is {', '.join(MODELS)}")
    stribeck = ("friction_stribeck", "dtheta_stribeck", "alpha") if table["model"] not in ("m1", "m3") else ()
    for name in (*NEEDED, *stribeck):
        if not isinstance(table.get(name), int | float):
            raise RobotError(f"{where}: {name} is {table.get(name)!r}; expected a number")
    return table


def bam_effect_rows(table: Mapping[str, Any], joints: Sequence[str]) -> list[dict[str, Any]]:
    """`[[effect]]` rows of a BAM file for joints that have this servo."""
    each = len(joints)

    def row(name: str, value: float, **fields: float) -> dict[str, Any]:
        return {"name": name, "joints": list(joints), "values": [value] * each, **fields}

    rows = [
        row("rotor_inertia", table["armature"]),
        row("viscous_friction", table["friction_viscous"]),
        row("coulomb_friction", table["friction_base"]),
    ]
    if table.get("friction_stribeck") and table["model"] not in ("m1", "m3"):
        fades = {"fade": table["dtheta_stribeck"], "exponent": table["alpha"]}
        rows.append(row("stribeck_friction", table["friction_stribeck"], **fades))
    if load := sum(share * table.get(name, 0.0) for name, share in LOAD.items()):
        rows.append(row("load_dependent_friction", load))
    return rows


def left_out_of_bam(table: Mapping[str, Any]) -> list[str]:
    """The parts of a BAM file that the rows of `bam_effect_rows` do not have, in words."""
    sentences = [
        f"{name} {table[name]:.4g}, for which there is no effect" for name in NO_EFFECT if table.get(name)
    ]
    if table.get("load_friction_external", 0.0) != table.get("load_friction_motor", 0.0):
        sentences.append("the direction of load friction: it is that of a balanced joint, driven or held")
    if table.get("q_offset"):
        sentences.append(f"q_offset {table['q_offset']:.4g} rad of the test bench")
    if "kt" in table:
        sentences.append("kt and R of the motor: state gain, servo_gain and servo_limit in [drive]")
    return sentences
