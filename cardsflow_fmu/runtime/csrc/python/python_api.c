#include "python_api.h"

#include <string.h>

typedef void (*function)(void);

#ifdef _WIN32
#include <stdio.h>
#include <windows.h>

/* python3.dll only forwards calls, and is not loaded in every process that runs Python. */
static HMODULE python_module(void)
{
    enum { OLDEST = 11, NEWEST = 99 };
    char name[sizeof "python399.dll"];
    for (int minor = OLDEST; minor <= NEWEST; minor++) {
        snprintf(name, sizeof name, "python3%d.dll", minor);
        HMODULE module = GetModuleHandleA(name);
        if (module)
            return module;
    }
    return NULL;
}

static function find_function(const char *name)
{
    HMODULE module = python_module();
    return module ? (function)GetProcAddress(module, name) : NULL;
}
#else
#include <dlfcn.h>

static function find_function(const char *name)
{
    void *symbol = dlsym(RTLD_DEFAULT, name);
    function address;
    memcpy(&address, &symbol, sizeof address);
    return address;
}
#endif

struct symbol {
    const char *name;
    size_t offset;
};

static const struct symbol SYMBOLS[] = {
#define F(result, name, arguments) {#name, offsetof(struct python_api, name)},
    PYTHON_FUNCTIONS(F)
#undef F
};

int python_api_find(struct python_api *api, struct text *error)
{
    for (size_t i = 0; i < sizeof SYMBOLS / sizeof *SYMBOLS; i++) {
        function address = find_function(SYMBOLS[i].name);
        if (!address) {
            if (i == 0)
                text_set(error, "the host program is not Python");
            else
                text_set(error, "the host's Python has no %s", SYMBOLS[i].name);
            return 1;
        }
        memcpy((char *)api + SYMBOLS[i].offset, &address, sizeof address);
    }
    if (!api->Py_IsInitialized()) {
        text_set(error, "the host program has loaded Python, but does not run it");
        return 1;
    }
    return 0;
}
