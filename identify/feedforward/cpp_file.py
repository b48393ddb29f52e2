"""C++17 header of a feedforward: one straight-line function for each torque."""

from textwrap import indent

import numpy as np

from exidyn.quoting import cpp_comment, cpp_name, cpp_text

from ..dynamics.program import Language, number
from ..dynamics.symbols import BINARY, UNARY
from .feedforward import Feedforward
from .file_parts import Function, functions, header

OWN = {
    "absolute": "std::fabs",
    "sign": "sign",
    "power": "std::pow",
    "maximum": "std::fmax",
    "minimum": "std::fmin",
    "arctan": "std::atan",
}
"""Operation -> function, where the name differs."""
LANGUAGE = Language(
    {name: OWN.get(name, f"std::{name}") for name in (*UNARY, *BINARY)},
    lambda variable, text: f"const double {variable} = {text};",
)

HEAD = """// Torque for gravity, friction and motion of a robot arm, in C++17 alone. Written by exidyn.
{comments}
#ifndef {guard}
#define {guard}

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace {namespace} {{

constexpr std::size_t kJoints = {count};
using Vector = std::array<double, kJoints>;  // one number per joint

inline constexpr std::array<const char*, kJoints> kNames{{{{{names}}}}};
// Speed below which friction is not compensated [rad/s]: at least 5 times the noise of your velocity.
inline constexpr Vector kBand{{{{{band}}}}};
// Share of the friction that is compensated, below 1 [-].
inline constexpr double kShare = {share};
{constants}
inline double sign(double x) {{ return (x > 0.0) - (x < 0.0); }}
"""
COMPENSATION = """
// Torque against friction that is zero near rest and never drives the joint [{unit}].
inline Vector friction_compensation({declared}) {{
  Vector torque = friction({arguments});
  for (std::size_t j = 0; j < kJoints; ++j) {{
    const double s = std::fmin(std::fmax(std::fabs(dq[j]) / kBand[j] - 1.0, 0.0), 1.0);
    torque[j] = torque[j] * dq[j] > 0.0 ? kShare * s * s * (3.0 - 2.0 * s) * torque[j] : 0.0;
  }}
  return torque;
}}

// Gravity plus friction compensation [{unit}]: the arm floats.
inline Vector compensation({declared}) {{
  const Vector held = gravity({still});
  Vector torque = friction_compensation({arguments});
  for (std::size_t j = 0; j < kJoints; ++j) torque[j] += held[j];
  return torque;
}}
"""
CURRENT = """
// Motor currents for joint torques [A].
inline Vector current(const Vector& torque) {
  Vector amperes{};
  for (std::size_t m = 0; m < kJoints; ++m) {
    for (std::size_t j = 0; j < kJoints; ++j) amperes[m] += kToMotors[m][j] * torque[j];
    amperes[m] /= kDriveGain[m];
  }
  return amperes;
}
"""
OFFSET = """
// What the position servos sag by, to be added to the command [rad].
inline Vector position_offset({declared_still}) {{
  Vector offset = gravity({still});
  for (std::size_t j = 0; j < kJoints; ++j) {{
    offset[j] = std::fmin(std::fmax(offset[j], -kServoLimit[j]), kServoLimit[j]) / kServoStiffness[j];
  }}
  return offset;
}}
"""


def cpp_file(feedforward: Feedforward) -> str:
    """Text of the header."""
    robot, unit = feedforward.robot, feedforward.unit
    parts = functions(feedforward.dynamics, unit, LANGUAGE)
    arguments = {part.name: part.arguments for part in parts}
    namespace = cpp_name(robot.name)
    text = HEAD.format(
        comments="\n".join(cpp_comment(line) for line in header(feedforward)),
        guard=f"{namespace.upper()}_FEEDFORWARD_HPP",
        namespace=namespace,
        count=robot.dof,
        names=", ".join(cpp_text(joint) for joint in robot.joints),
        band=_list(feedforward.band),
        share=number(feedforward.share),
        constants=_constants(feedforward),
    )
    names = {
        "arguments": ", ".join(arguments["friction"]),
        "declared": _declared(arguments["friction"]),
        "still": ", ".join(arguments["gravity"]),
        "declared_still": _declared(arguments["gravity"]),
        "unit": unit,
    }
    text += "".join(_function(part) for part in parts) + COMPENSATION.format(**names)
    text += CURRENT if feedforward.gain is not None else ""
    text += OFFSET.format(**names) if feedforward.servo is not None else ""
    return f"{text}\n}}  // namespace {namespace}\n\n#endif\n"


def _declared(arguments: tuple[str, ...]) -> str:
    return ", ".join(f"const Vector& {name}" for name in arguments)


def _list(values: np.ndarray) -> str:
    infinite = "std::numeric_limits<double>::infinity()"
    return ", ".join(number(v) if np.isfinite(v) else infinite for v in values)


def _constants(feedforward: Feedforward) -> str:
    """Lines of constants that not every arm has."""
    lines = []
    if feedforward.gain is not None:
        rows = ", ".join(f"Vector{{{{{_list(row)}}}}}" for row in feedforward.robot.to_motors)
        lines += [
            "// Joint torque per motor current [N m/A], and motors that also turn with other joints.",
            f"inline constexpr Vector kDriveGain{{{{{_list(feedforward.gain)}}}}};",
            f"inline constexpr std::array<Vector, kJoints> kToMotors{{{{{rows}}}}};",
        ]
    if feedforward.servo is not None:
        lines += [
            "// Torque per position error of the servos [N m/rad], and their largest torque [N m].",
            f"inline constexpr Vector kServoStiffness{{{{{_list(feedforward.servo.stiffness)}}}}};",
            f"inline constexpr Vector kServoLimit{{{{{_list(feedforward.servo.limit)}}}}};",
        ]
    return "\n".join([*lines, ""])


def _function(function: Function) -> str:
    """Definition of a function; an argument that no joint's torque depends on has no name."""
    used = {name for name, _ in function.lines.inputs}
    declared = ", ".join(
        f"const Vector& {name}" if name in used else f"const Vector& /*{name}*/"
        for name in function.arguments
    )
    lines = [f"const double {name}{place} = {name}[{place}];" for name, place in function.lines.inputs]
    lines += [*function.lines.assignments, f"return {{{{{', '.join(function.lines.results)}}}}};"]
    body = indent("\n".join(lines), "  ")
    return f"\n// {function.meaning}\ninline Vector {function.name}({declared}) {{\n{body}\n}}\n"
