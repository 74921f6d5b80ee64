/* The files of a run: written under temporary names, and given their own in the end, so that nothing half-written
 * passes for a result. */
#ifndef COMANIP_SIM_OUTPUT_FOLDER_H
#define COMANIP_SIM_OUTPUT_FOLDER_H

#include <stdbool.h>
#include <stddef.h>

typedef enum { OUTPUT_SUMMARY, OUTPUT_BUS_LOG, OUTPUT_TRACE, OUTPUT_COUNT } output_file_t;

typedef struct {
    char *path[OUTPUT_COUNT];
    char *partial_path[OUTPUT_COUNT]; /* where to write */
    int lock;                         /* the open folder, locked against other runs; -1: none */
} output_folder_t;

/* Creates the folder and its parents, locks it and removes a former run's files, and what was drawn from them: *.png
 * and *.md in its folder report/. On failure, another run in the same folder included, false, and one line in
 * `error`. */
bool output_folder_open(output_folder_t *self, const char *folder, char error[], size_t error_size);

/* Gives the files their names. */
bool output_folder_commit(output_folder_t *self, char error[], size_t error_size);

/* Removes what was not committed. */
void output_folder_free(output_folder_t *self);

#endif
