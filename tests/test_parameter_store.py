"""The record of all parameters matches an independent encoder, and is read either completely or not at all."""

from __future__ import annotations

import ctypes
import math
import re
import shutil
import struct
import subprocess
import zlib
from collections.abc import Mapping, Sequence

import numpy as np
import pytest
from comanip._core import ffi, lib
from comanip_dev import codegen
from simulation import REPOSITORY

COUNT = lib.PARAMETER_COUNT
ROWS = [lib.parameter_table[i] for i in range(COUNT)]
NAMES = [ffi.string(row.name).decode() for row in ROWS]
DEFAULTS = [row.default_value for row in ROWS]
OF_38_PARAMETERS = bytes.fromhex(
    "434d4e509f85f3510000304100000c4200000c4200000c4200000c4200000c42"
    "00000c4200000c420ad7233c0ad7233c0ad7233c0ad7233c0000c8420000c842"
    "0000c8420000c8420ad7233c0000803f0000803fdb0fc9bf0000000000000000"
    "0000000000000000000000000000000000000000000000000000000000000000"
    "00000000000000000000803f0000803e0000c8410ad7a33b000020400000803f63812e4f"
)
FORMER_COUNTS = range(38, 44)
MAX_BYTES = 9 + 5 * 64


def record(values: Mapping[int, float] | Sequence[float], magic: bytes = b"CMN2") -> bytes:
    """Encodes a record. `values` maps parameter numbers to values."""
    pairs = list(values.items() if isinstance(values, Mapping) else enumerate(values))
    body = magic + bytes([len(pairs)]) + b"".join(struct.pack("<Bf", number, value) for number, value in pairs)
    return body + struct.pack("<I", zlib.crc32(body))


def former_record(values: Sequence[float], names: Sequence[str] = NAMES, magic: bytes = b"CMNP") -> bytes:
    layout = zlib.crc32(b"".join(name.encode() + b"\0" for name in names))
    body = magic + struct.pack(f"<I{len(values)}f", layout, *values)
    return body + struct.pack("<I", zlib.crc32(body))


def decode(data: bytes) -> list[float] | None:
    """Returns the decoded values, or None if the record is refused and the parameters are unchanged."""
    parameters = ffi.new("parameters_t *", {"value": [float(i) for i in range(COUNT)]})
    if lib.parameter_store_decode(data, len(data), parameters):
        return list(parameters.value)
    assert list(parameters.value) == list(range(COUNT))
    return None


def encode(values) -> bytes:
    data = ffi.new("uint8_t[]", MAX_BYTES)
    length = lib.parameter_store_encode(ffi.new("parameters_t *", {"value": values}), data)
    return bytes(data)[:length]


def random_values(rng) -> list[float]:
    draws = [float(np.float32(rng.uniform(row.minimum, row.maximum))) for row in ROWS]
    draws = [min(max(value, row.minimum), row.maximum) for value, row in zip(draws, ROWS, strict=True)]
    return [float(round(value)) if row.integer else value for value, row in zip(draws, ROWS, strict=True)]


def test_record_matches_an_independent_encoder(rng):
    for _ in range(50):
        values = random_values(rng)
        assert encode(values) == record(values)
        assert decode(record(values)) == values


def test_both_ends_of_each_range_are_preserved():
    for ends in ([row.minimum for row in ROWS], [row.maximum for row in ROWS], DEFAULTS):
        assert decode(encode(ends)) == ends


def test_every_flipped_bit_is_detected(rng):
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


def test_data_that_is_not_a_record_is_refused():
    """Data that is not a record is refused even if its CRC is valid."""
    assert decode(record(DEFAULTS)) == DEFAULTS
    assert decode(record(DEFAULTS, magic=b"cmn2")) is None
    assert decode(record(DEFAULTS, magic=b"CMN3")) is None
    assert decode(bytes(9 + 5 * COUNT)) is None
    body = record(DEFAULTS)[:-4]
    for count in (0, COUNT - 1, COUNT + 1, 255):
        other = body[:4] + bytes([count]) + body[5:]
        assert decode(other + struct.pack("<I", zlib.crc32(other))) is None, count


def test_missing_parameters_get_defaults_and_unknown_numbers_are_skipped(rng):
    values = dict(enumerate(random_values(rng)))
    for _ in range(50):
        kept = {number: value for number, value in values.items() if rng.random() < 0.5}
        unknown = {int(number): math.nan for number in rng.choice(np.arange(COUNT, 256), 5, replace=False)}
        pairs = list((kept | unknown).items())
        rng.shuffle(pairs)
        shuffled = {int(number): value for number, value in pairs}
        assert decode(record(shuffled)) == [kept.get(number, DEFAULTS[number]) for number in range(COUNT)]
    assert decode(record({})) == DEFAULTS


def test_the_former_format_is_read(rng):
    """The firmware still reads the records written by earlier firmware with 38 to 43 parameters, in which the values
    are in the order of their numbers."""
    values = random_values(rng)
    for count in FORMER_COUNTS:
        expected = [*values[:count], *DEFAULTS[count:]]
        assert decode(former_record(values[:count], NAMES[:count])) == expected
    whole = former_record(values[:43], NAMES[:43])
    for bit in range(0, 8 * len(whole), 7):
        bad = bytearray(whole)
        bad[bit // 8] ^= 1 << bit % 8
        assert decode(bytes(bad)) is None, bit
    assert decode(former_record(values[:37], NAMES[:37])) is None
    assert decode(former_record([*values[:43], 1.0], [*NAMES[:43], "another"])) is None
    assert decode(former_record(DEFAULTS[:43], ["renamed", *NAMES[1:43]])) is None
    assert decode(former_record(DEFAULTS[:42], NAMES[:43])) is None


def test_the_bytes_of_a_record_that_the_firmware_with_38_parameters_wrote_are_read():
    """The record contains a gain_w_per_s of 11, a speed_fraction of 0.25, and the defaults of all other parameters."""
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


# ---- a firmware with other parameters


@pytest.fixture(scope="module")
def other_firmware(tmp_path_factory):
    """Compiles firmware that lacks stale_periods (36) and has one additional parameter with the next free number."""
    folder = tmp_path_factory.mktemp("other")
    schema = folder / "schema"
    shutil.copytree(REPOSITORY / "firmware" / "schema", schema)
    text = (schema / "parameters.toml").read_text()
    without = re.sub(r"\[\[parameter\]\]\nnumber = 36\n.*?(?=\[\[)", "", text, flags=re.DOTALL)
    assert without != text
    more = (
        f'\n[[parameter]]\nnumber = {COUNT}\nname = "another_m"\nunit = "m"\n'
        'range = [0, 9]\ndefault = 4\ngroup = "x"\nmeaning = "x"\n'
    )
    (schema / "parameters.toml").write_text(without.replace("retired = []", "retired = [36]") + more)
    codegen.update_schema(schema)
    codegen.main(folder / "generated", schema)
    rooms = ("maths", "arms", "protocol", "safety", "control", "parameters")
    sources = [str(file) for room in rooms for file in sorted((REPOSITORY / "firmware" / room).glob("*.c"))]
    library = folder / "other.so"
    flags = ["-std=c11", "-O1", "-fPIC", "-shared", "-Wl,-z,defs", f"-I{folder / 'generated'}"]
    command = ["gcc", *flags, *sources, str(folder / "generated" / "comanip_dbc.c"), "-lm", "-o", str(library)]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(library))


def test_stored_values_survive_parameters_that_are_added_and_removed(other_firmware, rng):
    values = random_values(rng)
    own = encode(values)
    theirs = (ctypes.c_float * (COUNT + 1))()
    assert other_firmware.parameter_store_decode(own, ctypes.c_size_t(len(own)), theirs)
    expected = [value for number, value in enumerate(values) if number != 36]
    assert [value for number, value in enumerate(theirs[:COUNT]) if number != 36] == expected and theirs[COUNT] == 4
    theirs[COUNT] = 7.5
    data = (ctypes.c_ubyte * MAX_BYTES)()
    other_firmware.parameter_store_encode.restype = ctypes.c_size_t
    length = other_firmware.parameter_store_encode(theirs, data)
    numbers = dict(struct.iter_unpack("<Bf", bytes(data[5 : length - 4])))
    assert 36 not in numbers and numbers[COUNT] == 7.5 and len(numbers) == COUNT
    assert decode(bytes(data[:length])) == [*values[:36], DEFAULTS[36], *values[37:]]
