"""Driver canopen_402 and drives that lack one object: it is done without, or refused in one line."""

from itertools import product

import numpy as np
import pytest

from exidyn.drivers.errors import NotReady

from ...parts.controllers.can_peers import drives, follow, standing

CURRENT = 0.1 * np.arange(1, 7)
"""What the peer's motors draw [A], rated at 4 A and 2 N m."""


def run(driver):
    """Warnings of a driver that is opened and armed, and follows a motion."""
    info = driver.open()
    driver.arm_drives()
    samples = follow(driver, standing(driver), 40)
    assert not samples[-1].fault
    assert len(samples) == 40
    return info, [sample for sample in samples if not sample.stale.any()]


def warnings_of_joint2(info):
    return [text for text in info.warnings if "joint2" in text and "history" not in text]


INFORMATIVE = ["0x1003:0", "0x1005:0", "0x1006:0", "0x1008:0", "0x603F:0", "0x6502:0"]
NOT_ASKED_FOR = ["0x1018:4", "0x1402:1", "0x1801:1", "0x6065:0", "0x6066:0", "0x6076:0", "0x6077:0"]
"""Neither asked for nor needed by a run."""


@pytest.mark.parametrize(
    ("option", "place"),
    [
        *product(("--without", "--withhold"), INFORMATIVE),
        *product(["--without"], [*NOT_ASKED_FOR, "0x607D:1"]),
        ("--withhold", "0x1018:1"),
    ],
)
def test_what_is_informative_or_not_asked_for_may_be_missing_or_show_nothing(option, place):
    with drives(option, f"2:{place}") as (_, driver):
        info, samples = run(driver)
        assert not warnings_of_joint2(info)
        assert info.dead_man
        assert samples


@pytest.mark.parametrize(
    ("missing", "words"),
    [
        (
            "0x60C2:1",
            "no 0x60C2:1 (interpolation time): with its maker's tool, set its time between targets to 10 ms",
        ),
        ("0x1017:0", "no 0x1017:0 (heartbeat to send): only its measurements show that it is there"),
        ("0x605A:0", "no 0x605A:0 (how to stop quickly)"),
        ("0x605E:0", "no 0x605E:0 (reaction to a fault)"),
    ],
)
def test_a_run_begins_with_a_warning_without(missing, words):
    with drives("--without", f"2:{missing}") as (_, driver):
        info, samples = run(driver)
        (warning,) = warnings_of_joint2(info)
        assert words in warning
        assert samples


def test_a_foreign_rpdo_that_cannot_be_switched_off_is_a_warning():
    with drives("--withhold", "2:0x1402:1") as (_, driver):
        info, _ = run(driver)
        assert "frames of others with that identifier command it" in warnings_of_joint2(info)[0]


@pytest.mark.parametrize("missing", ["0x1016:1", "0x6007:0"])
def test_a_drive_without_dead_man_is_refused_until_that_is_set(missing):
    with drives("--without", f"2:{missing}") as (_, driver):
        with pytest.raises(NotReady) as caught:
            driver.open()
        assert f"joint2 (node 2) has no {missing}" in str(caught.value)
        assert "nothing makes it stop by itself when this computer dies" in str(caught.value)
        assert "require_dead_man = false" in str(caught.value)
        assert "\n" not in str(caught.value)
    with drives("--without", f"2:{missing}", require_dead_man=False) as (_, driver):
        info, _ = run(driver)
        assert not info.dead_man
        assert "nothing makes it stop by itself" in warnings_of_joint2(info)[0]


@pytest.mark.parametrize(
    ("missing", "setting", "words"),
    [
        ("2:0x6075:0", {}, ["0x6075:0", "rated_current [A]", "current_scale"]),
        ("2:0x6078:0", {"effort": "current"}, ["0x6078:0", "current_object", 'effort = "torque"']),
        ("2:0x6077:0", {"effort": "torque"}, ["0x6077:0", 'effort = "current"']),
        ("2:0x6076:0", {"effort": "torque"}, ["0x6076:0", "rated_torque [N m"]),
        ("2:0x6065:0", {"following_error": 0.2}, ["0x6065:0", "following_error = 0"]),
        ("2:0x607D:2", {"write_limits": True}, ["0x607D:2", "write_limits = false"]),
        ("2:0x6078:0 2:0x6077:0", {}, ["has neither 0x6078:0", "nor 0x6077:0", "current_object"]),
        ("2:0x6078:0 5:0x6077:0", {}, ["has no 0x6078:0", ", and joint5 (node 5) has no 0x6077:0"]),
    ],
)
def test_what_was_asked_for_and_is_missing_is_refused_with_what_to_set(missing, setting, words):
    with drives(*(f"--without={place}" for place in missing.split()), **setting) as (_, driver):
        with pytest.raises(NotReady) as caught:
            driver.open()
        assert str(caught.value).startswith("joint2 (node 2) ")
        assert all(word in str(caught.value) for word in words), caught.value
        assert "\n" not in str(caught.value)


def test_a_window_without_its_time_out_is_a_remark():
    with drives("--without", "2:0x6066:0", following_error=0.2) as (_, driver):
        info, _ = run(driver)
        assert "no 0x6066:0" in warnings_of_joint2(info)[0]


def test_torque_replaces_current():
    with drives("--without", "2:0x6078:0") as (_, driver):
        info, samples = run(driver)
        assert info.signals == ("position", "torque")
        assert "0x6077:0" in warnings_of_joint2(info)[0]
        np.testing.assert_allclose(samples[-1].torque, CURRENT / 4.0 * 2.0 * 101.0, rtol=0.02)
        assert np.isnan(samples[-1].current).all()


def test_rated_values_can_be_set():
    with drives("--without", "2:0x6075:0", rated_current=[4.0, 8.0, 0.0, 0.0, 0.0, 5.0]) as (_, driver):
        info, samples = run(driver)
        factor = np.array([1.0, 2.0, 1.0, 1.0, 1.0, 1.25])
        np.testing.assert_allclose(samples[-1].current, CURRENT * factor, atol=0.004)
        assert "in thousandths of 8 A (rated_current)" in info.settings["joint2 (node 2)"]
        assert "in thousandths of 4 A (0x6075)" in info.settings["joint3 (node 3)"]
        assert any("joint6 (node 6) has 4 A in 0x6075:0" in text for text in info.warnings)
        assert not any("joint1" in text and "0x6075" in text for text in info.warnings)
    with drives("--without", "2:0x6076:0", effort="torque", rated_torque=4.0) as (_, driver):
        _, samples = run(driver)
        np.testing.assert_allclose(samples[-1].torque, CURRENT / 4.0 * 4.0 * 101.0, rtol=0.02)


def test_a_scale_needs_no_rated_current():
    with drives("--object", "2:0x6075:0=0", current_scale=0.001) as (_, driver):
        _, samples = run(driver)
        np.testing.assert_allclose(samples[-1].current, CURRENT / 4.0, atol=0.0006)


def test_another_object_can_be_the_current():
    with drives(current_object=["0x6078:0 int16"] * 5 + ["0x6077 int16"]) as (_, driver):
        info, samples = run(driver)
        np.testing.assert_allclose(samples[-1].current, CURRENT, atol=0.0021)
        assert "0x6077:0 (current), in thousandths of 4 A" in info.settings["joint6 (node 6)"]


def test_a_type_that_is_not_the_objects_is_refused():
    with drives(current_object="0x6078:0 int32") as (_, driver):
        with pytest.raises(NotReady, match="answers 2 bytes for 0x6078:0 .*, its type here has 4"):
            driver.open()
