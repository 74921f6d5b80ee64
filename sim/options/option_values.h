/* Parses values from the command line. The whole string must be valid, and numbers must be finite. */
#ifndef COMANIP_SIM_OPTION_VALUES_H
#define COMANIP_SIM_OPTION_VALUES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../../firmware/protocol/can_protocol.h"

bool option_number(const char *text, double minimum, double maximum, double *value);
bool option_unsigned(const char *text, uint64_t maximum, uint64_t *value);

/* Parses `count` numbers separated by `separator`. */
bool option_numbers(const char *text, char separator, double minimum, double maximum, size_t count, double value[]);

/* Parses FORM:TX,TY,TZ:QW,QX,QY,QZ:IW,IX,IY,IZ:BLEND within the ranges of a TaskDefine message. */
bool option_task(const char *text, task_define_t *task);

#endif
