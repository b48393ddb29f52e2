"""Effects, probabilities, residuals and tables in the words of docs/proof.md."""

from collections.abc import Sequence
from typing import Any

Answer = dict[str, Any]


def title(named: dict[str, Any]) -> str:
    """Effect and joints."""
    joints = "" if named["joints"] == "-" else f" {named['joints']}"
    return named["effect"].replace("_", " ") + joints


def verdict(known: dict[str, Any]) -> str:
    """Named with its probability, or missed."""
    if not known["named"]:
        return "**missed**"
    size = ", **size off**" if known["right"] is False else ""
    return f"named, {percent(known['probability'])}{size}"


def percent(probability: float) -> str:
    """A probability, never rounded to certainty."""
    return "above 99.9 %" if probability > 0.999 else f"{100 * probability:.3g} %"


def gains(one: Answer) -> list[str]:
    """Residual before and after, joint by joint."""
    found = one["improvement"]
    return (
        [f"{a:.3g} → {b:.3g}" for a, b in zip(found["before"], found["after"], strict=True)] if found else []
    )


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
