/* comanip-firmware: the firmware as a Linux process on a CAN bus. */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../firmware/main.h"
#include "port.h"
#include "run_options.h"

#define EXIT_WRONG_USE 2
#define ERROR_BYTES 512

static const char usage[] =
    "comanip-firmware: runs the firmware as a separate process on a CAN bus\n"
    "\n"
    "usage: build/linux/comanip-firmware --can NAME [--profile fd|classic] [--slow N] [--parameters FILE]\n"
    "       make run-firmware CAN=NAME PARAMETERS=FILE\n"
    "\n"
    "  --can NAME   the kernel's CAN interface of this name, for example can0 or vcan0; if there is none, the hub of "
    "this name\n"
    "  --profile P  fd: CAN FD, control at 1 kHz (default); classic: classic CAN, control at 250 Hz. The plant needs "
    "the same\n"
    "  --slow N     time scale: a tick lasts N ms while the firmware's clock advances by 1 ms, 1 (default) to 1000; "
    "the\n"
    "               plant needs the same\n"
    "  --parameters FILE  file in which `comanip param save` saves the parameters, and from which they are read at the "
    "start;\n"
    "               without this option, the parameters have their defaults and cannot be saved\n"
    "  -h, --help   this text\n"
    "\n"
    "The program ends on SIGINT or SIGTERM. Exit status: 0 after such a signal; 1 after a panic; 2 for wrong usage,\n"
    "or if the bus or FILE cannot be opened\n";

/* Prints one line without control characters, because a terminal must not interpret escape sequences from the command
 * line. */
static int complain(const char *error) {
    (void)fputs("comanip-firmware: ", stderr);
    for (const char *character = error; *character != '\0'; character++) {
        (void)fputc(iscntrl((unsigned char)*character) ? '?' : *character, stderr);
    }
    (void)fputc('\n', stderr);
    return EXIT_WRONG_USE;
}

int main(int argc, char *argv[]) {
    char error[ERROR_BYTES];
    run_options_t options;
    can_profile_t profile = CAN_PROFILE_FD;
    if (!run_options_take(&options, &argc, argv, error, sizeof error) ||
        !run_options_take_profile(&profile, &argc, argv, error, sizeof error)) {
        return complain(error);
    }
    const char *parameters = NULL;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            (void)fputs(usage, stdout);
            return EXIT_SUCCESS;
        }
        if (!run_options_is("--parameters", argc, argv, &i, &parameters)) {
            (void)snprintf(error, sizeof error, "'%.100s': no such option; --help lists them", argv[i]);
            return complain(error);
        }
        if (parameters == NULL || parameters[0] == '\0') {
            return complain("--parameters '': expected the name of a file");
        }
    }
    if (options.can == NULL) {
        return complain("expected --can NAME, for example --can vcan0; see --help");
    }
    if (!port_open(options.can, profile, options.slow, parameters, error, sizeof error)) {
        return complain(error);
    }
    firmware_main();
    port_close();
    return EXIT_SUCCESS;
}
