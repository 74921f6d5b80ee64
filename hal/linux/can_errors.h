/* CAN error frames, as the kernel's drivers make them (linux/can/error.h): told on stderr and counted. */
#ifndef COMANIP_CAN_ERRORS_H
#define COMANIP_CAN_ERRORS_H

#include <linux/can.h>

#include "can_socket.h"

/* error: a frame with CAN_ERR_FLAG. Bus-off, restart and error-passive are told each time, other classes are counted.
 */
void can_errors_tell(can_socket_t *socket, const struct canfd_frame *error);

#endif
