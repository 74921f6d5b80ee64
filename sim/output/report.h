/* Writes the results of a run: summary.json, and the table on the terminal. */
#ifndef COMANIP_SIM_REPORT_H
#define COMANIP_SIM_REPORT_H

#include "checks.h"

/* Returns false on failure, with one line in `error`. */
bool report_write_summary(const world_t *world, const checks_t *checks, double wall_s, const char *path, char error[],
                          size_t error_size);

void report_print_table(const world_t *world, const checks_t *checks, double wall_s);

/* Returns PASS or FAIL, in colour on a terminal unless NO_COLOR is set. */
const char *report_verdict(bool pass);

/* Prints the progress: on a terminal, one line that is overwritten; otherwise, a few lines per run. Called once per
 * tick. */
void report_progress(const world_t *world);

/* Ends the progress line if the run ended early. */
void report_end_progress(const world_t *world);

#endif
