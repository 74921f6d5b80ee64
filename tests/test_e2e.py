"""Checks AUTOSAR E2E Profile 5 against the independent implementation in the package autosar-e2e."""

from __future__ import annotations

import pytest
from comanip._core import ffi, lib
from e2e import p05

LENGTHS = range(lib.E2E_HEADER_BYTES, lib.CAN_FRAME_MAX_BYTES + 1)


def protected(data: bytes, data_id: int, counter: int) -> bytes:
    frame = bytearray(data)
    lib.e2e_protect(ffi.from_buffer(frame), len(frame), data_id, counter)
    return bytes(frame)


def check(receiver, data: bytes, data_id: int) -> int:
    return lib.e2e_check(receiver, data, len(data), data_id)


@pytest.mark.parametrize("length", LENGTHS)
def test_protect_matches_autosar_e2e(rng, length):
    for _ in range(20):
        data, data_id, counter = rng.bytes(length), int(rng.integers(65536)), int(rng.integers(256))
        expected = bytearray(data)
        expected[2] = counter
        p05.e2e_p05_protect(expected, data_id, increment_counter=False)
        assert protected(data, data_id, counter) == bytes(expected)


@pytest.mark.parametrize("length", LENGTHS)
def test_check_agrees_with_autosar_e2e(rng, length):
    """The check accepts frames protected by autosar-e2e, and rejects them if any bit is flipped or the Data ID
    differs."""
    frame = bytearray(rng.bytes(length))
    p05.e2e_p05_protect(frame, 0xC120, increment_counter=False)
    assert check(ffi.new("e2e_receiver_t *"), bytes(frame), 0xC120) == lib.E2E_OK
    assert check(ffi.new("e2e_receiver_t *"), bytes(frame), 0xC121) == lib.E2E_WRONG_CRC
    for bit in range(8 * length):
        flipped = bytearray(frame)
        flipped[bit // 8] ^= 1 << bit % 8
        assert not p05.e2e_p05_check(bytes(flipped), 0xC120)
        assert check(ffi.new("e2e_receiver_t *"), bytes(flipped), 0xC120) == lib.E2E_WRONG_CRC


def expected_status(step: int) -> int:
    """Returns the expected status of a frame whose counter is `step` ahead of that of the last frame."""
    if step == 0:
        return lib.E2E_REPEATED
    if step == 1:
        return lib.E2E_OK
    return lib.E2E_SOME_LOST if step <= lib.E2E_MAX_DELTA else lib.E2E_WRONG_SEQUENCE


@pytest.mark.parametrize("last", [0, 100, 250, 255])
def test_counter(last):
    for step in range(256):
        receiver = ffi.new("e2e_receiver_t *")
        first, second = (protected(bytes(8), 1, (last + s) % 256) for s in (0, step))
        assert check(receiver, first, 1) == lib.E2E_OK  # any first counter is accepted
        assert check(receiver, second, 1) == expected_status(step), step
        after = protected(bytes(8), 1, (last + step + 1) % 256)
        assert check(receiver, after, 1) == lib.E2E_OK  # only the first frame after a jump is refused


def test_a_corrupt_frame_does_not_change_the_counter():
    receiver = ffi.new("e2e_receiver_t *")
    assert check(receiver, protected(bytes(8), 1, 5), 1) == lib.E2E_OK
    assert check(receiver, b"\xff" + protected(bytes(8), 1, 200)[1:], 1) == lib.E2E_WRONG_CRC
    assert check(receiver, protected(bytes(8), 1, 6), 1) == lib.E2E_OK
