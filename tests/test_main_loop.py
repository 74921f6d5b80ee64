"""The loop in firmware/main.c, compiled with a HAL defined here, loses no frames that arrive between two ticks."""

from __future__ import annotations

import ctypes
import subprocess

import pytest
from simulation import REPOSITORY

PLACES = 15  # capacity of the smallest receive queue, see hal/slcan/slcan_link.h
# A tick of classic CAN lasts 4 ms. In every tenth tick, FRAMES_A_MS frames arrive in each of three milliseconds. These
# 18 frames are more than the queue holds, but fewer than queue and inbox hold together.
FRAMES_A_MS = 6

HAL = """
#include "firmware/main.h"
#include "hal/hal.h"
static int waiting, ms;
int lost, taken;
void hal_init(void) {}
can_profile_t hal_can_profile(void) { return CAN_PROFILE_CLASSIC; }
bool hal_can_send(const can_frame_t *frame) { (void)frame; return true; }
bool hal_can_receive(can_frame_t *frame) {
    if (waiting == 0) { return false; }
    waiting--, taken++;
    *frame = (can_frame_t){.id = 0x7FF, .length = 8};
    return true;
}
bool hal_wait_tick(uint32_t *now_us) {
    for (int i = 0; ms % 40 >= 1 && ms % 40 <= 3 && i < FRAMES_A_MS; i++) {
        if (waiting < PLACES) { waiting++; } else { lost++; }
    }
    *now_us = 1000u * (uint32_t)++ms;
    return ms <= 400;
}
void hal_port_status(port_status_t *status) { *status = (port_status_t)PORT_STATUS_UNKNOWN; }
void hal_watchdog_feed(void) {}
void hal_enable_drives(bool enable) { (void)enable; }
_Noreturn void hal_panic(const char *cause) { (void)cause; __builtin_trap(); }
bool hal_store_read(void *record, size_t size, size_t *length) { (void)record, (void)size, (void)length; return false; }
void hal_store_write(const void *record, size_t length) { (void)record, (void)length; }
hal_store_status_t hal_store_status(void) { return HAL_STORE_NONE; }
"""


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    folder = tmp_path_factory.mktemp("main_loop")
    (folder / "hal.c").write_text(HAL)
    sources = [
        *REPOSITORY.glob("firmware/**/*.c"),
        REPOSITORY / "build/generated/comanip_dbc.c",
    ]
    flags = ["-std=c11", "-O1", "-fPIC", "-shared", f"-I{REPOSITORY}", f"-I{REPOSITORY}/build/generated",
             f"-DPLACES={PLACES}", f"-DFRAMES_A_MS={FRAMES_A_MS}"]  # fmt: skip
    subprocess.run(["gcc", *flags, *sources, folder / "hal.c", "-lm", "-o", folder / "loop.so"], check=True)
    return ctypes.CDLL(folder / "loop.so")


def test_frames_between_the_ticks_of_classic_can_are_read_as_they_arrive(loop):
    """No frame is lost if eight drives, the tracker and an operator who defines a task send all they can in one
    tick."""
    loop.firmware_main()
    assert ctypes.c_int.in_dll(loop, "lost").value == 0
    assert ctypes.c_int.in_dll(loop, "taken").value == 10 * 3 * FRAMES_A_MS
