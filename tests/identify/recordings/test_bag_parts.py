"""Bags whose joints come in different messages, on different topics, or not in every message."""

import numpy as np
import pytest

from exidyn.identification.errors import NotRecorded, RecordingError
from exidyn.identification.recordings.bags.ros2_bag import joints_of_bag
from exidyn.identification.recordings.importers import import_source

from ...parts.runs import bags
from ...parts.runs.bags import sent
from ...parts.runs.runs import model, require

pytestmark = pytest.mark.usefixtures("in_process")

BASE, WRIST = ("axis2", "axis1"), ("axis4", "axis3")
NAN = float("nan")


def require_motion(recording, joints=4, accuracy=2e-4):
    """Positions, velocities and torques are those of the joints at the times of the recording."""
    offset = (recording.host_time[0] - bags.START) * 1e-9
    for signal, what in (("position", bags.moves), ("velocity", bags.turns), ("torque", bags.pulls)):
        time, values = recording.signals[signal].time + offset, recording.signals[signal].values
        for joint in range(joints):
            expected = [what(f"axis{joint + 1}", moment) for moment in time]
            limit = 1e-5 if signal == "position" else 20 * accuracy
            np.testing.assert_allclose(values[:, joint], expected, atol=limit)


def test_joints_of_two_boards_on_one_topic_are_brought_to_common_times(tmp_path):
    messages = sent(BASE) + sent(WRIST, late=0.004)
    [found] = import_source(bags.write_ros2(tmp_path / "bag", messages), model(4))
    assert len(found.signals["position"]) == 299
    require_motion(found)
    [warning] = found.warnings
    assert warning.startswith("no message has all joints: axis1, axis2 on /joint_states (100 Hz) and axis3,")


def test_joints_on_two_topics_take_the_times_of_the_slower(tmp_path):
    messages = sent(BASE, topic="/base/joint_states") + sent(WRIST, 50.0, 0.001, "/wrist/joint_states")
    bag = bags.write_ros2(tmp_path / "bag", messages)
    [found] = import_source(bag, model(4))
    assert found.signals["torque"].rate == pytest.approx(50.0)
    assert found.host_time[0] == bags.START + 1_000_000
    require_motion(found)
    assert "axis3, axis4 on /wrist/joint_states (50 Hz), 1 ms apart" in found.warnings[0]
    assert set(joints_of_bag(bag)) == {"axis1", "axis2", "axis3", "axis4"}
    [again] = import_source(bag, model(4), topic="/base/joint_states,/wrist/joint_states")
    require(again, torque=found.signals["torque"].values)


def test_a_topic_that_lacks_joints_names_the_topic_that_has_them(tmp_path):
    messages = sent(BASE, topic="/base") + sent(WRIST, topic="/wrist")
    bag = bags.write_ros2(tmp_path / "bag", messages)
    with pytest.raises(
        RecordingError, match="/base has no joint axis3, axis4, which /wrist has. Leave --topic"
    ):
        import_source(bag, model(4), topic="/base")
    with pytest.raises(RecordingError, match="has no joint 'axis5'"):
        import_source(bag, model(5), topic="/base")


def test_a_joint_on_several_topics_of_which_none_has_all_is_asked_for(tmp_path):
    messages = sent(BASE, topic="/base") + sent(WRIST, topic="/wrist") + sent(WRIST, topic="/copy")
    bag = bags.write_ros2(tmp_path / "bag", messages)
    with pytest.raises(RecordingError, match="'axis3' is on /copy and /wrist; choose .* --topic TOPIC,TOPIC"):
        import_source(bag, model(4))
    [found] = import_source(bag, model(4), topic="/base,/copy")
    require_motion(found)


def test_the_topic_with_all_joints_and_efforts_is_taken_unasked(tmp_path):
    silent = [message._replace(effort=[]) for message in sent(BASE, topic="/joint_states")]
    messages = silent + sent(BASE, topic="/arm/joint_states") + sent(WRIST, topic="/other")
    [found] = import_source(bags.write_ros2(tmp_path / "bag", messages), model(2))
    require_motion(found, 2)
    assert found.warnings == ()


def test_boards_that_leave_the_joints_of_others_empty_are_brought_together(tmp_path):
    names, messages = (*BASE, *WRIST), []
    for late, own in ((0.0, BASE), (0.004, WRIST)):
        for message in sent(names, late=late):
            mask = np.where([name in own for name in names], 1.0, NAN)
            fields = {key: getattr(message, key) * mask for key in ("position", "velocity", "effort")}
            messages.append(message._replace(**fields))
    [found] = import_source(bags.write_ros2(tmp_path / "bag", messages), model(4))
    require_motion(found)
    assert found.warnings[0].startswith("no message has all joints: axis1, axis2 on /joint_states (100 Hz)")


def test_messages_with_and_without_a_gripper_are_one_run(tmp_path):
    messages = sent(BASE)
    messages[1::2] = sent((*BASE, "gripper"))[1::2]
    [found] = import_source(bags.write_ros2(tmp_path / "bag", messages), model(2))
    assert len(found.signals["position"]) == 300
    require_motion(found, 2)
    assert found.warnings == ()


def test_a_joint_that_a_message_names_twice_counts_once(tmp_path):
    messages = [
        message._replace(names=["axis1", "axis2", "axis1"]) for message in sent(("axis1", "axis2", "x"))
    ]
    [found] = import_source(bags.write_ros2(tmp_path / "bag", messages), model(2))
    require_motion(found, 2)
    assert "name axis1 more than once" in found.warnings[0]


def test_a_sample_that_is_missing_for_long_is_not_invented(tmp_path):
    wrist = [m for m in sent(WRIST, late=0.004) if not 1.0 < (m.received - bags.START) * 1e-9 < 1.5]
    [found] = import_source(bags.write_ros2(tmp_path / "bag", sent(BASE, 50.0) + wrist), model(4))
    time = found.signals["position"].time
    assert np.diff(time).max() == pytest.approx(0.53, abs=0.02)
    require_motion(found)
    assert any("position: a joint was silent in" in warning for warning in found.warnings)


def test_clocks_that_disagree_give_way_to_that_of_the_bag(tmp_path):
    boot = 5_000_000_000  # one board counts from when it was switched on
    wrist = [m._replace(stamp=m.stamp - bags.START + boot) for m in sent(WRIST, late=0.004)]
    [found] = import_source(bags.write_ros2(tmp_path / "bag", sent(BASE) + wrist), model(4))
    require_motion(found)
    assert found.warnings[0].startswith("the clocks of the publishers differ by 1.7")
    assert found.warnings[0].endswith(" s: times are those at which the bag received them")


@pytest.mark.parametrize(
    ("stamps", "words"),
    [
        ("some", "150 of 300 messages have no time stamp"),
        ("one", "the time stamps of the messages do not change"),
    ],
)
def test_stamps_that_are_not_set_give_way_to_the_times_of_the_bag(tmp_path, stamps, words):
    messages = sent(BASE)
    changed = messages[::2] if stamps == "some" else messages
    stamp = 0 if stamps == "some" else bags.START
    messages = [m._replace(stamp=stamp) if m in changed else m for m in messages]
    [found] = import_source(bags.write_ros2(tmp_path / "bag", messages), model(2))
    require_motion(found, 2)
    assert found.warnings == (f"{words}: times are those at which the bag received them",)


@pytest.mark.parametrize(
    ("effort", "words"),
    [
        ([], "the field effort of all 300 joint states with them is empty or NaN"),
        ([1.0], "effort has 1 value for 2 joints in 300 of 300 messages of /joint_states"),
    ],
)
def test_a_board_without_efforts_is_named_by_its_joints(tmp_path, effort, words):
    wrist = [message._replace(effort=effort) for message in sent(WRIST, late=0.004)]
    bag = bags.write_ros2(tmp_path / "bag", sent(BASE) + wrist)
    with pytest.raises(NotRecorded, match=f"the messages have no efforts of axis3, axis4: {words}"):
        import_source(bag, model(4))
    [found] = import_source(bag, model(4, passive=("axis3", "axis4")))
    assert not found.signals["torque"].values[:, 2:].any()


def test_a_board_without_velocities_is_no_matter(tmp_path):
    wrist = [message._replace(velocity=[]) for message in sent(WRIST, late=0.004)]
    [found] = import_source(bags.write_ros2(tmp_path / "bag", sent(BASE) + wrist), model(4))
    assert np.isnan(found.signals["velocity"].values[:, 2:]).all()
    assert np.isfinite(found.signals["velocity"].values[:, :2]).all()


def test_messages_that_lack_a_value_now_and_then_are_left_out(tmp_path):
    messages = [m._replace(effort=m.effort[:1]) if k % 50 == 7 else m for k, m in enumerate(sent(BASE))]
    [found] = import_source(bags.write_ros2(tmp_path / "bag", messages), model(2))
    assert len(found.signals["torque"]) == 294
    assert found.warnings[0].startswith("effort has 1 value for 2 joints in 6 of 300 messages")


def test_joints_that_were_never_there_together_are_refused(tmp_path):
    bag = bags.write_ros2(tmp_path / "bag", sent(BASE) + sent(WRIST, late=10.0))
    with pytest.raises(RecordingError, match="joints are in different messages that have no times in common"):
        import_source(bag, model(4))
