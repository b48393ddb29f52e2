"""Sentences: how each effect of the vocabulary is said, and which run would settle it.

Names in braces are parameters of the finding; what stands in square brackets is left out where one of them
is not known. "{joint}" is the joint, "{other}" the second one.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..verdict import NORMAL_95
from .finding import Finding
from .measures import SLIDING, TURNING
from .naming import joint_words as joint_words
from .naming import lower as lower
from .quantities import Said, length, said

SENTENCES: dict[str, str] = {
    "link_inertia": "Link {number} is not the body that the model has: {M:size} {M:heavier|lighter}"
    "[, first moments off by {shift} kg m]",
    "payload": "The flange carries a payload that the model does not have: {M}"
    "[, its centre of mass at {centre} mm in the flange's frame]"
    "[, but these runs hardly determine its mass; its first moments are {moments} kg m in the flange's "
    "frame]",
    "rotor_inertia": "{joint} has a rotor inertia {Ia:size} {Ia:larger|smaller} than in the model",
    "base_tilt": "The base is not level: it leans by {lean:deg}"
    "[ (gravity has {tilt_x:deg} along x and {tilt_y:deg} along y)]"
    "[ (gravity points along {gravity_x:bare}, {gravity_y:bare}, {gravity_z:bare} of the base frame)]",
    "viscous_friction": "{joint} has a viscous friction {Fv:size} {Fv:higher|lower} than in the model",
    "coulomb_friction": "{joint} has a Coulomb friction {Fc:size} {Fc:higher|lower} than in the model",
    "friction_asymmetry": "{joint} has asymmetric friction: {more:forwards|backwards} "
    "it is {more:size} above the mean of both directions{speed}",
    "stribeck_friction": "{joint} has Stribeck friction: friction rises by {Fs} towards standstill"
    "[, most of which is gone at {fade}]",
    "load_dependent_friction": "{joint} has load-dependent friction: "
    "Coulomb friction grows by {mu} {effort} per {effort} that the gear transmits",
    "nonlinear_viscous_friction": "{joint} has nonlinear viscous friction: "
    "{Fn} at {one}[, growing with speed to the power {exponent:bare}]",
    "temperature_dependent_friction": "{joint} has friction that {warm:rises|falls} with temperature: "
    "viscous friction changes by {Fvt}[ and Coulomb friction by {Fct}]",
    "position_dependent_friction": "{joint} has position-dependent friction: it varies by {wave}[, {pace}]",
    "hysteresis": "{joint} has friction with hysteresis: "
    "{Fh} of it builds up[ over about {presliding:mrad}] after each reversal",
    "spring_balancer": "{joint} has a spring balancer along the arm that the model does not have"
    "[: it gives {rms} {effort}, root mean square]",
    "joint_spring": "{joint} has a spring that the model does not have, as cables and hoses make"
    "[: {spring}][, relaxed at {ease}]"
    "[: it gives {stiffer} {effort}, root mean square, and stiffens as it stretches]",
    "drive_gain": "{joint} has a drive that gives {share:size %} {share:more|less} torque per current "
    "than its nominal gain",
    "drive_gain_saturation": "{joint} has a drive gain that falls at high torque"
    "[, from {knee:%} of the largest torque on]",
    "current_offset": "{joint} has a constant offset of {Off}",
    "torque_ripple": "{joint} has torque ripple[, {harmonic:bare} times per turn of its motor]: {wave}",
    "current_clipping": "{joint} has a recorded current that is clipped[ at {level:%} of its largest torque] "
    "while the torque goes on rising",
    "kinematic_coupling": "{joint} and {other} are kinematically coupled: "
    "the motor of either also turns with the other[, {ratio:bare} times as far]",
    "joint_elasticity": "{joint} has an elastic gear[: {stiffness}][, resonant at {resonance}]",
    "backlash": "{joint} has backlash in its gear[: {gap:mrad}]",
    "encoder_offset": "{joint} has an encoder offset: "
    "it stands {zero:size mrad} {zero:beyond|short of} its reading",
    "time_delay": "{late} {delay:size ms} {delay:later|earlier} than the positions recorded with it",
    "contact_event": "The arm was in contact with something[ at {start}][ for {duration}]",
    "hose_spring": "A spring pulls the flange towards one point, as hoses and dress packs do[: {stiffness}]",
    "supply_sag": "The supply voltage sags: all drives need more current the more power the arm draws"
    "[, by {droop}]",
    "current_crosstalk": "{joint} reads {leak:size %} of the current of joint {other_joint:bare} as well",
    "neighbour_friction": "{joint} has friction that depends on the position of joint {other_joint:bare}",
}
"""Name, in the vocabulary or outside -> how it is said, without a full stop."""

SETTLED: dict[str, str] = {
    "payload": "a run with a body of known mass on the flange",
    "link_inertia": "a run with a body of known mass on the flange",
    "drive_gain": "a run with a body of known mass on the flange",
    "encoder_offset": "a run with a body of known mass on the flange",
    "load_dependent_friction": "a run with a body of known mass on the flange",
    "drive_gain_saturation": "a faster run with a body of known mass on the flange",
    "current_clipping": "a run at half the speed, in which no current reaches its end",
    "temperature_dependent_friction": "the same run again once the arm is warm",
    "stribeck_friction": "constant low speeds (exidyn excite --kind sweeps)",
    "hysteresis": "constant low speeds (exidyn excite --kind sweeps)",
    "friction_asymmetry": "constant speeds both ways (exidyn excite --kind sweeps)",
    "nonlinear_viscous_friction": "constant speeds up to the limit (exidyn excite --kind sweeps)",
    "current_offset": "rests at poses reached from both sides (exidyn excite --kind poses)",
    "joint_elasticity": "a swept sine (exidyn excite --kind chirp)",
    "backlash": "a swept sine (exidyn excite --kind chirp)",
    "time_delay": "a swept sine (exidyn excite --kind chirp)",
    "spring_balancer": "the base at another tilt: no motion of the joints tells a spring from a weight well",
    "base_tilt": "the base levelled, or turned by a right angle",
}
"""Name in the vocabulary -> the run in which it looks least like anything else."""

LIKE: dict[str, tuple[str, ...]] = {
    "load_dependent_friction": ("torque_ripple", "nonlinear_viscous_friction", "drive_gain_saturation"),
    "friction_asymmetry": ("current_offset", "joint_spring"),
    "current_offset": ("friction_asymmetry", "joint_spring"),
    "joint_spring": ("friction_asymmetry", "spring_balancer"),
    "spring_balancer": ("link_inertia", "joint_spring"),
    "link_inertia": ("payload", "spring_balancer", "drive_gain"),
    "payload": ("link_inertia", "drive_gain"),
    "drive_gain": ("link_inertia", "encoder_offset"),
    "encoder_offset": ("link_inertia", "base_tilt"),
    "base_tilt": ("encoder_offset", "link_inertia"),
    "stribeck_friction": ("hysteresis", "nonlinear_viscous_friction", "backlash"),
    "hysteresis": ("stribeck_friction", "backlash", "joint_elasticity"),
    "nonlinear_viscous_friction": ("stribeck_friction", "drive_gain_saturation", "viscous_friction"),
    "viscous_friction": ("nonlinear_viscous_friction", "temperature_dependent_friction"),
    "coulomb_friction": ("stribeck_friction", "load_dependent_friction"),
    "temperature_dependent_friction": ("viscous_friction", "nonlinear_viscous_friction"),
    "position_dependent_friction": ("load_dependent_friction", "torque_ripple"),
    "torque_ripple": ("position_dependent_friction", "joint_elasticity"),
    "drive_gain_saturation": ("current_clipping", "nonlinear_viscous_friction"),
    "current_clipping": ("drive_gain_saturation",),
    "rotor_inertia": ("joint_elasticity", "time_delay"),
    "kinematic_coupling": ("rotor_inertia", "viscous_friction"),
    "joint_elasticity": ("backlash", "time_delay", "rotor_inertia"),
    "backlash": ("joint_elasticity", "hysteresis"),
    "time_delay": ("joint_elasticity", "viscous_friction"),
}
"""Name in the vocabulary -> what it is taken for most easily, so that people ask whether it is that."""

OPTIONAL = re.compile(r"\[([^\[\]]*)\]")


WAVES = ("Rcos", "Rsin", "Fcos", "Fsin")
"""Beginnings of names of waves along a turn."""


def sentence(finding: Finding, joints: Sequence[str], sliding: bool = False) -> str:
    """What the finding says, without a full stop.

    Args:
        finding: Of any effect; one that is not in the table is said by its name.
        joints: Names of the robot's joints.
        sliding: Whether its joints slide.
    """
    known = said(finding)
    known |= _derived(finding, known) | _places(finding, joints) | _units(known, sliding)
    pattern = SENTENCES.get(finding.effect, f"{{joint}}: {finding.effect.replace('_', ' ')}")
    whole = OPTIONAL.sub(lambda part: _filled(part[1], known), pattern)
    return _filled(whole, known) or f"{known['joint']}: {finding.effect.replace('_', ' ')}"


def _filled(pattern: str, known: Mapping[str, Any]) -> str:
    try:
        return pattern.format_map(known)
    except KeyError:
        return ""


def _places(finding: Finding, joints: Sequence[str]) -> dict[str, str]:
    words = [joint_words(joint, joints) for joint in finding.joints]
    words = words or ["The arm"]
    late = "All currents come" if not finding.joints else f"The current of {lower(words[0])} comes"
    number = str(finding.joints[0] + 1) if finding.joints else "?"
    return {"joint": words[0], "other": lower(words[-1]), "late": late, "number": number}


def _units(known: Mapping[str, Any], sliding: bool) -> dict[str, str]:
    """What depends on how the joint moves, and stands in no parameter's unit."""
    if not sliding:
        pace = (
            {"pace": f"{known['harmonic']:bare} times per turn of the joint"} if "harmonic" in known else {}
        )
        return {"effort": TURNING, "one": "1 rad/s"} | pace
    # Waves of the position in metres, as if it were an angle.
    pace = {"pace": f"every {2 * np.pi / known['harmonic'].value:.3g} m"} if "harmonic" in known else {}
    return {"effort": SLIDING, "one": "1 m/s"} | pace


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers that people ask for, out of those that were fitted."""
    found: dict[str, Any] = {"rms": f"{np.max(finding.torque, initial=0.0):.3g}"}
    waves = [name for name in finding.parameters if name.startswith(WAVES)]
    if waves:
        found["wave"] = length(finding.parameters, *waves)
    if "tilt_x" in known and "tilt_y" in known:
        found |= {} if "lean" in found else {"lean": length(known, "tilt_x", "tilt_y")}
    if {"M", "MX", "MY", "MZ"} <= set(known):
        found |= _body(known["M"], [known[f"M{axis}"] for axis in "XYZ"])
    if "Fa" in known:
        found |= {"more": _together(known, "Fa", "Fva"), "speed": _at_one(known) if "Fva" in known else ""}
    if "sag" in known:
        found["droop"] = Said(1e5 * known["sag"].value, 1e5 * known["sag"].std, "% per kW")
    if "Fvt" in known:
        found["warm"] = _together(known, "Fvt", "Fct")
    if "Kc" in known:
        return found | {"stiffer": found["rms"]}
    if "Ks" in known:
        found["spring"] = known["Ks"]
    if "Ks" in known and "Ts" in known and known["Ks"].value > 0:
        stiffness, torque = known["Ks"].value, known["Ts"]
        found["ease"] = Said(-torque.value / stiffness, torque.std / stiffness, "rad")
    return found


def _together(known: Mapping[str, Said], dry: str, viscous: str) -> Said:
    """Dry and viscous friction at 1 rad/s."""
    parts = [known[name] for name in (dry, viscous) if name in known]
    std = float(np.linalg.norm([part.std for part in parts]))
    return Said(sum(part.value for part in parts), std, known[dry].unit)


def _at_one(known: Mapping[str, Said]) -> str:
    return f" at 1 {'rad' if known['Fa'].unit == TURNING else 'm'}/s"


def _body(mass: Said, moments: Sequence[Said]) -> dict[str, str]:
    """Where a body has its mass; only its moments where the mass itself is not distinguished from zero."""
    values = np.array([moment.value for moment in moments])
    shift = "({:.3g}, {:.3g}, {:.3g})".format(*values)
    if not mass.value > NORMAL_95 * mass.std:
        return {"moments": shift, "shift": shift}
    return {"centre": "({:.0f}, {:.0f}, {:.0f})".format(*(1e3 * values / mass.value)), "shift": shift}
