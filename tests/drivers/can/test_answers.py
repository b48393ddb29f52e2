"""Answers: a frame counts for the question that it answers, and for no other."""

import pytest

from exidyn.drivers.can.answers import Answers


class Joints:
    """Two joints; a cycle is given as the answers within it and those that come after it."""

    def __init__(self, may_skip):
        self.events = []
        self.answers = Answers(("one", "two"), self.events.append, may_skip)

    def cycle(self, within, after=()):
        asked = self.answers.ask()
        for joint, data in within:
            self.answers.take(joint, data)
        self.answers.end()
        fresh = list(self.answers.fresh)
        for joint, data in after:
            self.answers.take(joint, data)
        return asked, fresh


BOTH = [(0, b"a"), (1, b"b")]


@pytest.mark.parametrize("may_skip", [True, False])
def test_joints_that_answer_in_time_are_fresh_in_every_cycle(may_skip):
    joints = Joints(may_skip)
    assert [joints.cycle(BOTH) for _ in range(5)] == [([True, True], [True, True])] * 5
    assert joints.events == []


@pytest.mark.parametrize("may_skip", [True, False])
def test_an_answer_that_comes_before_the_next_question_is_late_and_the_next_one_is_not(may_skip):
    joints = Joints(may_skip)
    assert joints.cycle([(0, b"a")], after=[(1, b"b")])[1] == [True, False]
    assert joints.cycle(BOTH)[1] == [True, True]
    assert len(joints.events) == 1
    assert "two: an answer came after its cycle" in joints.events[0]


def test_answers_that_all_come_a_cycle_late_are_never_fresh_where_a_joint_can_be_left_out():
    joints, before = Joints(True), []
    for number in range(20):
        asked, fresh = joints.cycle([(0, b"a"), *before])
        before = [(1, bytes([number]))] if asked[1] else []
        assert fresh == [True, False]


def test_a_queue_that_comes_at_once_is_late_but_for_its_last_answer():
    joints = Joints(False)
    for _ in range(4):
        joints.cycle([(0, b"a")])
    queue = [(1, bytes([k])) for k in range(5)]  # four that are late, and that of this cycle
    assert joints.cycle([(0, b"a"), *queue[:4]])[1] == [True, False]
    assert joints.cycle([(0, b"a"), queue[4], (1, b"b")])[1] == [True, True]


@pytest.mark.parametrize("may_skip", [True, False])
def test_after_an_answer_that_was_lost_a_joint_is_fresh_again_two_cycles_later(may_skip):
    joints = Joints(may_skip)
    joints.cycle([(0, b"a")])
    asked, fresh = joints.cycle([(0, b"a")] if may_skip else BOTH)
    assert asked == [True, not may_skip]
    assert fresh == [True, False]
    assert joints.cycle(BOTH) == ([True, True], [True, True])


def test_two_different_answers_in_cycle_after_cycle_are_two_nodes_and_neither_is_used():
    joints = Joints(False)
    seen = [joints.cycle(BOTH, after=[(1, b"c")])[1] for _ in range(6)]
    assert seen == [[True, True]] * 3 + [[True, False]] * 3  # the second one comes after the sample
    assert len(joints.events) == 1
    assert "Do two nodes have the same number?" in joints.events[0]


def test_a_second_answer_within_the_cycle_is_not_used_from_the_first_on():
    joints = Joints(False)
    assert joints.cycle([(0, b"a"), (1, b"b"), (1, b"c")])[1] == [True, False]


@pytest.mark.parametrize("may_skip", [True, False])
def test_one_slow_answer_is_no_second_node(may_skip):
    joints = Joints(may_skip)
    joints.cycle(BOTH)
    for _ in range(3):
        joints.cycle([(0, b"a")])
    joints.cycle([*BOTH, (1, b"slow")])
    joints.cycle(BOTH)
    assert joints.cycle(BOTH)[1] == [True, True]
    assert not any("two different answers" in event for event in joints.events)


def test_answers_to_a_question_out_of_turn_are_neither_late_nor_a_second_node():
    joints = Joints(False)
    joints.cycle(BOTH)
    joints.answers.add_question()
    assert joints.cycle([(0, b"a2"), (1, b"b2"), *BOTH])[1] == [True, True]
    assert joints.events == []


def test_a_frame_that_the_bus_delivers_twice_is_no_second_node():
    joints = Joints(False)
    assert joints.cycle(BOTH, after=[(1, b"b")])[1] == [True, True]
    assert joints.cycle(BOTH)[1] == [True, True]
    assert joints.events == []
