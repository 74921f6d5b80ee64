/* What a run leaves behind: summary.json and the table on the terminal. */
#ifndef COMANIP_SIM_REPORT_H
#define COMANIP_SIM_REPORT_H

#include "checks.h"

/* On failure false, and one line in `error`. */
bool report_write_summary(const world_t *world, const checks_t *checks, double wall_s, const char *path, char error[],
                          size_t error_size);

void report_print_table(const world_t *world, const checks_t *checks, double wall_s);

/* PASS or FAIL, in colour on a terminal unless NO_COLOR is set. */
const char *report_verdict(bool pass);

/* How far the run is: a line that is overwritten on a terminal, a line now and then elsewhere. Call once per tick. */
void report_progress(const world_t *world);

/* Ends that line, if the run ended before it. */
void report_end_progress(const world_t *world);

#endif
