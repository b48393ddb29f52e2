"""Plots of a study over its motion: expected and actual entropy, and residuals over the noise floor."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from exidyn.identification.pages.svg import Panel, Span, legend, picture

Pairs = Sequence[tuple[dict[str, Any], dict[str, Any] | None]]
"""The choice of each round and the choice of the round before it."""
STYLES = ("measured", "predicted", "residual", "predicted dashed", "before thin", "after thin")
"""Line styles of the joints, used in turn."""


def open_plot(pairs: Pairs) -> str:
    """Plot the total entropy after each run, as expected and as realized."""
    moved = np.array([choice["moved"] for choice, _ in pairs], float)
    entropy = np.array([choice["entropy"] for choice, _ in pairs], float)
    expected = [
        np.nan if before is None else before["entropy"] - before["offers"][0]["gained"] for _, before in pairs
    ]
    across = Span.around(np.append(moved, 0.0), margin=0.03)
    panel = Panel(across, Span.around(entropy, np.append(np.array(expected, float), 0.0)), 64, 22, 560, 180)
    content = (
        legend(64, 14, [("predicted", "actual"), ("residual", "expected")])
        + panel.axes("motion so far [s]", "entropy [bit]")
        + panel.line(moved, entropy, "predicted")
        + panel.dots(moved, entropy, "runs")
        + _expected_lines(panel, moved, entropy, np.array(expected, float))
    )
    return picture(632, 236, "open questions over motion", content)


def _expected_lines(panel: Panel, moved: np.ndarray, entropy: np.ndarray, expected: np.ndarray) -> str:
    """A line per run, from the entropy before it to the entropy expected after it."""
    return "".join(
        panel.line(moved[k - 1 : k + 1], np.array([entropy[k - 1], expected[k]]), "residual")
        for k in range(1, len(moved))
    )


def residual_plot(pairs: Pairs) -> str:
    """Plot the residual of each joint with findings, over its noise floor."""
    ratios = [choice["left_over_noise"] for choice, _ in pairs]
    moved = np.array([choice["moved"] for choice, _ in pairs], float)
    joints = list(ratios[0])
    across = Span.around(np.append(moved, 0.0), margin=0.03)
    lines = [np.array([ratio[joint] for ratio in ratios], float) for joint in joints]
    panel = Panel(across, Span.around(*lines, np.array([0.0, 1.0])), 64, 22, 560, 180)
    styles = [STYLES[place % len(STYLES)] for place in range(len(joints))]
    content = legend(64, 14, list(zip(styles, joints, strict=True)))
    content += panel.axes("motion so far [s]", "residual / noise floor [-]")
    content += panel.line(np.array([across.low, across.high]), np.ones(2), "zero")
    for line, style in zip(lines, styles, strict=True):
        content += panel.line(moved, line, style) + panel.dots(moved, line, "dots")
    return picture(632, 236, "residual over noise floor of each joint, over motion", content)
