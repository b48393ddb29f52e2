"""Plots of a study: over motion, what is open and what was expected to be, and what is left over noise."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from exidyn.identification.pages.svg import Panel, Span, legend, picture

Pairs = Sequence[tuple[dict[str, Any], dict[str, Any] | None]]
"""The choice of each round, and that of the one before."""
STYLES = ("measured", "predicted", "residual", "predicted dashed", "before thin", "after thin")
"""Of the lines of joints, in turn."""


def open_plot(pairs: Pairs) -> str:
    """Entropy of everything behind each run, as it was expected and as it came."""
    moved = np.array([choice["moved"] for choice, _ in pairs], float)
    left = np.array([choice["entropy"] for choice, _ in pairs], float)
    expected = [
        np.nan if before is None else before["entropy"] - before["offers"][0]["gained"] for _, before in pairs
    ]
    across = Span.around(np.append(moved, 0.0), margin=0.03)
    panel = Panel(across, Span.around(left, np.append(np.array(expected, float), 0.0)), 64, 22, 560, 180)
    content = (
        legend(64, 14, [("predicted", "left open"), ("residual", "expected to be")])
        + panel.axes("motion so far [s]", "open [bit]")
        + panel.line(moved, left, "predicted")
        + panel.dots(moved, left, "runs")
        + _steps(panel, moved, left, np.array(expected, float))
    )
    return picture(632, 236, "what is open over motion", content)


def _steps(panel: Panel, moved: np.ndarray, left: np.ndarray, expected: np.ndarray) -> str:
    """From what was open before each run to what it was expected to leave."""
    return "".join(
        panel.line(moved[k - 1 : k + 1], np.array([left[k - 1], expected[k]]), "residual")
        for k in range(1, len(moved))
    )


def left_plot(pairs: Pairs) -> str:
    """What is left of each joint beside all findings, over noise."""
    every = [choice["left_over_noise"] for choice, _ in pairs]
    moved = np.array([choice["moved"] for choice, _ in pairs], float)
    joints = list(every[0])
    across = Span.around(np.append(moved, 0.0), margin=0.03)
    lines = [np.array([one[joint] for one in every], float) for joint in joints]
    panel = Panel(across, Span.around(*lines, np.array([0.0, 1.0])), 64, 22, 560, 180)
    styles = [STYLES[place % len(STYLES)] for place in range(len(joints))]
    content = legend(64, 14, list(zip(styles, joints, strict=True)))
    content += panel.axes("motion so far [s]", "left over noise [-]")
    content += panel.line(np.array([across.low, across.high]), np.ones(2), "zero")
    for line, style in zip(lines, styles, strict=True):
        content += panel.line(moved, line, style) + panel.dots(moved, line, "dots")
    return picture(632, 236, "what is left over noise, of each joint, over motion", content)
