"""Models a bus with fixed priorities and without preemption as discrete events in integer time. It is the reference for
the response-time analysis, from which it imports only the type Stream. Frames are queued at given times. An answer is
queued with a fixed delay after the end of the frame that it answers."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass, field

from comanip_dev.bus.response_time import Stream


@dataclass(frozen=True)
class Played:
    stream: Stream
    event: int
    queued: int
    start: int
    end: int


@dataclass
class PriorityBus:
    """The bus model. `lengths(stream)` returns the duration of each frame."""

    streams: Sequence[Stream]
    lengths: object = lambda stream: stream.longest_ns  # noqa: E731
    played: list[Played] = field(default_factory=list)

    def play(self, releases: Sequence[tuple[int, int, Stream]]) -> list[Played]:
        """Simulates the bus for `releases`, tuples (event, queueing time, stream). When a frame ends, the queued frame
        with the lowest id starts. If ids are equal, the frame that was queued first starts."""
        coming = [(queued, number, event, stream) for number, (event, queued, stream) in enumerate(releases)]
        heapq.heapify(coming)
        number, now = len(coming), 0
        waiting: list[tuple[int, int, int, int, Stream]] = []
        while coming or waiting:
            if not waiting:
                now = max(now, coming[0][0])
            while coming and coming[0][0] <= now:
                queued, order, event, stream = heapq.heappop(coming)
                heapq.heappush(waiting, (stream.identifier, queued, order, event, stream))
            _, queued, _, event, stream = heapq.heappop(waiting)
            end = now + self.lengths(stream)
            self.played.append(Played(stream, event, queued, now, end))
            for answer in self.streams:
                if answer.answers == stream.name:
                    number += 1
                    heapq.heappush(coming, (end + answer.answer_delay_ns, number, event, answer))
            now = end
        return self.played
