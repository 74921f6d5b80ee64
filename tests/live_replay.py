"""The log of two processes, fed into the C core again: what each tick had consumed stands in its TickTrace."""

from __future__ import annotations

from collections import deque

from bus_log import DBC
from comanip._core import ffi, lib
from test_bus_log import LoggedFrame, consumed, trace_counters

INBOX_FRAMES = 16  # controller.h
TRACE_ID = DBC.get_message_by_name("TickTrace").frame_id
ADDRESSED = {message.frame_id for message in DBC.messages if "Firmware" in message.receivers}


def replay(frames: list[LoggedFrame], has_stamps: bool) -> tuple[dict[int, list[bytes]], int]:
    """What the firmware sends, by id, from its boot on, and how many frames it was fed with. `has_stamps`: the log's times
    are the kernel's, by the firmware's clock; else each frame came at the tick that had last found nothing left."""
    controller, inbox, outbox = (ffi.new(f"controller{part}_t *") for part in ("", "_inbox", "_outbox"))
    lib.controller_init(controller, ffi.addressof(lib.arm_hoap3_right))
    queue = deque(frame for frame in frames if frame.frame_id in ADDRESSED)
    trace = DBC.get_message_by_name("TickTrace")
    counters, sent, fed, empty_us = None, {}, 0, 0
    for tick in frames:
        if tick.frame_id != TRACE_ID:
            continue
        wanted = trace_counters(tick)
        counters = dict.fromkeys(wanted) if counters is None else counters
        now_us = int(trace.decode(tick.data)["now_us"])
        taken = consumed(queue, counters, wanted)
        assert len(taken) <= INBOX_FRAMES
        inbox.count = len(taken)
        for i, frame in enumerate(taken):
            slot = inbox.frame[i]
            slot.timestamp_us = (frame.t_us if has_stamps else empty_us) % 2**32
            slot.id, slot.length = frame.frame_id, len(frame.data)
            ffi.memmove(slot.data, frame.data, len(frame.data))
        empty_us = now_us if len(taken) < INBOX_FRAMES else empty_us
        lib.controller_step(controller, now_us, inbox, outbox)
        for i in range(outbox.count):
            frame = outbox.frame[i]
            sent.setdefault(frame.id, []).append(bytes(frame.data[0 : frame.length]))
        fed += len(taken)
    return sent, fed


def require_equal(frames: list[LoggedFrame], has_stamps: bool) -> None:
    """The replay gives back each byte of each frame that the firmware had sent."""
    by_firmware = {message.frame_id for message in DBC.messages if message.senders == ["Firmware"]}
    recorded: dict[int, list[bytes]] = {}
    for frame in frames:
        if frame.frame_id in by_firmware:
            recorded.setdefault(frame.frame_id, []).append(frame.data)
    sent, fed = replay(frames, has_stamps)
    ticks = len(recorded[TRACE_ID])
    assert fed > 4 * ticks, "each tick consumes the states of four drives"
    assert sent.keys() == recorded.keys()
    for frame_id, expected in recorded.items():
        name = DBC.get_message_by_frame_id(frame_id).name
        differing = [i for i, (a, b) in enumerate(zip(sent[frame_id], expected, strict=False)) if a != b]
        assert not differing, f"{name}: {len(differing)} of {len(expected)} differ, first number {differing[0]}"
        # the log may end within a tick
        assert 0 <= len(sent[frame_id]) - len(expected) <= 1, name
