"""Checks that docs/bus.md agrees with the DBC, and that the traffic stays within the ranges given in the DBC."""

from __future__ import annotations

import re
import subprocess

import bus_log
import numpy as np
import pytest
from bus_log import DBC
from comanip import parameters
from comanip._core import lib
from comanip_dev.bus import doc as bus_doc
from comanip_dev.schema import parameters_doc
from simulation import REPOSITORY, SIMULATOR, run

BUS_MD = REPOSITORY / "docs" / "bus.md"
PARAMETERS_MD = REPOSITORY / "docs" / "parameters.md"


def test_the_document_is_current():
    current = bus_doc.markdown(DBC, lib.E2E_MAX_DELTA, lib.E2E_PROFILE2_MAX_DELTA)
    assert BUS_MD.read_text() == current, "docs/bus.md does not match the DBC: run `make schema`"


def test_the_parameters_document_is_current():
    current = parameters_doc.markdown(parameters.read())
    assert PARAMETERS_MD.read_text() == current, "docs/parameters.md does not match parameters.toml: run `make schema`"


def test_every_frame_and_signal_is_there():
    """The document lists the same ids, lengths, periods and start bits as cantools reads from the DBC."""
    text = BUS_MD.read_text()
    rows = re.findall(
        r"^\| (0x\w+)(?:\.\.(0x\w+))? \| \[\w+(?:\.\.\d)?\]\(#\w+\) \| (\d+) \| ([\w ]+) \|", text, re.MULTILINE
    )
    documented = {}
    for first, last, length, period in rows:
        for frame_id in range(int(first, 16), int(last or first, 16) + 1):
            documented[frame_id] = (int(length), int(period.removesuffix(" ms")) if period != "on events" else 0)
    assert documented == {m.frame_id: (m.length, m.cycle_time or 0) for m in DBC.messages}
    for message in DBC.messages:
        if not re.search(r"[1-7]$", message.name):
            section = text.partition(f"\n### {message.name}")[2].partition("\n### ")[0]
            starts = {name: int(bit) for name, bit in re.findall(r"^\| `(\w+)` \| (\d+) \|", section, re.MULTILINE)}
            plain = {s.name: s.start for s in message.signals if s.name[:4] != "e2e_" and s.name in starts}
            assert starts and all(starts[name] == start for name, start in plain.items()), message.name
            for name in starts.keys() - plain.keys():  # signals that are documented once for all joints
                first = message.get_signal_by_name(re.sub(r"_N(?=_|$)", "_0", name))
                assert first.start == starts[name], (message.name, name)


def test_anchors_lead_to_sections():
    text = BUS_MD.read_text()
    headings = {
        re.sub(r"[^\w-]", "", h.lower().replace(" ", "-")) for h in re.findall(r"^##+ (.+)$", text, re.MULTILINE)
    }
    assert set(re.findall(r"\]\(#([\w-]+)\)", text)) == headings


@pytest.mark.parametrize("message", DBC.messages, ids=lambda m: m.name)
def test_ranges_fit_into_their_bits(message):
    for signal in message.signals:
        assert signal.minimum is not None and signal.maximum > signal.minimum or signal.choices, signal.name
        if not signal.is_float:
            low, high = (
                (-(1 << signal.length - 1), (1 << signal.length - 1) - 1)
                if signal.is_signed
                else (0, (1 << signal.length) - 1)
            )
            assert float(signal.minimum) >= low * float(signal.scale) - 1e-9, signal.name
            assert float(signal.maximum) <= high * float(signal.scale) * (1 + 1e-9) + 1e-9, signal.name
        for value in signal.choices or {}:
            assert signal.minimum <= value <= signal.maximum, signal.name


def test_traffic_is_within_the_ranges(tmp_path):
    done = run(tmp_path / "out", "--scenario", "mirror", "--duration", 8, "--gap", "4:0.2").require_pass()
    frames = bus_log.read(done.log)
    seen = 0
    for message in DBC.messages:
        if message.name not in frames:
            continue
        for signal in message.signals:
            if signal.is_float or signal.length > 62:
                continue
            value = frames[message.name].raw(signal.name) * float(signal.scale)
            assert np.all(value >= float(signal.minimum) - 1e-9), f"{message.name}.{signal.name}: {value.min()}"
            assert np.all(value <= float(signal.maximum) + 1e-9), f"{message.name}.{signal.name}: {value.max()}"
            seen += 1
    assert seen > 100


def test_parameters_are_within_the_range_of_their_frames():
    """The parameter ranges listed in the simulator's help fit into the signal range of the parameter frames."""
    help_text = subprocess.run([SIMULATOR, "--help"], capture_output=True, text=True, check=True).stdout
    limits = np.array(re.findall(r"^ +\w+ +(\S+) to (\S+?)(?: [^,]+)?, \S+$", help_text, re.MULTILINE), float)
    message = DBC.get_message_by_name("ParameterValue")
    assert len(limits) == len(message.get_signal_by_name("parameter").choices)
    value = message.get_signal_by_name("value")
    assert value.minimum == pytest.approx(limits.min(), rel=1e-5) and value.maximum == pytest.approx(limits.max())


def test_two_files_are_wrong_use(capsys):
    assert bus_doc.main(["a", "b"]) == 2
    assert "usage:" in capsys.readouterr().err
