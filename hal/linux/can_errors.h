/* Reports the CAN error frames of the kernel's drivers (linux/can/error.h) on stderr, and counts them. */
#ifndef COMANIP_CAN_ERRORS_H
#define COMANIP_CAN_ERRORS_H

#include <linux/can.h>

#include "can_counters.h"

/* error: a frame with CAN_ERR_FLAG. Bus-off, restart, error-passive and overflow are reported each time; other classes
 * are only counted. program, bus: their names, for the report. */
void can_errors_report(const char *program, const char *bus, const struct canfd_frame *error, can_counters_t *counters);

#endif
