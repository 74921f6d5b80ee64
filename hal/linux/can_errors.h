/* CAN error frames, as the kernel's drivers make them (linux/can/error.h): told on stderr and counted. */
#ifndef COMANIP_CAN_ERRORS_H
#define COMANIP_CAN_ERRORS_H

#include <linux/can.h>

#include "can_counters.h"

/* error: a frame with CAN_ERR_FLAG. Bus-off, restart and error-passive are told each time, other classes are counted.
 * program, bus: their names. */
void can_errors_tell(const char *program, const char *bus, const struct canfd_frame *error, can_counters_t *counters);

#endif
