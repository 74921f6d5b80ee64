"""The record of all parameters: as an independent encoder makes it, and taken as a whole or not at all."""

from __future__ import annotations

import math
import struct
import zlib

import numpy as np
import pytest
from comanip._core import ffi, lib

COUNT = lib.PARAMETER_COUNT
ROWS = [lib.parameter_table[i] for i in range(COUNT)]
NAMES = [ffi.string(row.name).decode() for row in ROWS]
DEFAULTS = [row.default_value for row in ROWS]
BYTES = 12 + 4 * COUNT
OF_38_PARAMETERS = bytes.fromhex(
    "434d4e509f85f3510000304100000c4200000c4200000c4200000c4200000c4200000c4200000c420ad7233c0ad7233c0ad7233c0ad7233c0000c8420000c842"
    "0000c8420000c8420ad7233c0000803f0000803fdb0fc9bf00000000000000000000000000000000000000000000000000000000000000000000000000000000"
    "00000000000000000000803f0000803e0000c8410ad7a33b000020400000803f63812e4f"
)


def record(values, names=NAMES, magic: bytes = b"CMNP") -> bytes:
    layout = zlib.crc32(b"".join(name.encode() + b"\0" for name in names))
    body = magic + struct.pack(f"<I{len(values)}f", layout, *values)
    return body + struct.pack("<I", zlib.crc32(body))


def decode(data: bytes) -> list[float] | None:
    """None: refused, and then nothing was changed."""
    parameters = ffi.new("parameters_t *", {"value": [float(i) for i in range(COUNT)]})
    if lib.parameter_store_decode(data, len(data), parameters):
        return list(parameters.value)
    assert list(parameters.value) == list(range(COUNT))
    return None


def encode(values) -> bytes:
    data = ffi.new("uint8_t[]", BYTES)
    lib.parameter_store_encode(ffi.new("parameters_t *", {"value": values}), data)
    return bytes(data)


def random_values(rng) -> list[float]:
    draws = [float(np.float32(rng.uniform(row.minimum, row.maximum))) for row in ROWS]
    draws = [min(max(value, row.minimum), row.maximum) for value, row in zip(draws, ROWS, strict=True)]
    return [float(round(value)) if row.integer else value for value, row in zip(draws, ROWS, strict=True)]


def test_record_is_what_an_independent_encoder_writes(rng):
    for _ in range(50):
        values = random_values(rng)
        assert encode(values) == record(values)
        assert decode(record(values)) == values


def test_both_ends_of_each_range_come_back():
    for ends in ([row.minimum for row in ROWS], [row.maximum for row in ROWS], DEFAULTS):
        assert decode(encode(ends)) == ends


def test_every_flipped_bit_is_found(rng):
    good = record(random_values(rng))
    for bit in range(8 * len(good)):
        bad = bytearray(good)
        bad[bit // 8] ^= 1 << bit % 8
        assert decode(bytes(bad)) is None, bit


def test_other_lengths_are_refused(rng):
    good = record(random_values(rng))
    for length in range(len(good)):
        assert decode(good[:length]) is None, length
    assert decode(good + b"\0") is None
    assert decode(good + good) is None


def test_other_layouts_are_refused():
    """With a right CRC: more, none, renamed and rearranged parameters, and what is no record of ours."""
    assert decode(record(DEFAULTS)) == DEFAULTS
    assert decode(record([*DEFAULTS, 1.0], [*NAMES, "another"])) is None
    assert decode(record([], [])) is None
    assert decode(record(DEFAULTS[:-1], NAMES[1:])) is None
    assert decode(record(DEFAULTS[:-1], NAMES)) is None
    assert decode(record(DEFAULTS, ["renamed", *NAMES[1:]])) is None
    assert decode(record(DEFAULTS, [NAMES[1], NAMES[0], *NAMES[2:]])) is None
    assert decode(record(DEFAULTS, magic=b"cmnp")) is None
    assert decode(bytes(BYTES)) is None


def test_the_record_of_an_older_firmware_is_read_and_what_it_lacks_gets_its_default(rng):
    """Of the firmware with 38 parameters, and of any other count: parameters are only ever added at the end."""
    assert NAMES[37] == "trace", "a stored record of that firmware would not be read any more"
    values = random_values(rng)
    for count in (38, *range(1, COUNT)):
        assert decode(record(values[:count], NAMES[:count])) == [*values[:count], *DEFAULTS[count:]]


def test_the_bytes_of_a_record_that_the_firmware_with_38_parameters_wrote_are_read():
    """gain_w_per_s = 11 and speed_fraction = 0.25 among its defaults."""
    found = decode(OF_38_PARAMETERS)
    assert found == [*struct.unpack_from("<38f", OF_38_PARAMETERS, 8), *DEFAULTS[38:]]
    assert (found[lib.PARAMETER_GAIN_PER_S], found[lib.PARAMETER_SPEED_FRACTION]) == (11, 0.25)


@pytest.mark.parametrize("parameter", range(COUNT), ids=NAMES.__getitem__)
def test_a_value_out_of_range_refuses_the_whole_record(parameter):
    row = ROWS[parameter]
    below, above = (
        float(np.nextafter(np.float32(end), np.float32(way))) for end, way in ((row.minimum, -1e9), (row.maximum, 1e9))
    )
    for value in (below, above, math.nan, math.inf, -math.inf, *([0.5] if row.integer else [])):
        values = list(DEFAULTS)
        values[parameter] = value
        assert decode(record(values)) is None, value
