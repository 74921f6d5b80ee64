"""The images for microcontrollers: what is linked into them, and what they do in an emulator.

QEMU counts instructions instead of measuring time (-icount), so a second in these tests is a second of the emulated
machine, however busy the host is. These tests show that start-up code, drivers and firmware work. They cannot show
cycles, jitter or electrical behaviour."""

from __future__ import annotations

import os
import re
import shutil
import socket
import struct
import subprocess
import time
from pathlib import Path

import e2e.p05
import pytest
from images import IMAGES, REPOSITORY, SERIAL, make
from simulation import PATIENCE_S
from slcan_oracle import StockSlcan

# 500 million instructions per second, because the software floating point of rv32imac needs more than 125 million for 1
# kHz.
VIRTUAL_TIME = ["-icount", "shift=1,sleep=off"]
# Address and bit at which QEMU's monitor sees the drives' enable line. The RISC-V machine has no such line.
DRIVE_ENABLE = {
    "cortex-m3": (0x40028000, 0),
    "cortex-m4f": (0x40028000, 0),
    "cortex-m7": (0x40028000, 0),
    "cortex-m33": (0x50302000, 0),
    "cortex-m0plus": (0x50000504, 13),
}


@pytest.fixture(scope="module")
def target_build():
    missing = make("target-check")
    if missing.returncode != 0:
        pytest.skip(missing.stderr.strip())
    built = make("-j2", "target")
    assert built.returncode == 0, built.stderr
    assert built.stderr == ""  # neither the compiler nor the linker warns
    return REPOSITORY / "build" / "target"


# By default, one image for a processor with a floating-point unit and one for a processor without. `make test-images`
# tests all images that use the serial line.
TESTED = SERIAL if os.environ.get("ALL_IMAGES") else ["cortex-m4f", "rv32imac"]


@pytest.fixture(params=TESTED)
def image(request):
    return request.param


@pytest.fixture
def elf(target_build, image):
    return target_build / image / "comanip.elf"


# ---- what is linked


HEAP_AND_STDIO = re.compile(
    r"_*(v?(as|d|f|s|sn)?n?i?printf|[mc]alloc|realloc|free|s?brk)(_r)?|.*(malloc|printf|sbrk).*"
)
LIBM_NAMES = (
    "acos asin atan atan2 cbrt cos cosh erf exp exp2 expm1 fmod hypot ldexp log log10 log1p log2 pow round scalbn sin "
    "sincos sinh tan tanh"
)
LIBM = re.compile(rf"_*(ieee754_)?({'|'.join(LIBM_NAMES.split())})[fl]?|sqrtl?|roundf")
DOUBLE_ARITHMETIC = re.compile(
    r"__aeabi_(d\w+|cd\w+|\w+2d)|__(add|sub|mul|div|neg|eq|ne|ge|gt|le|lt|unord|fix|float|extend|trunc)\w*df\w*"
)


def symbols(elf: Path, image: str) -> list[str]:
    listing = subprocess.run([IMAGES[image].prefix + "nm", str(elf)], check=True, capture_output=True, text=True).stdout
    return [line.split()[-1] for line in listing.splitlines()]


def forbidden(names: list[str]) -> list[str]:
    return [n for n in names if any(p.fullmatch(n) for p in (HEAP_AND_STDIO, LIBM, DOUBLE_ARITHMETIC))]


def test_no_heap_no_stdio_no_libm_and_no_double(elf, image):
    names = symbols(elf, image)
    assert {"firmware_main", "controller_step", "hal_panic"} <= set(names)
    assert forbidden(names) == []


def test_forbidden_functions_would_be_found(target_build, image, tmp_path):
    """In a program that calls forbidden functions, built with the same toolchain and processor flags, the check finds
    all of them."""
    source = tmp_path / "program.c"
    source.write_text("""
        #include <math.h>
        #include <stdio.h>
        #include <stdlib.h>
        volatile float x; volatile double y; void *volatile p;
        int main(void) { x = sinf(x) + cosf(x); y = sin(y) * cos(y) + 1.0; p = malloc(9); free(p);
            return printf("%d", 1); }
        void *sbrk(ptrdiff_t n) { (void)n; return 0; }
        void *_sbrk(ptrdiff_t n) { (void)n; return 0; }
    """)
    program = tmp_path / "program.elf"
    compiler = [IMAGES[image].prefix + "gcc", f"--specs={IMAGES[image].specs}", *IMAGES[image].cpu]
    command = [*compiler, "-O2", "-nostartfiles", "-Wl,-emain",
               "-Wl,--unresolved-symbols=ignore-all", str(source), "-lm", "-o", str(program)]  # fmt: skip
    subprocess.run(command, check=True, capture_output=True)
    found = forbidden(symbols(program, image))
    assert {"sinf", "cosf", "sin", "cos", "malloc", "free", "printf"} <= set(found)
    assert {"sbrk", "_sbrk"} & set(found)
    assert any(DOUBLE_ARITHMETIC.fullmatch(name) for name in found)


def test_a_missing_compiler_is_named_with_its_package(image):
    answer = make("target", f"{image}.prefix=no-such-")
    assert answer.returncode != 0
    assert "no-such-gcc" in answer.stderr
    assert f"gcc-{IMAGES[image].prefix}".removesuffix("-") in answer.stderr


CORE = {"cortex-m3": "7-M", "cortex-m4f": "7E-M", "cortex-m7": "7E-M", "cortex-m33": "8-M.MAIN",
        "cortex-m0plus": "6S-M", "rv32imac": "rv32i2p1_m2p0_a2p1_c2p0",
        "rv32imafc": "rv32i2p1_m2p0_a2p1_f2p2_c2p0"}  # fmt: skip


def test_each_image_is_made_for_its_processor(elf, image):
    """The object files name the right processor, in the tags of the ABI: CPU_name on Arm, arch on RISC-V."""
    told = subprocess.run(
        [IMAGES[image].prefix + "readelf", "-A", str(elf)], check=True, capture_output=True, text=True
    ).stdout
    name = re.search('(?:Tag_CPU_name|Tag_RISCV_arch): "([^"]+)"', told)[1]
    assert name.startswith(CORE[image]), name
    floating_point = {
        "cortex-m4f": "VFPv4-D16",
        "cortex-m7": "FPv5/FP-D16 for ARMv8",
        "cortex-m33": "FPv5/FP-D16 for ARMv8",
    }.get(image)
    assert re.findall("Tag_FP_arch: (.+)", told) == ([floating_point] if floating_point else [])


def test_a_board_is_one_image_and_an_unknown_one_is_refused(target_build):
    built = make("target", "BOARD=mps2-an500")
    assert built.returncode == 0
    assert [line.split()[-1] for line in built.stdout.splitlines()[1:]] == ["build/target/cortex-m7/comanip.elf"]
    refused = make("target", "BOARD=arduino")
    assert refused.returncode == 2
    assert f"BOARD='arduino': expected one of {' '.join(image.board for image in IMAGES.values())}" in refused.stderr


# ---- what they do


def until_prompt(connection: socket.socket) -> str:
    """Returns what QEMU's monitor prints up to its next prompt. Waiting for the prompt matters, because output may be
    lost if QEMU quits earlier."""
    said = ""
    while not said.endswith("(qemu) "):
        said += connection.recv(1 << 16).decode()
    return said


def run(image: str, elf: Path, folder: Path, done, commands: bytes = b"", monitor: str = "") -> tuple[str, str]:
    """Boots the image and sends it the commands. Waits until done(output) holds, and returns the output and what QEMU's
    monitor printed."""
    if shutil.which(IMAGES[image].emulator[0]) is None:
        pytest.skip(f"{IMAGES[image].emulator[0]} is not installed: make target-deps")
    serial, console, monitor_socket = folder / "serial", folder / "commands", folder / "monitor"
    console.write_bytes(commands)
    with console.open("rb") as stdin, serial.open("wb") as stdout:
        emulator = subprocess.Popen(
            [*IMAGES[image].emulator, *VIRTUAL_TIME, "-display", "none", "-serial", "stdio", "-kernel", str(elf),
             "-monitor", f"unix:{monitor_socket},server=on,wait=off"],
            stdin=stdin, stdout=stdout, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
    try:
        deadline = time.monotonic() + PATIENCE_S
        while not done(serial.read_bytes().decode()):
            assert emulator.poll() is None, f"{IMAGES[image].emulator[0]} ended: {emulator.stderr.read()}"
            assert time.monotonic() < deadline, (
                f"not done after {PATIENCE_S} s; the last bytes: {serial.read_bytes().decode()[-300:]!r}"
            )
            time.sleep(0.05)
        answer = ""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(PATIENCE_S)
            connection.connect(str(monitor_socket))
            for command in [monitor, "quit\n"] if monitor else ["quit\n"]:
                answer += until_prompt(connection)
                connection.sendall(command.encode())
            while connection.recv(1 << 16):
                pass  # wait until QEMU has quit
        emulator.wait(PATIENCE_S)
        return serial.read_bytes().decode(), answer
    finally:
        emulator.kill()
        emulator.wait()


def decoded(dbc, text: str) -> list[tuple[str, dict]]:
    """Decodes every line into a message: SLCAN with python-can and the frame with cantools. Checks the protection with
    autosar-e2e."""
    stock = StockSlcan()
    messages, counters = [], {}
    for line in text.split("\r")[:-1]:
        frame = stock.message(line.encode())
        assert frame is not None and frame.is_fd and frame.bitrate_switch and not frame.is_extended_id, line
        assert stock.line(frame) == line.encode() + b"\r"
        message = dbc.get_message_by_frame_id(frame.arbitration_id)
        assert len(frame.data) == message.length
        if "E2EDataId" in message.dbc.attributes:
            assert e2e.p05.e2e_p05_check(bytes(frame.data), message.dbc.attributes["E2EDataId"].value), line
            expected = (counters[message.name] + 1) % 256 if message.name in counters else frame.data[2]
            assert frame.data[2] == expected, f"{message.name}: a frame is missing"
            counters[message.name] = frame.data[2]
        messages.append((message.name, message.decode(bytes(frame.data), decode_choices=True)))
    return messages


@pytest.fixture(scope="module")
def first_second(tmp_path_factory):
    """Returns a function that boots an image and returns what it sends up to its 1000th JointCmd, which is that of the
    1000th tick."""
    sent = {}

    def boot(image: str, elf: Path) -> str:
        if image not in sent:
            text, _ = run(image, elf, tmp_path_factory.mktemp(image), lambda t: t.count("b050") > 1000)
            ends = [match.end() for match in re.finditer("b050[^\r]*\r", text)]
            sent[image] = text[: ends[999]]
        return sent[image]

    return boot


def test_boot_announcement(first_second, image, elf, dbc):
    messages = decoded(dbc, first_second(image, elf))
    received = {name: [data for n, data in messages if n == name] for name in {n for n, _ in messages}}
    own = [m for m in dbc.messages if m.senders == ["Firmware"] and not m.name.startswith("Classic")]
    assert set(received) == {"FirmwareIdentity", "ParameterValue"} | {m.name for m in own if m.cycle_time}
    (identity,) = received["FirmwareIdentity"]
    assert str(identity["arm"]) == "hoap3_right" and identity["joint_count"] == 4
    assert [p["parameter"].value for p in received["ParameterValue"]] == list(range(identity["parameter_count"]))
    assert len(received["FirmwareStatus"]) == 500  # one every 2 ms
    assert {str(status["mode"]) for status in received["FirmwareStatus"]} == {"idle"}
    states = [str(heartbeat["state"]) for heartbeat in received["FirmwareHeartbeat"]]
    assert states[0] == "boot_up" and set(states[1:]) == {"pre_operational"} and 10 <= len(states) <= 11
    for command in received["JointCmd"]:  # no drive answers, so nothing may move
        assert {str(command[f"mode_{joint}"]) for joint in range(8)} == {"brake"}
        assert {command[f"velocity_{joint}_radps"] for joint in range(8)} == {0}
    ticks = [trace["now_us"] for trace in received["TickTrace"]]
    assert ticks == list(range(1000, 1_000_000, 1000))  # no tick of the second was missed


def test_all_images_send_the_same_bytes(first_second, target_build):
    """All images send the same bytes, except in PortStatus, which contains the duration of a tick on the given
    processor."""
    sent = {image: first_second(image, target_build / image / "comanip.elf") for image in TESTED}
    streams = {image: re.sub(r"b330[^\r]*\r", "", text) for image, text in sent.items()}
    assert all(len(streams[image]) < len(sent[image]) for image in TESTED)
    assert {image for image in TESTED if streams[image] != streams["cortex-m4f"]} == set()


def protected(dbc, name: str, values: dict) -> bytes:
    """Returns the line of a protected frame from the operator."""
    message = dbc.get_message_by_name(name)
    data = bytearray(message.encode({"e2e_crc": 0, "e2e_counter": 0, **values}, padding=False))
    e2e.p05.e2e_p05_protect(data, message.dbc.attributes["E2EDataId"].value)
    return b"b%03X%X%s\r" % (message.frame_id, {8: 8, 12: 9}[len(data)], data.hex().encode())


def test_commands_are_received_between_malformed_lines(image, elf, dbc, tmp_path):
    write = {"operation": "write", "parameter": "damping", "sequence": 77, "value": 0.125}
    select = {"command": "select", "sequence": 78, "task": "mirror"}
    commands = (
        b"garbage\rb2019" + b"0" * 5 + b"\r\r\xff\x00\x80\r"
        + protected(dbc, "ParameterAccess", write)
        + b"b2028" + b"0" * 200 + b"\r"
        + protected(dbc, "OperatorCommand", select)
    )  # fmt: skip
    text, _ = run(image, elf, tmp_path, lambda t: t.count("b011") > 0 and t.count("b050") > 50, commands)
    messages = decoded(dbc, text[: text.rindex("\r") + 1])
    (value,) = [data for name, data in messages if name == "ParameterValue" and data["sequence"] == 77]
    assert (str(value["parameter"]), str(value["result"]), value["value"]) == ("damping", "accepted", 0.125)
    (ack,) = [data for name, data in messages if name == "CommandAck"]
    assert (str(ack["command"]), ack["sequence"], str(ack["result"])) == ("select", 78, "accepted")
    status = [data for name, data in messages if name == "FirmwareStatus"][-1]
    assert str(status["task"]) == "mirror"
    assert status["rejected_frames"] == 0  # malformed lines never become frames


with_enable_line = pytest.mark.parametrize("image", [image for image in DRIVE_ENABLE if image in TESTED])


@with_enable_line
def test_the_drives_have_no_power_before_the_start(elf, image, tmp_path):
    _, answer = run(image, elf, tmp_path, lambda t: t.count("b050") > 10, monitor=show_drive_enable(image))
    assert drives_enabled(image, answer) is False


# ---- what they do when the firmware fails


PLANTED = """
    #include <board.h>
    #include <stddef.h>
    #include "HERE/hal/hal.h"
    #include "HERE/firmware/main.h"
    static inline void spin(unsigned long rounds) {
    #ifdef __arm__
        __asm__ volatile(".syntax unified\\n1: subs %0, #1\\n bne 1b" : "+l"(rounds) : : "cc");
    #else
        __asm__ volatile("1: addi %0, %0, -1\\n bnez %0, 1b" : "+r"(rounds));
    #endif
    }
    extern volatile int use;
    volatile int use;
    int large_frame(void);
    __attribute__((noinline)) int large_frame(void) {
        volatile unsigned char bytes[3500];
        bytes[0] = 1; /* the lowest byte, far below the end of the stack */
        return bytes[0];
    }
    int dig(int depth);
    __attribute__((noinline)) int dig(int depth) {
        volatile int here = depth; /* keeps the compiler from turning the recursion into a loop */
        return depth < 0 ? 0 : here + dig(depth + 1);
    }
    void firmware_main(void) {
        hal_init();
        hal_enable_drives(true);
        uint32_t now_us;
        can_frame_t frame = {.id = 0x123, .length = 4};
        while (hal_wait_tick(&now_us)) {
            for (int i = 0; i < 4; i++) { frame.data[i] = (uint8_t)(now_us >> 8 * i); }
            (void)hal_can_send(&frame);
            hal_watchdog_feed();
            if (now_us == 50000) { STATEMENT; }
        }
    }
"""


def planted(image: str, folder: Path, statement: str) -> Path:
    """Builds an image of the port in which the firmware is replaced by a loop that sends the time and executes the
    given statement at 50 ms."""
    source = folder / "planted.c"
    source.write_text(PLANTED.replace("STATEMENT", statement).replace("HERE", str(REPOSITORY)))
    built = make(f"target-{image}", "CORE_SOURCES=", f"TARGET_MAIN={source}", f"TARGET_BUILD={folder}/build")
    assert built.returncode == 0, built.stderr
    return folder / "build" / image / "comanip.elf"


def ticks_us(text: str) -> list[int]:
    return [struct.unpack("<I", bytes.fromhex(line[5:]))[0] for line in text.split("\r") if len(line) == 13]


def busy(milliseconds: int) -> str:
    """Returns a statement that spins for the given time, in rounds of two instructions of 2 ns each."""
    return f"spin({milliseconds * 250_000}ul)"


FAULTS = {
    "stack overflow": ("use = dig(0)", {"stack overflow"}),
    "stack overflow by one large frame": ("use = large_frame()", {"stack overflow"}),
    "hang": ("for (;;) { }", {"watchdog: not fed in time"}),
    "busy for 12 ms": (busy(12), {"watchdog: not fed in time"}),
    "invalid address": ("*(volatile int *)0x90000000u = 1", {"bus fault", "access fault", "hard fault"}),
    "invalid instruction": ('__asm__ volatile("udf #0")', {"usage fault", "illegal instruction", "hard fault"}),
    "panic": ('hal_panic("planted")', {"planted"}),
    "loop ended": ("return", {"the firmware's loop ended"}),
}


def show_drive_enable(image: str) -> str:
    """Returns the command by which QEMU's monitor prints the register of the enable line."""
    return f"x /1wx {DRIVE_ENABLE[image][0]:#x}\n" if image in DRIVE_ENABLE else ""


def drives_enabled(image: str, answer: str) -> bool | None:
    if image not in DRIVE_ENABLE:
        return None
    address, bit = DRIVE_ENABLE[image]
    (word,) = re.findall(f"{address:08x}: 0x([0-9a-f]+)", answer)
    return int(word, 16) >> bit & 1 == 1


@with_enable_line
def test_the_drives_have_power_while_the_firmware_has_it_so(image, target_build, tmp_path):
    elf = planted(image, tmp_path, "use = 1")
    _, answer = run(image, elf, tmp_path, lambda t: len(ticks_us(t)) > 60, monitor=show_drive_enable(image))
    assert drives_enabled(image, answer) is True


@pytest.mark.parametrize("fault", FAULTS)
def test_a_failing_firmware_ends_in_the_safe_state_and_says_why(image, target_build, fault, tmp_path):
    statement, causes = FAULTS[fault]
    if not IMAGES[image].is_arm:
        statement = statement.replace("0x90000000u", "0x00200000u").replace("udf #0", "unimp")
    elf = planted(image, tmp_path, statement)
    text, answer = run(
        image, elf, tmp_path, lambda t: re.search("#panic: .*\r", t) is not None, monitor=show_drive_enable(image)
    )
    frames, cause = text.split("\r#panic: ")
    assert cause.removesuffix("\r") in causes
    ticks = ticks_us(frames)
    # the panic does not wait for the transmission, so the last line may be cut short
    assert ticks[-1] in (49000, 50000) and ticks[0] == 1000
    assert drives_enabled(image, answer) in (False, None)


PORT_FAULTS = """
    interrupts_off(); /* nothing leaves the transmit ring */
    for (int i = 0; i < 200; i++) { (void)hal_can_send(&frame); }
    interrupts_on();
    spin(2000000ul);
    (void)hal_wait_tick(&now_us);
    hal_watchdog_feed();
    port_status_t s;
    hal_port_status(&s);
    const uint16_t counts[] = {s.refused_frames, s.lost_frames, s.missed_ticks, s.longest_tick_us, s.bus_off};
    can_frame_t report = {.id = 0x124, .length = 12, .fd = true};
    for (int i = 0; i < 5; i++) {
        report.data[2 * i] = (uint8_t)counts[i];
        report.data[2 * i + 1] = (uint8_t)(counts[i] >> 8);
    }
    for (int i = 0; i < 5; i++) { (void)hal_wait_tick(&now_us); hal_watchdog_feed(); }
    (void)hal_can_send(&report)"""


def test_the_port_counts_its_faults(image, target_build, tmp_path):
    """The port counts the faults of a tick in which the program sends 200 frames and takes 8 ms, and two malformed
    lines that it receives."""
    elf = planted(image, tmp_path, PORT_FAULTS)
    text, _ = run(
        image, elf, tmp_path, lambda t: re.search("b1249.*\r", t) is not None, b"garbage\rb2019" + b"0" * 5 + b"\r"
    )
    assert "#panic" not in text
    data = bytes.fromhex(re.search("b1249([0-9A-F]{24})\r", text)[1])
    refused, lost, missed, longest_us, bus_off = struct.unpack("<5H", data[:10])
    ticks = ticks_us(text)
    assert ticks.count(50000) == 1 + 200 - refused  # one of them is sent by the loop itself
    assert refused in (127, 128)  # 1,023 bytes hold 73 lines of 14 bytes, one of which may be the loop's own
    assert lost == 2
    resumed = 50000 + 1000 * (missed + 1)
    assert resumed in (57000, 58000, 59000) and 8000 <= longest_us < 9500
    assert bus_off == 65535  # unknown to this port


def test_ticks_missed_are_not_made_up_for(image, target_build, tmp_path):
    """Missed ticks are skipped when the firmware takes 8 ms, which the watchdog, set to 10 ms, allows."""
    text, _ = run(image, planted(image, tmp_path, busy(8)), tmp_path, lambda t: t.count("\r") > 80)
    assert "#panic" not in text
    ticks = ticks_us(text)
    resumed = ticks[ticks.index(50000) + 1]
    assert resumed in (57000, 58000, 59000)
    assert ticks == [*range(1000, 51000, 1000), *range(resumed, ticks[-1] + 1, 1000)]
