"""Pictures of docs/proof.md: budgets as stacked bars, and cogging over one turn of a motor."""

from typing import Any

import numpy as np

from exidyn.identification.pages.svg import Panel, Span, legend, text

STYLE = """
text { font: 11px system-ui, "Segoe UI", "DejaVu Sans", sans-serif; fill: #1c1f23 }
.tick, .note { fill: #5c646e } .middle { text-anchor: middle } .end { text-anchor: end }
.grid { stroke: #d6dae0 } .frame { fill: #f6f7f9; stroke: #d6dae0 }
path { fill: none; stroke-linejoin: round; vector-effect: non-scaling-stroke }
.map { stroke: #e69f00; stroke-width: 3.2px } .found { stroke: #0067a5; stroke-width: 1.3px }
.left { stroke: #c44e00; stroke-width: 1px }
"""
NAMED = (
    "#0067a5", "#009e73", "#56b4e9", "#7b4fa3", "#1b7f79", "#88a0d0", "#2c3e73", "#6fbf73",
    "#5b5bd6", "#3f7d20", "#b48ac8", "#00a6b8", "#a9d39e", "#9c27b0",
)  # fmt: skip
UNDECIDED = ("#c9dff0", "#cdeadf", "#e0d5ec")
REST = {"sensor noise": "#e3e6ea", "nothing that was recorded": "#b4bac2"}
KINDS = ("#e69f00", "#c44e00", "#d9a066", "#8c6d31", "#e8c07d", "#a65628", "#f0d9b5")
LEAST = 0.005
"""Largest share of a part on any joint below which it is not drawn [-]."""


LETTER = 6.2
"""Width of a letter, on average [px]."""


def budget_picture(one: dict[str, Any], unit: str) -> str:
    """The misfit of each joint as a bar of 100 %: named, undecided, what it depends on, noise.

    `unit` is that of all joints, or of each, with commas between.
    """
    found, joints = one["budget"], one["joints"]
    parts = coloured([share for share in found["shares"] if max(share["shares"]) >= LEAST])
    wide, left, high = 400.0, 32.0, 22.0
    units = unit.split(", ")
    column = max(290.0, 30.0 + LETTER * max((len(words(share)) for share, _ in parts), default=0))
    drawn = [
        text(
            left,
            14,
            "share of the misfit without findings; at the right its root mean square, and with findings",
            "note",
        )
    ]
    for joint in range(joints):
        top, start = 24 + high * joint, left
        drawn.append(text(left - 6, top + 13, f"J{joint + 1}", "end"))
        for share, colour in parts:
            width = wide * max(share["shares"][joint], 0.0)
            drawn.append(
                f'<rect x="{start:.1f}" y="{top:.1f}" width="{width:.1f}" height="17" fill="{colour}"/>'
            )
            start += width
        before, after = found["before"][joint], found["after"][joint]
        drawn.append(
            text(left + wide + 8, top + 13, f"{before:.3g} → {after:.3g} {units[joint % len(units)]}", "")
        )
    below = 24 + high * joints + 6
    for place, (share, colour) in enumerate(parts):
        x, y = left + column * (place % 2), below + 16 * (place // 2)
        drawn.append(f'<rect x="{x:.1f}" y="{y:.1f}" width="11" height="11" fill="{colour}"/>')
        drawn.append(text(x + 16, y + 10, words(share), ""))
    return whole(
        40.0 + 2.0 * column,
        below + 16 * ((len(parts) + 1) // 2) + 6,
        f"budget of {one['case']}",
        "".join(drawn),
    )


def coloured(shares: list[dict[str, Any]]) -> list[tuple[dict[str, Any], str]]:
    """Each share with its colour: cool if named, pale if undecided, else warm or grey."""
    palettes = {"named": NAMED, "undecided": UNDECIDED, "kind": KINDS}
    used = dict.fromkeys(palettes, 0)
    out = []
    for share in shares:
        if share["what"] in REST:
            out.append((share, REST[share["what"]]))
            continue
        palette = palettes[share["part"]]
        out.append((share, palette[used[share["part"]] % len(palette)]))
        used[share["part"]] += 1
    return out


def words(share: dict[str, Any]) -> str:
    """What a part is, in words."""
    what = share["what"].replace("_", " ")
    if share["part"] == "kind":
        return what if what in REST else f"no name; depends on {what}"
    return f"{what}, undecided" if share["part"] == "undecided" else what


def turn_picture(states: dict[str, dict[str, Any]]) -> str:
    """Current over one turn of the motor in each state, one panel above the other."""
    rows = [one["over_a_turn"] for one in states.values()]
    span = Span.around(*(np.array(row[name]) for row in rows for name in ("left", "map")))
    drawn, top = (
        [
            legend(
                60,
                14,
                [
                    ("map", "independent map"),
                    ("left", "left by the model without ripple"),
                    ("found", "named"),
                ],
            )
        ],
        38.0,
    )
    for title, row in zip(states, rows, strict=True):
        panel = Panel(Span(0.0, 2 * np.pi), span, 60, top, 500, 130)
        last = row is rows[-1]
        drawn += [
            text(60, top - 6, title, ""),
            panel.axes("angle of the motor [rad]" if last else "", "current [A]", last),
        ]
        drawn += [
            panel.line(np.array(row["angle"]), np.array(row[name]), style)
            for name, style in (("map", "map"), ("left", "left"), ("explained", "found"))
        ]
        top += 160
    return whole(580, top + 22, "cogging over one turn", "".join(drawn))


def whole(width: float, height: float, title: str, content: str) -> str:
    """A picture that stands alone, on white."""
    size = f'viewBox="0 0 {width:g} {height:g}" width="{width:g}" height="{height:g}"'
    ground = f'<rect width="{width:g}" height="{height:g}" fill="#ffffff"/>'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img"><title>{title}</title>'
    return f"{head}<style>{STYLE}</style>{ground}{content}</svg>\n"
