"""Checks the hub: the same frame order for all clients, rejection of packets that are not frames, listen-only clients,
dropping of slow clients, and access restricted to the owner."""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
import stat
import subprocess
import threading
from pathlib import Path

import pytest
from hub import CAN_EFF_FLAG, HUB, PATIENCE_S, Hub, classic, fd, running, wait_until
from images import make
from simulation import REPOSITORY

JOURNAL_FRAMES = int(
    re.search(r"JOURNAL_FRAMES (\d+)u", (REPOSITORY / "host_tools" / "hub" / "journal.h").read_text())[1]
)
LISTEN = "0A"  # code of the state LISTEN in /proc/net/tcp


def receive(client: socket.socket, count: int) -> list[bytes]:
    return [client.recv(100) for _ in range(count)]


def call(*arguments: str, folder: Path) -> subprocess.CompletedProcess:
    environment = {**os.environ, "COMANIP_HUB_DIR": str(folder)}
    return subprocess.run(
        [HUB, *arguments], env=environment, capture_output=True, text=True, check=False, timeout=PATIENCE_S
    )


# ---- frames


def test_all_other_clients_get_the_frames_in_one_order():
    per_sender = 300
    with running() as hub:
        senders = [hub.connect() for _ in range(3)]
        listeners = [hub.connect() for _ in range(3)]
        hub.wait_for_clients(6)
        sent = [[fd(0x100 + i, k.to_bytes(4, "little")) for k in range(per_sender)] for i in range(3)]

        def send(client: socket.socket, packets: list[bytes]) -> None:
            for packet in packets:
                client.send(packet)

        threads = [threading.Thread(target=send, args=pair) for pair in zip(senders, sent, strict=True)]
        for thread in threads:
            thread.start()
        received = [receive(listener, 3 * per_sender) for listener in listeners]
        for thread in threads:
            thread.join()
        assert received[0] == received[1] == received[2]
        for i, sender in enumerate(senders):
            assert [packet for packet in received[0] if packet in set(sent[i])] == sent[i], (
                "the frames of each sender keep their order"
            )
            others = [packet for packet in received[0] if packet not in set(sent[i])]
            assert receive(sender, 2 * per_sender) == others, (
                "a sender gets the other senders' frames in the same order"
            )
            sender.setblocking(False)
            with pytest.raises(BlockingIOError):
                sender.recv(100)


def test_packets_pass_unchanged():
    packets = [
        classic(0x7FF, b"12345678"), classic(0x0), fd(0x123, bytes(range(64))), fd(CAN_EFF_FLAG | 0x1FFFFFFF, b"x"),
        classic(0x40000123, b"", 8), classic(0x20000004, bytes(8)),
    ]  # fmt: skip
    with running() as hub:
        sender, listener = hub.connect(), hub.connect()
        hub.wait_for_clients(2)
        for packet in packets:
            sender.send(packet)
        assert receive(listener, len(packets)) == packets


@pytest.mark.parametrize(
    "packet",
    [
        b"x", classic(0x1)[:15], classic(0x1) + b"x", fd(0x1)[:71], fd(0x1) + b"x", bytes(4000),
        classic(0x1, b"", 9), fd(0x1, b"", 65), fd(0x1, b"", 255), classic(0x800), fd(0x1FFFFFFF), classic(0x40000800),
    ],
)  # fmt: skip
def test_packets_that_are_not_frames_are_refused(packet):
    with running() as hub:
        sender, listener = hub.connect(), hub.connect()
        hub.wait_for_clients(2)
        for sent in (packet, packet, classic(0x55)):
            sender.send(sent)
        assert listener.recv(100) == classic(0x55)
        sender.close()
        wait_until(lambda: "2 packets or commands were refused" in hub.stderr(), "a count of refused packets")
        assert "is refused: expected a can_frame" in hub.stderr()


def test_listeners_of_a_listen_only_hub_cannot_send():
    with running("--listen-only", "--socketcand", "off") as hub:
        source, loud, quiet = hub.connect(".source"), hub.connect(), hub.connect()
        hub.wait_for_clients(2)
        for _ in range(3):
            loud.send(classic(0x666))
        wait_until(lambda: "may only listen" in hub.stderr(), "a message")
        source.send(classic(0x1))
        assert quiet.recv(100) == loud.recv(100) == classic(0x1)
        source.setblocking(False)
        with pytest.raises(BlockingIOError):
            source.recv(100)
        loud.close()
        wait_until(lambda: "3 frames were not forwarded" in hub.stderr(), "a count of frames not forwarded")


def test_a_client_that_only_sends_is_never_too_slow():
    with running() as hub:
        sender, listener, other = hub.connect(), hub.connect(), hub.connect()
        sender.shutdown(socket.SHUT_RD)
        hub.wait_for_clients(3)
        other.send(classic(0x1))
        assert listener.recv(100) == classic(0x1)
        sender.send(classic(0x2))
        assert listener.recv(100) == classic(0x2)


def test_a_stalled_listener_is_dropped_and_delays_nobody():
    count = JOURNAL_FRAMES + 8192  # more than the journal and the kernel's queue can hold
    with running() as hub:
        sender, listener, stalled = hub.connect(), hub.connect(), hub.connect()
        hub.wait_for_clients(3)
        for first in range(0, count, 128):
            expected = [classic(0x1, k.to_bytes(4, "little")) for k in range(first, first + 128)]
            for packet in expected:
                sender.send(packet)
            assert receive(listener, 128) == expected
        assert re.fullmatch(
            r"comanip-hub: unix client \d is dropped: it reads too slowly, "
            rf"more than {JOURNAL_FRAMES} frames are waiting\n",
            hub.stderr(),
        )
        got = 0
        while packet := stalled.recv(100):
            assert packet == classic(0x1, got.to_bytes(4, "little")), "received frames are in order"
            got += 1
        assert 0 < got < count - JOURNAL_FRAMES


def test_at_its_end_all_clients_get_the_queued_frames():
    count = 20000
    with running() as hub:
        sender, listener = hub.connect(), hub.connect()
        hub.wait_for_clients(2)
        for k in range(count):
            sender.send(fd(0x1, k.to_bytes(4, "little")))
        hub.process.send_signal(signal.SIGTERM)
        assert receive(listener, count)[-1] == fd(0x1, (count - 1).to_bytes(4, "little"))
        assert listener.recv(100) == b""
        assert hub.process.wait(PATIENCE_S) == 0
        assert not hub.path.exists()


# ---- access


def sockets_of(process: subprocess.Popen) -> set[str]:
    links = [os.readlink(f"/proc/{process.pid}/fd/{number}") for number in os.listdir(f"/proc/{process.pid}/fd")]
    return {match[1] for link in links if (match := re.fullmatch(r"socket:\[(\d+)\]", link))}


def network_addresses(process: subprocess.Popen) -> list[tuple[str, str]]:
    """Returns address and state of all TCP and UDP sockets of the process."""
    found = []
    for kind in ("tcp", "tcp6", "udp", "udp6"):
        for line in Path(f"/proc/{process.pid}/net/{kind}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[9] in sockets_of(process):
                found.append((fields[1].split(":")[0], fields[3]))
    return found


def test_nothing_listens_off_loopback():
    with running("--socketcand", "0") as hub:
        assert network_addresses(hub.process) == [("0100007F", LISTEN)]
    with running("--socketcand", "off") as hub:
        assert network_addresses(hub.process) == []


def test_only_the_owner_can_open_the_socket(tmp_path):
    with running("--listen-only", "--socketcand", "off", folder=tmp_path / "new") as hub:
        assert stat.S_IMODE(hub.folder.stat().st_mode) == 0o700
        for suffix in ("", ".source", ".lock"):
            assert stat.S_IMODE(Path(f"{hub.path}{suffix}").stat().st_mode) & 0o077 == 0


def test_a_world_writable_folder_is_refused(tmp_path):
    tmp_path.chmod(0o777)
    done = call(folder=tmp_path)
    assert done.returncode == 1
    assert "only its owner" in done.stderr
    assert not list(tmp_path.glob("vcan0"))


def test_one_hub_per_bus(tmp_path):
    with running(folder=tmp_path) as first:
        done = call("--socketcand", "off", folder=tmp_path)
        assert (done.returncode, done.stderr) == (1, "comanip-hub: bus vcan0: another hub already runs this bus\n")
        with running(folder=tmp_path, bus="vcan1") as other:
            assert other.path.exists()
        first.process.kill()
        first.process.wait()
        assert first.path.exists(), "a killed hub leaves its socket behind"
        with running(folder=tmp_path) as second:
            a, b = second.connect(), second.connect()
            second.wait_for_clients(2)
            a.send(classic(0x1))
            assert b.recv(100) == classic(0x1)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--bus", "../x"], "bus '../x': expected 1 to 15 letters"), (["--bus", ""], "bus '': expected"),
        (["--bus", "a" * 16], "expected 1 to 15"), (["--socketcand", "65536"], "--socketcand '65536': expected a port"),
        (["--socketcand", "x"], "--socketcand 'x'"), (["--nonsense"], "'--nonsense': no such option"),
        (["--bus"], "'--bus': expected a value"), (["vcan0"], "'vcan0': expected options only"),
    ],
)  # fmt: skip
def test_wrong_use_gives_one_line(arguments, named, tmp_path):
    done = call(*arguments, folder=tmp_path / "none")
    assert done.returncode == 2
    assert named in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "none").exists()


# ---- socketcand


class Line:
    """A client's connection to socketcand."""

    def __init__(self, hub: Hub):
        self.socket = socket.create_connection(("127.0.0.1", hub.port), PATIENCE_S)
        self.expect("< hi >")

    def send(self, text: str) -> None:
        self.socket.sendall(text.encode("latin-1"))

    def expect(self, text: str) -> None:
        got = b""
        while len(got) < len(text):
            part = self.socket.recv(len(text) - len(got))
            assert part, f"closed after {got!r}"
            got += part
        assert got.decode() == text

    def open(self) -> None:
        for command in ("< open vcan0 >", "< rawmode >"):
            self.send(command)
            self.expect("< ok >")


def test_socketcand_sends_and_receives():
    with running("--socketcand", "0") as hub:
        client, line = hub.connect(), Line(hub)
        line.open()
        for byte in "< send 123 4 de ad BE 0f >  < send 1ABCDEF0 0  >\n<send 7ff 0c 0 1 2 3 4 5 6 7 8 9 a b>":
            line.send(byte)
        assert client.recv(100) == classic(0x123, bytes.fromhex("deadbe0f"))
        assert client.recv(100) == classic(CAN_EFF_FLAG | 0x1ABCDEF0)
        packet = client.recv(100)
        assert packet[:5] + packet[8:] == fd(0x7FF, bytes(range(12)))[:5] + fd(0x7FF, bytes(range(12)))[8:]
        client.send(classic(0x40000001))  # a remote frame, which socketcand cannot express
        client.send(fd(0x12, b"\x01\x23"))
        client.send(classic(CAN_EFF_FLAG | 0x12))
        text = ""
        while text.count(">") < 2:
            text += line.socket.recv(1000).decode()
        assert re.fullmatch(r"< frame 012 \d{10}\.\d{6} 0123 > *< frame 00000012 \d{10}\.\d{6}  >", text.lstrip())
        assert "a remote frame is left out" in hub.stderr()


MALFORMED = (
    "< >", "<>", "< nonsense >", "< open >", "< open vcan0 x >", "< open vcan0123456789abcdef >", "< send >",
    "< send 123 >", "< send 123 4 1 2 3 >", "< send 123 2 1 2 3 >", "< send 123 1 100 >", "< send 123 1 -1 >",
    "< send 800 0 >", "< send 20000000 0 >", "< send 123 9 1 2 3 4 5 6 7 8 9 >", "< send xyz 0 >", "< send 0x1 0 >",
    "< send 123456789 0 >", "< se\0nd 123 0 >", "x >", "< \xff\xfe >", "< send 123 1 1 1" + " 1" * 80 + " >",
)  # fmt: skip


@pytest.mark.parametrize("text", MALFORMED)
def test_a_malformed_command_gets_an_error_and_the_connection_survives(text):
    with running("--socketcand", "0") as hub:
        client, line = hub.connect(), Line(hub)
        line.open()
        line.send(text)
        answer = ""
        while not answer.endswith(">"):
            answer += line.socket.recv(100).decode()
        assert re.fullmatch(r"< error [^<>]+ >", answer)
        line.send("< send 1 0 >")
        assert client.recv(100) == classic(0x1)


def test_an_endless_command_gets_an_error_and_is_closed():
    with running("--socketcand", "0") as hub:
        line = Line(hub)
        line.send("< " + "a" * 300)
        line.expect("< error command too long >")
        with pytest.raises(ConnectionError):  # end of file, or a reset if the hub left data unread
            if line.socket.recv(1) == b"":
                raise ConnectionResetError


def test_commands_out_of_order_are_refused():
    with running("--socketcand", "0") as hub:
        line = Line(hub)
        for command, answer in (
            ("< rawmode >", "< error no bus is open >"),
            ("< send 1 0 >", "< error not in rawmode >"),
            ("< open vcan7 >", "< error could not open bus >"),
            ("< echo >", "< echo >"),
        ):
            line.send(command)
            line.expect(answer)


# ---- brief fuzzing; `make fuzz-hub` fuzzes each program for ten minutes


@pytest.mark.parametrize("program", ["fuzz_socketcand", "fuzz_unix"])
def test_taps_survive_fuzzing(program, tmp_path):
    clang = shutil.which("clang")
    if clang is None:
        pytest.skip("clang is not installed: run `make fuzz-deps`")
    runtime = subprocess.run([clang, "-print-runtime-dir"], capture_output=True, text=True, check=True).stdout.strip()
    if not list(Path(runtime).glob("libclang_rt.fuzzer*")):
        pytest.skip(f"clang has no libFuzzer in {runtime}: run `make fuzz-deps`")
    built = REPOSITORY / "build" / "fuzz" / program
    compiled = make(f"build/fuzz/{program}")
    assert compiled.returncode == 0, compiled.stderr
    (tmp_path / "corpus").mkdir()
    seeds = {
        "commands": b"\xa0< open vcan0 >< rawmode >\x90< send 123 2 1 2 >",
        "frames": b"\x00" + classic(0x1) + b"\x40" + fd(0x1),
    }
    for name, seed in seeds.items():
        (tmp_path / "corpus" / name).write_bytes(seed)
    done = subprocess.run(
        [built, "-runs=3000", "-seed=1", "-max_len=2048", "-close_fd_mask=2", f"-artifact_prefix={tmp_path}/",
         tmp_path / "corpus"],
        capture_output=True, text=True, check=False, timeout=PATIENCE_S,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    assert "Done 3000 runs" in done.stderr
