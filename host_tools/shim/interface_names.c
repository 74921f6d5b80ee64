/* Maps the names of hubs to interface indices: see interface_names.h. */
#include "interface_names.h"

#include <dirent.h>
#include <errno.h>
#include <net/if.h>
#include <pthread.h>
#include <string.h>
#include <sys/stat.h>

#include "../../hal/linux/hub_path.h"

#define FIRST_INDEX 0x40000000u /* far above the kernel's indices, which count from 1 */
#define INTERFACES_MAX 32
#define ERROR_BYTES 512

static char known[INTERFACES_MAX][IFNAMSIZ];
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;

static bool hub_exists(const char *name) {
    char folder[HUB_PATH_BYTES], path[HUB_PATH_BYTES], error[ERROR_BYTES];
    struct stat status;
    return hub_name_is_valid(name) && hub_folder(folder, error, sizeof error) &&
           hub_path(path, folder, name, "", error, sizeof error) && stat(path, &status) == 0 &&
           S_ISSOCK(status.st_mode);
}

unsigned interface_index(const char *name) {
    unsigned index = 0;
    const int cause = errno;
    if (hub_exists(name)) {
        (void)pthread_mutex_lock(&mutex);
        for (unsigned i = 0; i < INTERFACES_MAX && index == 0; i++) {
            if (known[i][0] == '\0') {
                (void)strncpy(known[i], name, IFNAMSIZ - 1);
            }
            index = strcmp(known[i], name) == 0 ? FIRST_INDEX + i : 0;
        }
        (void)pthread_mutex_unlock(&mutex);
    }
    errno = cause;
    return index;
}

const char *interface_name(unsigned index) {
    const bool is_known = index >= FIRST_INDEX && index < FIRST_INDEX + INTERFACES_MAX;
    return is_known && known[index - FIRST_INDEX][0] != '\0' ? known[index - FIRST_INDEX] : NULL;
}

unsigned interface_only(void) {
    char folder[HUB_PATH_BYTES], error[ERROR_BYTES];
    DIR *entries = hub_folder(folder, error, sizeof error) ? opendir(folder) : NULL;
    unsigned only = 0;
    int count = 0;
    for (struct dirent *entry; entries != NULL && (entry = readdir(entries)) != NULL;) {
        const unsigned index = interface_index(entry->d_name);
        count += index != 0;
        only = index != 0 ? index : only;
    }
    if (entries != NULL) {
        (void)closedir(entries);
    }
    return count == 1 ? only : 0;
}
