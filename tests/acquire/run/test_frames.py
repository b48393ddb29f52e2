import numpy as np

from exidyn.acquire.run.frames import EVENT, SAMPLE, Event, Unframed, event_frame, read_cycle, sample_frame
from exidyn.drivers import Command, Sample


def sample():
    parts = [np.arange(6.0) + 10 * k for k in range(5)]
    return Sample(10**18 + 1, 7, *parts, lateness=0.25, skipped=3)


def command():
    return Command(np.arange(6.0) - 1.0, np.arange(6.0) - 2.0)


def test_a_cycle_comes_back_as_it_was():
    frame = sample_frame(sample(), command(), 2)
    (kind, body), *rest = Unframed().add(frame)
    cycle = read_cycle(body)
    assert kind == SAMPLE
    assert not rest
    assert (cycle.host_time, cycle.controller_time, cycle.lateness) == (10**18 + 1, 7, 0.25)
    assert (cycle.skipped, cycle.stage) == (3, 2)
    assert np.array_equal(cycle.array("temperature"), sample().temperature)
    assert np.array_equal(cycle.array("command_velocity"), command().velocity)


def test_no_command_is_no_number():
    ((_, body),) = Unframed().add(sample_frame(sample(), None, 0))
    assert np.isnan(read_cycle(body).array("command_position")).all()


def test_frames_come_whole_out_of_any_pieces():
    frames = [
        sample_frame(sample(), command(), 1),
        event_frame(Event(1, 2, "stop", "why", {"value": 3.0})),
    ] * 20
    data, found = b"".join(frames), []
    cutting, unframed, start = np.random.default_rng(0), Unframed(), 0
    while start < len(data):
        stop = start + int(cutting.integers(1, 700))
        found += unframed.add(data[start:stop])
        start = stop
    assert [kind for kind, _ in found] == [SAMPLE, EVENT] * 20


def test_a_frame_of_seven_joints_goes_through_a_pipe_at_once():
    parts = [np.zeros(7)] * 5
    frame = sample_frame(Sample(0, 0, *parts), Command(np.zeros(7), np.zeros(7)), 0)
    assert len(frame) <= 4096
