/* The function of the CAN driver that the rest of the port calls. */
#ifndef COMANIP_SKELETON_CAN_H
#define COMANIP_SKELETON_CAN_H

void can_start(void);

#endif
