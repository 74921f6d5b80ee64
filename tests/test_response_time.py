"""Worst-case response times agree with the published example, and with a simple simulation of the bus."""

from __future__ import annotations

import dataclasses
import random

import pytest
from comanip_dev.bus.response_time import Stream, analyse, load
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from priority_bus import PriorityBus

MS = 1_000_000
BIT = 1


def stream(name: str, identifier: int, length: int, period: int, **more: object) -> Stream:
    return Stream(name, identifier, length, more.pop("shortest", length), period, **more)


# ---- the published example


def test_the_example_in_which_the_earlier_analysis_was_wrong():
    """In the counterexample of Davis et al. 2007, three frames of 125 bits are sent at 125 kbit/s. The longest response
    time, 3.5 ms, is that of the second frame of stream C. The analysis of 1994 considered only C's first frame, which
    takes 3 ms. The simulated bus reproduces both times."""
    streams = [stream("A", 1, MS, 2_500_000), stream("B", 2, MS, 3_500_000), stream("C", 3, MS, 3_500_000)]
    found = analyse(streams, bit_ns=8_000)
    assert {name: response.queued_ns / MS for name, response in found.items()} == {"A": 2.0, "B": 3.0, "C": 3.5}
    played = PriorityBus(streams).play(list(releases(streams, [0, 0, 0], 7 * MS, lambda _: 0)))
    assert [(frame.end - frame.queued) / MS for frame in played if frame.stream.name == "C"] == [3.0, 3.5]


# ---- against the model


@st.composite
def stream_sets(draw, jitter: bool):
    """Draws two to five streams that together use less than the whole bus. Times are in units of a bit."""
    count = draw(st.integers(2, 5))
    streams = []
    for i in range(count):
        period = 10 * draw(st.integers(4, 12))
        length = 10 * draw(st.integers(1, 3))
        streams.append(stream(f"S{i}", i, length, period, jitter_ns=draw(st.integers(0, period)) if jitter else 0))
    kept = []
    for candidate in streams:
        if load([*kept, candidate]) < 0.95:
            kept.append(candidate)
    return kept


def releases(streams, phases, until: int, jitter):
    for item, phase in zip(streams, phases, strict=True):
        for event in range(phase, until, item.period_ns):
            yield event, event + item.earliest_ns + jitter(item), item


@settings(max_examples=300, deadline=None, derandomize=True)
@given(stream_sets(jitter=False))
def test_the_lowest_priority_reaches_its_bound_exactly(streams):
    """No frame of lower priority can block the stream of lowest priority, so its worst case occurs when all streams
    queue a frame at once."""
    lowest = streams[-1]
    played = PriorityBus(streams).play(list(releases(streams, [0] * len(streams), 3000, lambda _: 0)))
    longest = max(frame.end - frame.queued for frame in played if frame.stream is lowest)
    assert analyse(streams, BIT)[lowest.name].queued_ns == longest


@settings(max_examples=150, deadline=None, derandomize=True)
@given(stream_sets(jitter=True), st.randoms(use_true_random=False))
def test_no_response_is_longer_than_computed(streams, chance: random.Random):
    found = analyse(streams, BIT)
    for _ in range(10):
        phases = [chance.randrange(item.period_ns) for item in streams]
        extremes = chance.random() < 0.5
        queue = releases(
            streams,
            phases,
            2000,
            lambda s: chance.choice([0, s.jitter_ns]) if extremes else chance.randint(0, s.jitter_ns),
        )
        for frame in PriorityBus(streams).play(list(queue)):
            response = found[frame.stream.name]
            assert frame.end - frame.event <= response.event_ns
            assert frame.end - frame.queued <= response.queued_ns


@st.composite
def answered_sets(draw):
    """Draws a batch of one to three frames, one of which is a request; the answers to the request; and other streams
    with their own phases."""
    computing = draw(st.integers(0, 20))
    delay = draw(st.integers(0, 25))
    batch, answers, others = draw(st.integers(1, 3)), draw(st.integers(1, 4)), draw(st.integers(0, 3))
    asking = draw(st.integers(0, batch - 1))
    between = draw(st.booleans())  # whether one of the other streams has a priority between those of the answers
    lengths = draw(st.lists(st.integers(5, 40), min_size=batch + answers, max_size=batch + answers))
    tick = int(sum(lengths) / draw(st.floats(0.3, 0.95))) + computing
    streams = []
    for i in range(batch):
        longest = lengths[i]
        more = {"jitter_ns": computing, "batch": "tick", "shortest": longest - draw(st.integers(0, 5))}
        multiple = 1 if i == asking else draw(st.integers(1, 2))
        streams.append(stream(f"B{i}", 10 + i, longest, multiple * tick, **more))
    for i in range(answers):
        longest = lengths[batch + i]
        more = {"answers": f"B{asking}", "answer_delay_ns": delay, "shortest": longest - draw(st.integers(0, 4))}
        streams.append(stream(f"A{i}", 50 + 2 * i, longest, tick, **more))
    for i in range(others):
        identifier = 51 if between and i == 0 else draw(st.sampled_from([5 + i, 30 + i, 90 + i]))
        streams.append(stream(f"O{i}", identifier, draw(st.integers(10, 40)), 10 * draw(st.integers(30, 400))))
    assume(load(streams) < 0.97)
    return tick, computing, streams


def answered_releases(tick, computing, streams, chance: random.Random):
    """Yields the frames of the batch, which are all queued at the same instant of a tick. A stream with a period of two
    ticks comes either in the even or in the odd ticks, chosen at random."""
    odd = {item.name: chance.randrange(2) for item in streams}
    for number, event in enumerate(range(0, 30 * tick, tick)):
        at = event + chance.choice([0, computing, chance.randint(0, computing)])
        for item in streams:
            if item.batch and (item.period_ns == tick or number % 2 == odd[item.name]):
                yield event, at, item
    for item in streams:
        if item.batch is None and item.answers is None:
            for event in range(chance.randrange(item.period_ns), 30 * tick, item.period_ns):
                yield event, event, item


@settings(max_examples=300, deadline=None, derandomize=True)
@given(answered_sets(), st.randoms(use_true_random=False))
def test_no_answer_takes_longer_than_computed(answered, chance: random.Random):
    tick, computing, streams = answered
    found = analyse(streams, BIT)
    for _ in range(5):
        bus = PriorityBus(streams, lambda s: chance.choice([s.longest_ns, s.longest_ns, s.shortest_ns]))
        for frame in bus.play(list(answered_releases(tick, computing, streams, chance))):
            response = found[frame.stream.name]
            if response.event_ns is not None:
                assert frame.end - frame.event <= response.event_ns, (frame, response)
                assert frame.end - frame.queued <= response.queued_ns, (frame, response)


def test_answers_are_not_charged_twice():
    """For one command with its two answers and a long blocking frame, the response times equal those computed by
    hand."""
    streams = [
        stream("command", 1, 100, 1000, batch="tick"),
        stream("trace", 2, 80, 1000, batch="tick"),
        stream("answer", 5, 40, 1000, answers="command", answer_delay_ns=10),
        stream("other answer", 6, 40, 1000, answers="command", answer_delay_ns=10),
        stream("low", 9, 120, 5000),
    ]
    found = analyse(streams, BIT)
    assert found["other answer"].event_ns == 120 + 100 + 80 + 40 + 40
    assert found["other answer"].queued_ns == 120 + 80 + 40 + 40 - 10, (
        "queued 10 after the command, while the trace is sent"
    )
    without_trace = analyse([item for item in streams if item.name != "trace"], BIT)
    assert without_trace["other answer"].event_ns == (120 + 100) + 10 + (120 + 40 + 40), (
        "the long frame is sent in between as well"
    )


def test_one_of_several_is_charged_once():
    alike = {"one_of": "request", "jitter_ns": 950}
    streams = [stream("short", 1, 50, 1000, **alike), stream("long", 2, 70, 1000, **alike), stream("low", 3, 40, 1000)]
    assert load(streams) == pytest.approx(0.07 + 0.04)
    assert analyse(streams, BIT)["low"].queued_ns == 70 + 70 + 40, "due to their jitter, two come in a row"
    assert analyse(streams, BIT)["long"].queued_ns == 40 + 70 + 70 - 50


def test_streams_with_one_identifier_delay_each_other():
    streams = [stream("A", 1, 10, 1000), stream("B", 1, 20, 1000), stream("low", 2, 5, 1000)]
    found = analyse(streams, BIT)
    assert found["A"].queued_ns == found["B"].queued_ns == 5 + 20 + 10


# ---- unbounded streams


def test_an_overloaded_bus_has_no_bound_for_the_lowest():
    streams = [stream(f"S{i}", i, 30, 100) for i in range(4)]
    found = analyse(streams, BIT)
    assert load(streams) == pytest.approx(1.2)
    assert [found[f"S{i}"].queued_ns is None for i in range(4)] == [False, False, False, True]


def test_answers_to_an_unbounded_request_have_no_bound():
    streams = [stream("A", 1, 60, 100), stream("B", 2, 60, 100), stream("C", 3, 10, 1000, answers="B")]
    found = analyse(streams, BIT)
    assert found["B"].event_ns is None and found["C"].event_ns is None


def test_an_answer_to_nothing_is_refused():
    with pytest.raises(KeyError, match="nobody"):
        analyse([stream("A", 1, 10, 100, answers="nobody")], BIT)


def test_names_change_nothing():
    streams = [stream("A", 1, 20, 100), stream("B", 2, 20, 100), stream("C", 3, 20, 70)]
    renamed = [dataclasses.replace(item, name=item.name * 2) for item in streams]
    assert [*analyse(streams, BIT).values()] == [*analyse(renamed, BIT).values()]
