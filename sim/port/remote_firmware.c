#include "remote_firmware.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "../../firmware/protocol/can_transport.h"
#include "../../hal/lockstep/lockstep.h"
#include "../../hal/slcan/slcan.h"
#include "firmware_node.h"

#define ANSWER_TIMEOUT_MS 60000
#define READ_BYTES 4096
#define LINE_BYTES 256
#define PANIC "#panic: "

static struct {
    int fd;
    world_t *world;
    firmware_node_t node;
    uint16_t ids[TRANSPORT_MAX_IDS]; /* ids that the firmware receives */
    uint8_t id_count;
    slcan_decoder_t decoder;
    char line[LINE_BYTES]; /* the line being received, to detect a panic message */
    size_t line_bytes;
} remote = {.fd = -1};

bool remote_firmware_open(const char *path, char error[], size_t error_size) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path) {
        (void)snprintf(error, error_size, "%.100s: expected a path of fewer than %zu bytes", path,
                       sizeof address.sun_path);
        return false;
    }
    memcpy(address.sun_path, path, strlen(path));
    remote.fd = socket(AF_UNIX, SOCK_STREAM, 0);
    if (remote.fd < 0 || connect(remote.fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        (void)snprintf(error, error_size, "%.100s: cannot connect to the serial line: %s", path, strerror(errno));
        return false;
    }
    return true;
}

static bool is_for_firmware(const can_frame_t *frame) {
    for (uint8_t i = 0; i < remote.id_count; i++) {
        if (remote.ids[i] == frame->id) {
            return true;
        }
    }
    return false;
}

static bool send_line(const can_frame_t *frame) {
    char line[SLCAN_LINE_MAX_BYTES];
    const size_t bytes = slcan_encode(frame, line);
    for (size_t done = 0; done < bytes;) {
        const ssize_t sent = send(remote.fd, line + done, bytes - done, MSG_NOSIGNAL);
        if (sent <= 0) {
            return false;
        }
        done += (size_t)sent;
    }
    return true;
}

static bool send_number(uint16_t id, uint32_t number) {
    const can_frame_t frame = lockstep_frame(id, number);
    return send_line(&frame);
}

/* The serial line is slow, so it carries only frames that the firmware receives. */
static bool send_tick(uint32_t now_us) {
    bool is_sent = send_number(LOCKSTEP_REFUSED_ID, remote.node.refused_frames) &&
                   send_number(LOCKSTEP_LOST_ID, (uint32_t)remote.node.world->firmware_overflows);
    can_frame_t frame;
    while (firmware_node_receive(&remote.node, &frame)) {
        if (is_for_firmware(&frame)) {
            is_sent = is_sent && send_number(LOCKSTEP_STAMP_ID, frame.timestamp_us) && send_line(&frame);
        }
    }
    return is_sent && send_number(LOCKSTEP_TICK_ID, now_us);
}

static void note_line(char byte) {
    if (byte == '\r') {
        remote.line[remote.line_bytes] = '\0';
        remote.line_bytes = 0;
        if (strncmp(remote.line, PANIC, strlen(PANIC)) == 0) {
            char text[WORLD_TEXT_BYTES];
            (void)snprintf(text, sizeof text, "firmware panic: %s", remote.line + strlen(PANIC));
            world_fail(remote.world, text);
        }
    } else if (remote.line_bytes < LINE_BYTES - 1) {
        remote.line[remote.line_bytes++] = byte;
    }
}

/* Passes the image's frames to the bus. Returns true when the image has sent all frames of its tick. */
static bool process_bytes(const char bytes[], ssize_t count) {
    bool is_done = false;
    for (ssize_t i = 0; i < count; i++) {
        can_frame_t frame;
        static can_frame_t partial;
        note_line(bytes[i]);
        if (slcan_decode(&remote.decoder, (uint8_t)bytes[i], &partial) != SLCAN_FRAME) {
            continue;
        }
        frame = partial;
        if (frame.id == LOCKSTEP_DONE_ID) {
            is_done = true;
            drive_node_enable(remote.world->drives, lockstep_number(&frame) != 0);
        } else {
            (void)firmware_node_send(&remote.node, &frame);
        }
    }
    return is_done;
}

static bool await_done(void) {
    char bytes[READ_BYTES];
    struct pollfd line = {.fd = remote.fd, .events = POLLIN};
    for (;;) {
        const int ready = poll(&line, 1, ANSWER_TIMEOUT_MS);
        if (ready < 0 && errno == EINTR) {
            return false; /* a signal ends the run */
        }
        if (ready <= 0) {
            world_fail(remote.world, "the firmware image did not answer for 60 s");
            return false;
        }
        const ssize_t count = read(remote.fd, bytes, sizeof bytes);
        if (count <= 0) {
            world_fail(remote.world, "the serial line to the firmware image was closed: has the emulator ended?");
            return false;
        }
        if (process_bytes(bytes, count)) {
            return true;
        }
        if (remote.world->failure[0] != '\0') {
            return false;
        }
    }
}

void remote_firmware_run(world_t *world) {
    remote.world = world;
    firmware_node_attach(&remote.node, world);
    remote.id_count = transport_ids_to_firmware(bus_profile(world->bus), remote.ids);
    bool answers = await_done(); /* true once the image has booted */
    while (world_advance(world) && answers) {
        if (!send_tick((uint32_t)(world->now_ns / 1000)) && errno == EINTR) {
            break; /* a signal ends the run */
        }
        answers = await_done(); /* if the line is closed, this reads the image's last words */
    }
    (void)close(remote.fd);
}
