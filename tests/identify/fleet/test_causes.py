"""Causes compete: a change has one statement, whatever it changes; single runs and heavy tails make none."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from exidyn.identification.fleet.learned import learned
from exidyn.identification.fleet.report import KindReport, bound_words, change_words, odd_words
from exidyn.identification.fleet.runs import Frame
from exidyn.identification.fleet.scatter import LEAST_SEEN, Scatter, scatter_of
from exidyn.identification.fleet.suspects import EXCHANGE, TOOL

from ...parts.small.fleet_runs import START, kind_and_equations, season

WEEKS, BEGIN, RATE = 16, 9, 0.1
TOOL_OF = np.array([0.02, 0.0, 0.01, 0.03, 0.0, 0.02, 0.10, 0.03, 0.08, 0.8])
"""XX to M of 0.8 kg on the last joint."""


@dataclass(frozen=True, eq=False)
class Shifted:
    """A summary of an arm on which the unknowns are others by `by`, shape (m,)."""

    summary: object
    by: np.ndarray

    def normal(self, kind, values, gain):
        """As that of `Summary`."""
        normal, right = self.summary.normal(kind, values, gain)
        return normal, right + normal @ self.by

    def __getattr__(self, name):
        return getattr(self.summary, name)


def shifted(run, by):
    return replace_summary(run, Shifted(run.summary, by))


def replace_summary(run, summary):
    return run._replace(summary=summary)


@pytest.fixture(scope="module")
def report():
    kind = kind_and_equations()[0]
    joints = kind.model.robot.dof
    tool = np.append(kind.body @ TOOL_OF, np.zeros(joints))
    arms = {f"sound {k}": season(50 + k, weeks=WEEKS) for k in range(6)}
    arms["tool"] = [
        shifted(run, tool) if week >= BEGIN else run for week, run in enumerate(season(60, weeks=WEEKS))
    ]
    arms["exchanged"] = season(61, weeks=WEEKS)[:BEGIN] + moved(season(62, weeks=WEEKS), kind)[BEGIN:]
    arms["stray"] = season(63, weeks=WEEKS)
    arms["stray"][BEGIN] = arms["sound 2"][BEGIN]._replace(key="a copy")
    arms["bad run"] = season(64, weeks=WEEKS)
    arms["bad run"][BEGIN] = moved(season(64, weeks=WEEKS), kind)[BEGIN]
    frame = Frame.of(kind, [run for own in arms.values() for run in own])
    return KindReport.of("two", learned(frame, arms), RATE)


def moved(runs, kind):
    """The same on an arm whose links and gains are others."""
    random = np.random.default_rng(1)
    sizes = 0.05 * np.abs(kind.base.regrouping @ kind.model.nominal_values)
    by = np.append(sizes * random.normal(size=len(sizes)), 0.03 * random.normal(size=kind.model.robot.dof))
    return [shifted(run, by) for run in runs]


@pytest.mark.parametrize(("arm", "name"), [("tool", TOOL), ("exchanged", EXCHANGE)])
def test_one_change_with_all_its_consequences(report, arm, name):
    [found] = report.drifts[arm].changes
    assert found.suspect.name == name
    assert found.interval[0] <= START + 7.0 * BEGIN <= found.interval[1] + 1e-9
    assert found.alarmed >= START + 7.0 * (BEGIN + 1)  # two runs show it
    assert len(report.drifts[arm].alarms) == 1


def test_a_tool_is_stated_by_its_mass_and_centre(report):
    words = change_words(report.learned, report.drifts["tool"].changes[0])
    assert "on the flange" in words
    assert "gain" not in words


@pytest.mark.parametrize(("arm", "like"), [("stray", "sound 2"), ("bad run", "")])
def test_a_single_run_is_no_change_and_is_said_to_be_what_it_is(report, arm, like):
    own = report.drifts[arm]
    assert own.changes == own.alarms == ()
    [odd] = own.odd
    assert odd.run == BEGIN
    assert odd.like == like
    assert ("a run of sound 2" if like else "a bad run") in odd_words(report.learned, odd)


def test_sound_arms_have_no_changes(report):
    assert not any(report.drifts[f"sound {k}"].alarms for k in range(6))


def test_the_bound_is_printed_only_where_scatter_obeys_its_law(report):
    sound = replace(report, scatter=report.scatter._replace(seen=LEAST_SEEN, beyond=5))
    wild = replace(report, scatter=report.scatter._replace(seen=LEAST_SEEN, beyond=50))
    assert bound_words([sound], RATE) == "false alarms: at most 1 per 10 arm-years"
    assert "unknown" in bound_words([sound, wild], RATE)


@pytest.mark.parametrize(("tails", "low", "high"), [(3.0, 2.0, 4.0), (np.inf, 10.0, 50.0)])
def test_tails_scales_and_how_far_arms_differ_are_found(tails, low, high):
    random = np.random.default_rng(0)
    arms = np.exp(random.normal(size=(20, 1, 1)))  # of the second effect only
    draw = random.standard_t(tails, (20, 30, 8)) if np.isfinite(tails) else random.normal(size=(20, 30, 8))
    draw *= np.concatenate([np.full((20, 1, 4), 2.0), np.broadcast_to(arms, (20, 1, 4))], axis=2)
    found = scatter_of(list(draw**2), [np.ones((30, 8))] * 20, ["Fc"] * 4 + ["Off"] * 4)
    assert found.holds
    assert low <= found.tails <= high
    np.testing.assert_allclose(found.variance[:4], 4.0, rtol=0.4)
    assert np.all(found.alike[:4] > 3.0 * found.alike[4:])


def test_of_nothing_scatter_is_not_known():
    assert not Scatter.first(3).holds
