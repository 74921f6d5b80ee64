/* Fujitsu HOAP-3, right arm: shoulder pitch, shoulder roll, shoulder torsion, elbow. */
/* Made by `make arms` from hoap3_right.toml: edit that. */
#ifndef COMANIP_CONTROL_ARMS_HOAP3_RIGHT_IK_H
#define COMANIP_CONTROL_ARMS_HOAP3_RIGHT_IK_H

#include "../arm_ik.h"

extern const arm_ik_t arm_ik_hoap3_right;

#endif
