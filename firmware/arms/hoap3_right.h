/* Fujitsu HOAP-3, right arm: shoulder pitch, shoulder roll, shoulder torsion, elbow. */
/* Made by `make arms` from hoap3_right.toml: edit that. */
#ifndef COMANIP_ARMS_HOAP3_RIGHT_H
#define COMANIP_ARMS_HOAP3_RIGHT_H

#include "arm.h"

extern const arm_t arm_hoap3_right;

#endif
