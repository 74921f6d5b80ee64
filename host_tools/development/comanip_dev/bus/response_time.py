"""Computes worst-case response times on a CAN bus, which schedules frames by fixed priorities without preemption.

The method is that of R. I. Davis, A. Burns, R. J. Bril, J. J. Lukkien: Controller Area Network (CAN) schedulability
analysis: refuted, revisited and revised. Real-Time Systems 35 (2007), over all instances in the busy period. A frame
that answers another frame inherits jitter from that frame, so the computation is repeated until the results no longer
change (holistic analysis: K. Tindell, J. Clark, 1994).

Assumptions: a lower id has a higher priority; each node offers its frame with the lowest id first; frames of two
streams with the same id delay each other; there are no errors. All times are whole nanoseconds.

An answer is queued only after its request, the frame that it answers. The sum of the worst cases of request and answer
would count most frames twice. A tighter bound holds if all answers to a request are sent before the next request is
queued, and if no other frame has a priority between those of the answers. There are two cases:

1. The answer is queued within the busy period in which its request was queued. From the start of that busy period, the
   request, its answers and the frames queued together with the request are each sent once. The busy period contains no
   earlier answer, because an answer cannot start while frames of higher priority are waiting, and all earlier answers
   were sent before the request was queued.
2. The answer is queued later. Then, at some time between the end of the request and the queueing of the answer, no
   frame of this or a higher priority was pending. The frames queued together with the request have been sent by then,
   so the bound is a busy period without them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

UNBOUNDED_NS = 10_000_000_000  # a longer response time counts as unbounded


@dataclass(frozen=True)
class Stream:
    """A stream of frames of one kind. Each frame is queued earliest_ns to earliest_ns + jitter_ns after its event, and
    events are at least period_ns apart. Jitter also models bursts of frames that are sent on events: with a period of
    20 ms and a jitter of 19 ms, two frames are at least 1 ms apart, and there is on average one frame in 20 ms.

    batch: streams of one batch are queued at the same instants. If their periods are equal, they are always queued
        together.
    one_of: name of a group of streams, only one of which is sent at a time. All have the same period and jitter.
    answers: name of the frame that this frame answers, the request. The answer is queued answer_delay_ns after the end
        of the request, and has the request's event and period. `analyse` computes the answer's earliest_ns and
        jitter_ns.
    """

    name: str
    identifier: int
    longest_ns: int
    shortest_ns: int
    period_ns: int
    jitter_ns: int = 0
    earliest_ns: int = 0
    batch: str | None = None
    one_of: str | None = None
    answers: str | None = None
    answer_delay_ns: int = 0


@dataclass(frozen=True)
class Response:
    """The worst-case times to the end of a frame, from its queueing and from its event. None: unbounded, because the
    bus is overloaded."""

    queued_ns: int | None
    event_ns: int | None


def load(streams: Sequence[Stream]) -> float:
    """Returns the bus load if all frames have their maximum length."""
    return sum(stream.longest_ns / stream.period_ns for stream in one_of_each(streams))


def one_of_each(streams: Iterable[Stream]) -> list[Stream]:
    """Returns the longest stream of each `one_of` group, and all streams that are not in such a group."""
    chosen: dict[str, Stream] = {}
    for stream in streams:
        key = stream.one_of or stream.name
        if key not in chosen or stream.longest_ns > chosen[key].longest_ns:
            chosen[key] = stream
    return list(chosen.values())


def analyse(streams: Sequence[Stream], bit_ns: int) -> dict[str, Response]:
    """Returns the response times by name. bit_ns: bit time of the arbitration phase. Raises KeyError if a stream
    answers an unknown stream."""
    known = {stream.name: Response(0, 0) for stream in streams}
    while True:
        by_name = {stream.name: stream for stream in streams}
        streams = [_resolve(stream, by_name, known) for stream in streams]
        found = {stream.name: _response(streams, stream, known, bit_ns) for stream in streams}
        if found == known:
            return found
        known = found


def _resolve(stream: Stream, by_name: dict[str, Stream], known: dict[str, Response]) -> Stream:
    if stream.answers is None:
        return stream
    asked, response_ns = by_name[stream.answers], known[stream.answers].event_ns
    earliest_ns = asked.earliest_ns + asked.shortest_ns + stream.answer_delay_ns
    latest_ns = UNBOUNDED_NS if response_ns is None else max(earliest_ns, response_ns + stream.answer_delay_ns)
    return replace(stream, period_ns=asked.period_ns, earliest_ns=earliest_ns, jitter_ns=latest_ns - earliest_ns)


def _response(streams: Sequence[Stream], stream: Stream, known: dict[str, Response], bit_ns: int) -> Response:
    others = [o for o in streams if o is not stream and (o.one_of is None or o.one_of != stream.one_of)]
    higher = one_of_each(other for other in others if other.identifier <= stream.identifier)
    blocking_ns = max((o.longest_ns for o in streams if o.identifier > stream.identifier), default=0)
    if load([stream, *higher]) >= 1.0 or stream.jitter_ns >= UNBOUNDED_NS:
        return Response(None, None)
    independent = _independent(stream, higher, blocking_ns, bit_ns)
    answer = _answer(stream, higher, blocking_ns, known, bit_ns)
    if answer is None:
        return independent
    return Response(min(answer.queued_ns, independent.queued_ns), min(answer.event_ns, independent.event_ns))


def _instances(stream: Stream, window_ns: int) -> int:
    """Returns the maximum number of instances that can be queued in a window of this length."""
    return -(-(window_ns + stream.jitter_ns) // stream.period_ns)


def _least_window(start_ns: int, work_ns: Callable[[int], int]) -> int:
    """Returns the shortest window of at least start_ns that is exactly as long as the work queued in it."""
    window_ns = start_ns
    while (needed_ns := work_ns(window_ns)) != window_ns:
        window_ns = needed_ns
    return window_ns


def _waits(base_ns: int, higher: Sequence[Stream], bit_ns: int, at_least_ns: int = 0) -> int:
    """Returns the time until a frame starts. The frame waits for base_ns of work and for all frames of higher priority
    that are queued before or in the bit in which its arbitration starts."""
    return _least_window(
        max(base_ns, at_least_ns),
        lambda ns: base_ns + sum(_instances(other, ns + bit_ns) * other.longest_ns for other in higher),
    )


def _independent(stream: Stream, higher: Sequence[Stream], blocking_ns: int, bit_ns: int) -> Response:
    """Returns the worst case by the analysis of Davis et al., over all instances in the busy period."""
    level = [stream, *higher]
    busy_ns = _least_window(
        stream.longest_ns, lambda ns: blocking_ns + sum(_instances(other, ns) * other.longest_ns for other in level)
    )
    queued, event = [], []
    ends_ns = 0
    for instance in range(_instances(stream, busy_ns)):
        waits_ns = _waits(blocking_ns + instance * stream.longest_ns, higher, bit_ns, ends_ns)
        ends_ns = waits_ns + stream.longest_ns
        since_first_ns = ends_ns - instance * stream.period_ns
        event.append(stream.earliest_ns + stream.jitter_ns + since_first_ns)
        queued.append(since_first_ns + (stream.jitter_ns if instance else 0))
    return Response(max(queued), max(event))


def _answer(
    stream: Stream, higher: Sequence[Stream], blocking_ns: int, known: dict[str, Response], bit_ns: int
) -> Response | None:
    """Returns the tighter bound described at the top of this file, or None if the conditions for this bound do not
    hold."""
    asked = next((other for other in higher if other.name == stream.answers), None)
    if asked is None:
        return None
    answers = [other for other in higher if other.answers == stream.answers]
    rest = [other for other in higher if other not in answers]
    first_identifier = min(answer.identifier for answer in [stream, *answers])
    again_ns = asked.period_ns + asked.earliest_ns
    ends = [known[answer.name].event_ns for answer in [stream, *answers]]
    if any(other.identifier >= first_identifier for other in rest) or any(
        end is None or end > again_ns for end in ends
    ):
        return None

    base_ns = max(blocking_ns, *(answer.longest_ns for answer in [stream, *answers]))
    base_ns += sum(answer.longest_ns for answer in answers)
    batch = [other for other in rest if other is asked or (asked.batch is not None and other.batch == asked.batch)]
    together = [other for other in batch if other.period_ns == asked.period_ns and other.one_of is None]
    others = [other for other in rest if other not in together]
    waits_ns = _waits(base_ns + sum(other.longest_ns for other in together), others, bit_ns)
    ends_ns = waits_ns + stream.longest_ns
    way_ns = asked.shortest_ns + stream.answer_delay_ns
    connected = Response(ends_ns - way_ns, asked.earliest_ns + asked.jitter_ns + ends_ns)

    follows = [o for o in together if o.identifier > asked.identifier and o.shortest_ns >= stream.answer_delay_ns]
    if follows:  # frames sent after the request extend the busy period until the answer is queued
        return connected
    ends_ns = _waits(base_ns, [other for other in rest if other not in batch], bit_ns) + stream.longest_ns
    apart = Response(ends_ns, known[asked.name].event_ns + stream.answer_delay_ns + ends_ns)
    return Response(max(connected.queued_ns, apart.queued_ns), max(connected.event_ns, apart.event_ns))
