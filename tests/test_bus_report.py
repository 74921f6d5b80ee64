"""Checks the report of bus loads and response times: the loads and response times against the DBC, the marks for late
frames, and the file that the report is written to."""

from __future__ import annotations

import json
import re

import pytest
from bus_log import CLASSIC_MESSAGES, DBC, FD_MESSAGES
from can_classic_bits import frame_duration_ns as classic_duration_ns
from can_fd_bits import frame_duration_ns as fd_duration_ns
from comanip.bus.frame_length import BitRates, longest
from comanip_dev.bus import report as bus_report
from comanip_dev.bus.report import JOINTS

FD, CLASSIC = "CAN FD 1/5 Mbit/s", "classic 1 Mbit/s"


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "reports" / "bus.json"
    assert bus_report.main([str(path)]) == 0
    assert [file.name for file in path.parent.iterdir()] == ["bus.json"], "no temporary file is left"
    return json.loads(path.read_text())


@pytest.fixture(scope="module")
def by_profile(written):
    return {(item["profile"], item["joints"]): item for item in written["results"]}


def test_every_profile_and_number_of_joints_is_there(by_profile):
    assert {joints for _, joints in by_profile} == {4, 6, 7, 8}
    assert len(by_profile) == 3 * 4
    assert {FD, CLASSIC} < {profile for profile, _ in by_profile}


@pytest.mark.parametrize("joints", JOINTS)
def test_fd_rows_are_the_dbcs_frames(by_profile, joints):
    rows = [row for row in by_profile[FD, joints]["rows"] if "," not in row["name"]]
    absent = {"FirmwareIdentity", *(f"JointState{joint}" for joint in range(joints, 8))}
    expected = {m.name: (m.frame_id, m.length, bool(m.cycle_time)) for m in FD_MESSAGES if m.name not in absent}
    assert {row["name"]: (row["id"], row["bytes"], row["cyclic"]) for row in rows} == expected
    assert all(row["period_ms"] == DBC.get_message_by_name(row["name"]).cycle_time for row in rows if row["cyclic"])


@pytest.mark.parametrize("joints", JOINTS)
def test_the_cyclic_load_is_the_sum_over_the_dbc(by_profile, joints):
    """The cyclic load equals the sum over the DBC's cyclic frames at their maximum length, with durations constructed
    bit by bit."""
    share = 0.0
    for message in FD_MESSAGES:
        if message.cycle_time and not (message.name.startswith("JointState") and int(message.name[-1]) >= joints):
            payload = longest(message.frame_id, message.length, BitRates(1_000_000, 5_000_000)).payload
            share += fd_duration_ns(message.frame_id, payload) / (1e6 * message.cycle_time)
    assert by_profile[FD, joints]["load_cyclic_percent"] == pytest.approx(100 * share)
    assert by_profile[FD, joints]["load_percent"] > by_profile[FD, joints]["load_cyclic_percent"]


@pytest.mark.parametrize("joints", JOINTS)
def test_classic_rows_are_the_dbcs_frames(by_profile, joints):
    rows = [row for row in by_profile[CLASSIC, joints]["rows"] if "," not in row["name"]]
    absent = {"ClassicFirmwareBuild", "ClassicFirmwareIdentity"}
    absent |= {f"ClassicJoint{kind}{joint}" for kind in ("Cmd", "State") for joint in range(joints, 8)}
    messages = [*CLASSIC_MESSAGES, DBC.get_message_by_name("FirmwareHeartbeat")]
    rare = {
        f"ClassicTask{part}": 100 for part in ("Translation", "Rotation", "Inverse")
    }  # the other parts of a TaskDefine
    expected = {
        m.name: (m.frame_id, m.length, m.cycle_time or rare.get(m.name, 4)) for m in messages if m.name not in absent
    }
    assert {row["name"]: (row["id"], row["bytes"], row["period_ms"]) for row in rows} == expected
    share = sum(1e-3 * row["longest_us"] / row["period_ms"] for row in rows if row["cyclic"])
    assert by_profile[CLASSIC, joints]["load_cyclic_percent"] == pytest.approx(100 * share)
    for row in rows:
        payload = longest(row["id"], row["bytes"], BitRates(1_000_000)).payload
        assert 1000 * row["longest_us"] == pytest.approx(classic_duration_ns(row["id"], payload))


def test_the_classic_profile_meets_its_specification():
    """The classic profile has a control rate of 250 Hz, sends the pose in two frames at 125 Hz, and has no frame longer
    than 8 bytes."""
    by_name = {message.name.removeprefix("Classic"): message for message in CLASSIC_MESSAGES}
    assert {by_name[f"Joint{kind}{joint}"].cycle_time for kind in ("Cmd", "State") for joint in range(8)} == {4}
    assert by_name["HandPosition"].cycle_time == by_name["HandRotation"].cycle_time == 8
    assert max(message.length for message in CLASSIC_MESSAGES) == 8


def test_late_frames_are_named(written):
    late = set()
    for item in written["results"]:
        for row in item["rows"]:
            is_late = row["response_ms"] is None or row["response_ms"] > row["deadline_ms"]
            assert row["late"] == is_late
            assert row["deadline_ms"] == (row["period_ms"] if row["cyclic"] else 20)
        assert item["late"] == [row["name"] for row in item["rows"] if row["late"]]
        late.add(bool(item["late"]))
        assert set(item["late"]) <= set(item["late_at_boot"]), "additional traffic at boot makes no frame earlier"
    assert late == {True, False}


def test_the_last_of_four_joint_states_by_hand(by_profile):
    """The response time of the last joint state is the sum of 50 us of computing time, the longest frame of lower
    priority, one instance of each frame of higher priority, and the joint state itself. Of the two answers
    to the operator, CommandAck and ParameterValue, only the longer counts."""
    before = ["TaskDefine", "FirmwareStatus", "ParameterValue", "JointCmd", "TickTrace", "Clearance", "HandPose"]
    total_ns = 50_000
    for name in [*before, *(f"JointState{joint}" for joint in range(4))]:
        message = DBC.get_message_by_name(name)
        payload = longest(message.frame_id, message.length, BitRates(1_000_000, 5_000_000)).payload
        total_ns += fd_duration_ns(message.frame_id, payload)
    rows = {row["name"]: row for row in by_profile[FD, 4]["rows"]}
    assert rows["JointState3"]["response_ms"] == pytest.approx(1e-6 * total_ns)


def test_the_figures_in_the_readme(by_profile):
    for (profile, joints), item in by_profile.items():
        assert bool(item["late"]) == (profile == FD and joints > 4), (profile, joints, item["late"])
    last = next(row for row in by_profile[FD, 4]["rows"] if row["name"] == "JointState3")
    assert f"{last['response_ms']:.2f}" == "0.96"
    assert by_profile[FD, 4]["late_at_boot"] == ["JointState2", "JointState3"]


def test_more_joints_and_slower_data_make_nothing_earlier(by_profile):
    def responses(profile: str, joints: int) -> dict[str, float]:
        return {row["name"]: row["queued_ms"] for row in by_profile[profile, joints]["rows"]}

    for few, many in zip(JOINTS, JOINTS[1:], strict=False):
        more = responses(FD, many)
        assert all(more[name] >= response for name, response in responses(FD, few).items())
        slow, fast = responses(FD, few), responses("CAN FD 1/8 Mbit/s", few)
        assert all(fast[name] < slow[name] for name in slow)


def test_the_tables_match_the_report(capsys, written):
    assert bus_report.main([]) == 0
    text = capsys.readouterr().out
    for item in written["results"]:
        load = f"{item['load_percent']:.1f} %"
        assert re.search(rf"{re.escape(item['profile'])} +│ +{item['joints']} │ +{re.escape(load)} │", text)
    printed = {float(number) for number in re.findall(r"(\d+\.\d{3}) !", text)}
    late = {round(row["response_ms"], 3) for item in written["results"] for row in item["rows"] if row["late"]}
    assert printed == late
    assert all(line[:60] in text for line in written["assumptions"])


def test_late_frames_are_listed_as_families():
    assert bus_report.names(["JointState4", "JointState5", "TrackerStatus"]) == "JointState4..5, TrackerStatus"
    assert bus_report.names([]) == "-"


@pytest.mark.parametrize("arguments", [["a", "b"], ["--help-me"]])
def test_wrong_use(capsys, arguments):
    assert bus_report.main(arguments) == 2
    assert capsys.readouterr().err.startswith("usage:")


def test_a_file_that_cannot_be_written_is_named(capsys, tmp_path):
    (tmp_path / "file").write_text("")
    assert bus_report.main([str(tmp_path / "file" / "bus.json")]) == 2
    assert str(tmp_path / "file" / "bus.json") in capsys.readouterr().err
