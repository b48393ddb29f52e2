"""From runs to the payload: with a fit of the arm, with a run without it, with the description alone."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.document.text import text
from exidyn.identification.errors import FitError, RecordingError
from exidyn.identification.fit.estimators.consistent import pseudo_inertia
from exidyn.identification.fit.identification import identify
from exidyn.identification.pages.payload_document import payload_document, payload_table
from exidyn.identification.payload.body import MASS, Body, Interval
from exidyn.identification.payload.payload_estimate import DESCRIPTION, DIFFERENCE, FIT, PayloadEstimate
from exidyn.identification.payload.weigh import weigh
from exidyn.identification.text_table import digits

from .arms import TOOL, arm, run


def holds(result: PayloadEstimate, body: Body) -> list[bool]:
    """Whether each interval holds the truth."""
    truth = [body.mass, *body.center, *body.inertia[np.triu_indices(3)]]
    intervals = [result.mass, *result.center, *result.inertia]
    return [interval.holds(value) for interval, value in zip(intervals, truth, strict=True)]


@pytest.fixture(scope="module")
def by_fit() -> PayloadEstimate:
    nominal = arm()
    fit = identify([run(nominal, 1, links=1.08)], as_recorded=True)
    return weigh([run(nominal, 2, TOOL, links=1.08, friction=1.2)], fit=fit, as_recorded=True)


@pytest.fixture(scope="module")
def by_difference() -> PayloadEstimate:
    nominal = arm(gain_tolerance=0.1)
    empty = run(nominal, 1, gain=0.92, scatter=0.1)
    loaded = run(nominal, 2, TOOL, gain=0.92, scatter=0.1)
    return weigh([loaded], empty=[empty], as_recorded=True)


def test_a_fit_of_the_arm_gives_the_mass_to_a_percent(by_fit) -> None:
    assert by_fit.source == FIT
    assert by_fit.mass.value == pytest.approx(TOOL.mass, rel=0.01)
    assert by_fit.mass.half < 0.03 * TOOL.mass
    np.testing.assert_allclose(by_fit.body.center, TOOL.center, atol=0.005)
    assert np.mean(holds(by_fit, TOOL)) >= 0.8  # 10 intervals, of which each misses in 5 %


def test_gains_that_are_all_wrong_alike_are_in_the_interval(by_difference) -> None:
    """Errors of 8 %, all in one direction, with a tolerance of 10 %: they do not average out."""
    assert by_difference.source == DIFFERENCE
    assert by_difference.mass.holds(TOOL.mass)
    assert by_difference.mass.half > 0.05 * TOOL.mass
    assert by_difference.certain.mass.half < 0.3 * by_difference.mass.half
    np.testing.assert_allclose(by_difference.body.center, TOOL.center, atol=0.01)


def test_a_description_alone_costs_the_interval_or_trust(by_fit):
    nominal = arm()
    result = weigh([run(nominal, 2, TOOL, links=1.08)], model=nominal, as_recorded=True)
    assert result.source == DESCRIPTION
    assert result.mass.holds(TOOL.mass)
    assert result.mass.half > 3 * by_fit.mass.half
    assert "comes from what is uncertain of the arm" in " ".join(text(payload_document(result)).split())
    nominal = arm()
    bare = replace(nominal, robot=replace(nominal.robot, inertias_stated=False))
    loaded = run(nominal, 2, TOOL)
    wide, narrow = (weigh([loaded], model=model, as_recorded=True).mass.half for model in (bare, nominal))
    assert wide > 1.5 * narrow


def test_an_arm_without_payload_carries_nothing() -> None:
    nominal = arm()
    fit = identify([run(nominal, 1)], as_recorded=True)
    result = weigh([run(nominal, 3)], fit=fit, as_recorded=True)
    assert result.mass.low == 0.0
    assert result.mass.high < 0.1
    assert "mass" in result.undetermined
    assert "The mass may be zero, so the center" in " ".join(text(payload_document(result)).split())


@pytest.mark.parametrize("name", ["by_fit", "by_difference"])
def test_the_body_is_physically_consistent_and_inside_its_intervals(name: str, request) -> None:
    result = request.getfixturevalue(name)
    assert np.all(np.linalg.eigvalsh(pseudo_inertia(result.body.parameters)) > 0.0)
    assert all(holds(result, result.body))


def test_the_check_and_the_page_have_the_values(by_fit):
    first, second = by_fit.check.poses
    assert by_fit.check.passed
    assert np.max(np.abs(first.position - second.position)) > 0.3
    assert np.nanmax(np.abs(first.predicted - second.predicted)) > 10.0  # [N m] of 3 kg
    page, table = text(payload_document(by_fit, ["ur", "kuka"])), payload_table(by_fit)
    assert "set_target_payload(" in page
    assert "LOAD_DATA[1]" in page
    assert table["mass"]["low"] < table["mass"]["value"] < table["mass"]["high"]
    assert set(table["forms"]) == {"ur", "franka", "kuka", "abb", "urdf", "mjcf"}


def test_an_estimate_that_no_body_has_is_wrong_and_its_mass_is_stated(by_fit) -> None:
    """Beside the nearest body, whose mass differs, the page has that of the estimate."""
    far = replace(
        by_fit, distance=106.6, intervals=by_fit.intervals._replace(mass=Interval(4.0, 2.9, 4.0, "kg"))
    )
    page = " ".join(text(payload_document(far)).split())
    assert "WRONG as a body" in page
    assert "106.6 standard deviations" in page
    assert f"The estimate alone has a mass of {digits(by_fit.estimate[MASS], 4)} ±" in page
    assert "WRONG as a body" not in text(payload_document(by_fit))


def test_a_fit_of_weighed_gains_is_not_advised_to_weigh_them(by_fit, by_difference) -> None:
    """Gains of the fit are estimated or nominal, and only nominal gains are cured by a weighed payload."""
    certain = by_fit.certain._replace(mass=Interval(3.0, 2.9999, 3.0001, "kg"))
    estimated, nominal = (
        " ".join(text(payload_document(replace(by_fit, certain=certain, nominal_gains=choice))).split())
        for choice in (False, True)
    )
    assert "For less: a longer run with the payload" in estimated
    assert "For less: a fit with drive gains from a payload that was weighed" in nominal
    assert by_difference.nominal_gains


def test_a_known_center_leaves_the_mass() -> None:
    nominal = arm()
    empty, loaded = run(nominal, 1), run(nominal, 2, TOOL)
    result = weigh([loaded], empty=[empty], com=TOOL.center, as_recorded=True)
    assert result.mass.value == pytest.approx(TOOL.mass, rel=0.01)
    np.testing.assert_allclose(result.body.center, TOOL.center, atol=0.002)


def test_runs_that_weigh_nothing_are_refused():
    nominal = arm()
    unknown = replace(nominal, robot=replace(nominal.robot, drive_gain=np.ones(6)))
    with pytest.raises(FitError, match="no drive gains are known"):
        weigh([run(nominal, 2, TOOL)], model=unknown, as_recorded=True)
    nominal = arm()
    with pytest.raises(RecordingError, match="no run with the payload"):
        weigh([])
    loaded = run(nominal, 2, TOOL)
    fit = identify([run(nominal, 1)], as_recorded=True)
    with pytest.raises(RecordingError, match="given twice"):
        weigh([loaded], fit=fit, model=nominal)


def test_no_form_is_written_for_another_frame_or_for_a_mass_that_may_be_zero(by_fit) -> None:
    tcp = replace(by_fit, frame="panda_hand_tcp")
    page = " ".join(text(payload_document(tcp, ["franka"])).split())
    assert "franka: no form, since the payload is in frame panda_hand_tcp" in page
    assert set(payload_table(tcp)["forms"]) == {"urdf", "mjcf"}
    assert "in frame panda_hand_tcp" in tcp.text("mjcf")
    own = replace(by_fit, frame="fr3_link8")
    assert own.text("franka").endswith("// in frame fr3_link8\n")
    nothing = replace(own, intervals=own.intervals._replace(mass=Interval(0.1, 0.0, 0.3, "kg")))
    with pytest.raises(FitError, match="franka: no form, since the mass may be zero"):
        nothing.text("franka")


@pytest.mark.parametrize("empty", [False, True])
def test_an_exact_description_does_not_bias_the_mass(empty) -> None:
    """Links and gains better than their tolerances of 10 %: no correction may move the mass."""
    nominal = arm(gain_tolerance=0.1)
    without = [run(nominal, 1)] if empty else []
    result = weigh([run(nominal, 2, TOOL)], empty=without, model=nominal, as_recorded=True)
    assert abs(result.mass.value - TOOL.mass) < 0.2 * result.mass.half
