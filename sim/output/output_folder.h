/* The output files of a run. They are written under temporary names and renamed at the end, so that an incomplete file
 * is never taken for a result. */
#ifndef COMANIP_SIM_OUTPUT_FOLDER_H
#define COMANIP_SIM_OUTPUT_FOLDER_H

#include <stdbool.h>
#include <stddef.h>

typedef enum { OUTPUT_SUMMARY, OUTPUT_BUS_LOG, OUTPUT_TRACE, OUTPUT_COUNT } output_file_t;

typedef struct {
    char *path[OUTPUT_COUNT];
    char *partial_path[OUTPUT_COUNT]; /* temporary names */
    int lock;                         /* file descriptor of the folder, locked against other runs; -1: no lock */
} output_folder_t;

/* Creates the folder and its parents, locks it, and removes the files and plots (*.png in report/) of an earlier run.
 * Returns false, with one line in `error`, on failure or if another run uses the folder. */
bool output_folder_open(output_folder_t *self, const char *folder, char error[], size_t error_size);

/* Renames the files to their final names. */
bool output_folder_commit(output_folder_t *self, char error[], size_t error_size);

/* Removes files that were not committed, and unlocks the folder. */
void output_folder_free(output_folder_t *self);

#endif
