/* The CAN driver's function used by the rest of the port. */
#ifndef COMANIP_SKELETON_CAN_H
#define COMANIP_SKELETON_CAN_H

void can_start(void);

#endif
