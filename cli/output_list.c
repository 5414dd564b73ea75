// SPDX-License-Identifier: Apache-2.0
// The files that a command writes: each of them once, whatever it is called.
#include "cli/cli.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char *last_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

// What the system knows of the folder that path lies in; false: there is none, or no memory.
static bool look_at_folder(const char *path, struct stat *out)
{
    size_t bytes = (size_t)(last_name(path) - path);
    char *folder = malloc(bytes + 2);
    if (!folder) return false;
    memcpy(folder, path, bytes);
    memcpy(folder + bytes, ".", 2); // "a/." and "." are folders
    bool there = stat(folder, out) == 0;
    free(folder);
    return there;
}

// What is there already is one file where the system says so; else equal names in one folder are.
static bool same_file(const char *a, const char *b)
{
    struct stat one, other;
    if (strcmp(a, b) == 0) return true;
    bool both = stat(a, &one) == 0 && stat(b, &other) == 0;
    if (!both && strcmp(last_name(a), last_name(b)) != 0) return false;
    if (!both && !(look_at_folder(a, &one) && look_at_folder(b, &other))) return false;
    return one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

bool cli_take_output(const char *name, const char **outputs, int *n, int most, const char *path)
{
    if (*n >= most) {
        cli_error("%s: more than %d outputs", name, most);
        return false;
    }
    for (int i = 0; i < *n; i++) {
        if (!same_file(outputs[i], path)) continue;
        if (strcmp(outputs[i], path) == 0)
            cli_error("%s: '%s' is given twice", name, path);
        else
            cli_error("%s: '%s' is given twice, once as '%s'", name, path, outputs[i]);
        return false;
    }
    outputs[(*n)++] = path;
    return true;
}
