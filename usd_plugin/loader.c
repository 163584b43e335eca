/* The plugin of the Python package, as OpenUSD loads it. It loads the format beside it, which has OpenUSD's symbols undefined.

   The libraries of usd-core have other names in the wheel of each version of Python, so the format cannot name them, and Python
   loads them so that only those who do may use them. They are made visible first. */

#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <limits.h>
#include <link.h>
#include <stdio.h>
#include <string.h>

#define FORMAT "libusdTailorFormat.so"
#define PREFIX "libusd_"

/* The modules that the format uses. Since usd-core 25.8, `ms` holds all of them. */
static const char *const modules[] = {"ms", "tf", "vt", "ar", "sdf", "pcp", "usd"};

/* Keeps the folder of the first library of OpenUSD. */
static int find_folder(struct dl_phdr_info *info, size_t size, void *folder)
{
    const char *name = strrchr(info->dlpi_name, '/');
    const size_t length = name ? (size_t)(name - info->dlpi_name) : 0;
    (void)size;
    if (length == 0 || length >= PATH_MAX || strncmp(name + 1, PREFIX, strlen(PREFIX)) != 0) {
        return 0;
    }
    memcpy(folder, info->dlpi_name, length);
    ((char *)folder)[length] = '\0';
    return 1;
}

static void make_visible(const char *folder, const char *module)
{
    char start[64], path[PATH_MAX + 300];
    DIR *entries = opendir(folder);
    struct dirent *entry;
    snprintf(start, sizeof start, PREFIX "%s-", module);
    while (entries && (entry = readdir(entries))) {
        if (strncmp(entry->d_name, start, strlen(start)) == 0) {
            snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
            dlopen(path, RTLD_NOW | RTLD_GLOBAL);
        }
    }
    if (entries) {
        closedir(entries);
    }
}

__attribute__((constructor)) static void load(void)
{
    char folder[PATH_MAX], path[PATH_MAX + 64];
    Dl_info self;
    if (dl_iterate_phdr(find_folder, folder)) {
        for (size_t i = 0; i < sizeof modules / sizeof *modules; ++i) {
            make_visible(folder, modules[i]);
        }
    }
    const char *name = dladdr((void *)load, &self) ? strrchr(self.dli_fname, '/') : NULL;
    if (!name || strlen(self.dli_fname) >= PATH_MAX) {
        fprintf(stderr, "usd-tailor: the folder of the plugin cannot be found\n");
        return;
    }
    snprintf(path, sizeof path, "%.*s" FORMAT, (int)(name + 1 - self.dli_fname), self.dli_fname);
    if (!dlopen(path, RTLD_NOW)) {
        fprintf(stderr, "usd-tailor: the file format .tailor cannot be loaded: %s\n", dlerror());
    }
}
