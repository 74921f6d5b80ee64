#include "scenario_file.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scenario_sections.h"

#define SUFFIX ".yaml"
#define LIST_MAX 64

static bool is_path(const char *text) {
    const size_t length = strlen(text);
    return strchr(text, '/') != NULL ||
           (length > sizeof SUFFIX - 1 && strcmp(text + length - (sizeof SUFFIX - 1), SUFFIX) == 0);
}

static int by_name(const void *a, const void *b) {
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Lists the names of the files in the folder, without suffix, sorted. The caller must free the names. */
static size_t list_names(const char *folder, char *names[LIST_MAX]) {
    DIR *directory = opendir(folder);
    size_t count = 0;
    const struct dirent *entry;
    while (directory != NULL && count < LIST_MAX && (entry = readdir(directory)) != NULL) {
        const size_t length = strlen(entry->d_name);
        if (length > sizeof SUFFIX - 1 && is_path(entry->d_name)) {
            names[count] = strndup(entry->d_name, length - (sizeof SUFFIX - 1));
            count += names[count] != NULL;
        }
    }
    if (directory != NULL) {
        (void)closedir(directory);
    }
    qsort(names, count, sizeof names[0], by_name);
    return count;
}

static void refuse_name(const char *name, const char *folder, char error[], size_t error_size) {
    char *names[LIST_MAX];
    const size_t count = list_names(folder, names);
    (void)snprintf(error, error_size, "--scenario '%.200s': expected the path of a file, or one of", name);
    for (size_t i = 0; i < count; i++) {
        const size_t used = strlen(error);
        (void)snprintf(error + used, error_size - used, "%s %s", i > 0 ? "," : "", names[i]);
        free(names[i]);
    }
}

static bool find_file(const char *name_or_path, const char *folder, char path[SCENARIO_PATH_BYTES], char error[],
                      size_t error_size) {
    const bool is_given = is_path(name_or_path);
    const int length = is_given ? snprintf(path, SCENARIO_PATH_BYTES, "%s", name_or_path)
                                : snprintf(path, SCENARIO_PATH_BYTES, "%s/%s" SUFFIX, folder, name_or_path);
    const bool is_whole = length > 0 && length < SCENARIO_PATH_BYTES;
    if (is_given && !is_whole) {
        (void)snprintf(error, error_size, "--scenario '%.200s...': expected a path of at most %d bytes", name_or_path,
                       SCENARIO_PATH_BYTES - 1);
        return false;
    }
    if (is_given || (is_whole && access(path, F_OK) == 0)) {
        return true; /* if the file cannot be opened, yaml_reader_open() reports an error */
    }
    refuse_name(name_or_path, folder, error, error_size);
    return false;
}

static void read_head(yaml_reader_t *yaml, scenario_t *self) {
    static const char *const keys[] = {"name",     "summary",   "duration_s", "arm",     "parameters",
                                       "tasks",    "robot",     "water",      "objects", "people",
                                       "operator", "variation", "tracking",   "checks",  NULL};
    yaml_node_t *root = yaml_root(yaml);
    yaml_check_keys(yaml, root, keys);
    (void)yaml_need(yaml, root, "name");
    yaml_get_name(yaml, root, "name", self->name, sizeof self->name);
    yaml_get_text(yaml, root, "summary", self->summary, sizeof self->summary);
    self->duration_s = 60.0;
    yaml_get_number(yaml, root, "duration_s", 2.0, LONG_S, &self->duration_s);
}

static void read_variation(yaml_reader_t *yaml, scenario_t *self) {
    static const char *const keys[] = {"start_m", "move_m", "object_m", "duration_percent", NULL};
    yaml_node_t *map = yaml_find(yaml, yaml_root(yaml), "variation");
    yaml_check_keys(yaml, map, keys);
    yaml_get_number(yaml, map, "start_m", 0.0, 0.2, &self->variation.start_m);
    yaml_get_number(yaml, map, "move_m", 0.0, 0.2, &self->variation.move_m);
    yaml_get_vector(yaml, map, "object_m", 3, 0.0, 0.2, self->variation.object_m);
    yaml_get_number(yaml, map, "duration_percent", 0.0, 50.0, &self->variation.duration_percent);
}

static void read_tracking(yaml_reader_t *yaml, scenario_t *self) {
    static const char *const keys[] = {"rms_limit_mm", "max_limit_mm", "followable_min_percent", NULL};
    yaml_node_t *map = yaml_find(yaml, yaml_root(yaml), "tracking");
    yaml_check_keys(yaml, map, keys);
    yaml_get_number(yaml, map, "rms_limit_mm", 0.0, 1000.0, &self->tracking_rms_limit_mm);
    yaml_get_number(yaml, map, "max_limit_mm", 0.0, 1000.0, &self->tracking_max_limit_mm);
    yaml_get_number(yaml, map, "followable_min_percent", 0.0, 100.0, &self->followable_min_percent);
}

/* Reads all sections. The names come first, because other sections may refer to them. */
static void read_sections(yaml_reader_t *yaml, scenario_t *self) {
    read_head(yaml, self);
    read_variation(yaml, self);
    read_tracking(yaml, self);
    scenario_read_names(yaml, self);
    scenario_read_robot(yaml, self);
    scenario_read_tasks(yaml, self);
    scenario_read_objects(yaml, self);
    scenario_read_people(yaml, self);
    scenario_read_operator(yaml, self);
    scenario_read_checks(yaml, self);
}

bool scenario_load(scenario_t *self, const char *name_or_path, const char *folder, char error[], size_t error_size) {
    memset(self, 0, sizeof *self);
    events_init(&self->events);
    if (!find_file(name_or_path, folder, self->path, error, error_size)) {
        return false;
    }
    yaml_reader_t yaml;
    if (yaml_reader_open(&yaml, self->path, error, error_size)) {
        read_sections(&yaml, self);
    }
    yaml_reader_close(&yaml);
    return !yaml.failed;
}

bool scenario_list(const char *folder, scenario_visitor_t *visit, void *context, char error[], size_t error_size) {
    char *names[LIST_MAX];
    const size_t count = list_names(folder, names);
    bool good = count > 0;
    if (!good) {
        (void)snprintf(error, error_size, "%.300s: expected scenario files (*.yaml) in this folder", folder);
    }
    for (size_t i = 0; i < count; i++) {
        static scenario_t scenario;
        good = good && scenario_load(&scenario, names[i], folder, error, error_size);
        if (good) {
            visit(context, names[i], scenario.summary);
        }
        free(names[i]);
    }
    return good;
}
