"""The opening of a joined report: what was identified, what is missing, what agrees, in plain words."""

from collections.abc import Collection, Iterator

import numpy as np

from ...fit.verdict import MISSING, counted, verdict
from ..diagnosis.page_data import PageData
from ..diagnosis.sections import findings_table, verdict_list
from ..fit.report_tables import joint_table
from ..report_html import heading, listing, section
from .material import Compared, Fitted, Material


def opening(material: Material) -> str:
    """The verdict."""
    missing = _joints_missing(material.diagnosis) if material.diagnosis else None
    parts = [part for fitted in material.fits if not fitted.improved for part in _fitted(fitted, missing)]
    if (found := material.diagnosis) is not None:
        parts += [heading("What is missing"), verdict_list(found), findings_table(found)]
    parts += [part for fitted in material.fits if fitted.improved for part in _fitted(fitted, missing)]
    if material.comparisons:
        lines = [compared_line(one) for one in material.comparisons]
        parts += [heading("What simulations come to"), listing(lines, "verdict")]
    if lacking := list(_lacking(material)):
        parts += [heading("What this page does not contain"), listing(lacking)]
    return section("verdict", "Verdict", *parts)


def _joints_missing(found: PageData) -> set[str]:
    """Joints on which a diagnosis finds something: what is missing has one source on a page."""
    named = [*found.findings, *found.undecided]
    if any(not one.joints for one in named):
        return set(found.joints)
    places = {joint for one in named for joint in one.joints} | {left.joint for left in found.remainders}
    places |= {int(joint) for one in named for joint in np.flatnonzero(one.torque > 0.0)}
    return {found.joints[joint] for joint in places}


def _fitted(fitted: Fitted, missing: Collection[str] | None) -> list[str]:
    more = " with what was found" if fitted.improved else ""
    words = listing(verdict(fitted.fit, missing), "verdict")
    return [heading(f"What was identified{more}"), words, joint_table(fitted.fit, missing)]


def compared_line(one: Compared) -> str:
    """How many joints differ by more than noise, and by how much at most."""
    found, effort = one.comparison, one.comparison.effort
    title = f"{found.simulated} beside {found.recorded}"
    over = effort.rms / effort.noise
    if not np.any(np.isfinite(over)):
        return f"{title}: the noise is not known, so that {effort.quantity} is not judged."
    many, worst = int(np.count_nonzero(over > MISSING)), int(np.nanargmax(over))
    most = f"{found.joints[worst]} most, by {over[worst]:.3g} x noise"
    if not many:
        return f"{title}: no joint's {effort.quantity} differs by more than noise; {most}."
    return f"{title}: {effort.quantity} differs by more than noise on {counted(many, 'joint')}; {most}."


def _lacking(material: Material) -> Iterator[str]:
    """What was not given, and the command that makes it."""
    if not material.fits:
        yield "How large the parameters are: there is no fit. exidyn identify RUN... makes one."
    elif not any(fitted.fit.agreement or fitted.fit.validation for fitted in material.fits):
        yield "How the fit follows the runs: give the recordings beside fit.json."
    if material.diagnosis is None:
        yield "Which physics is missing: there is no diagnosis. exidyn diagnose robot.toml RUN... makes one."
    elif not material.diagnosis.traces:
        yield "When and where it is missing: traces.npz does not lie beside diagnosis.json."
    if not material.comparisons and not (material.diagnosis and material.diagnosis.simulated):
        yield (
            "Whether a simulation agrees: there is none. exidyn simulate fit.json trajectory.toml makes one, "
            "and exidyn compare sim.mcap run.mcap --json compared.json lays it beside a run."
        )
