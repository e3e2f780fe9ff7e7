#include "environment.h"

#include <math.h>
#include <stdlib.h>

#ifdef _WIN32
#include "../platform/wide.h"

char *environment_get(const char *name)
{
    wchar_t *wide = wide_from_utf8(name);
    const wchar_t *value = wide ? _wgetenv(wide) : NULL;
    free(wide);
    return value && *value ? utf8_from_wide(value) : NULL;
}
#else
#include "../platform/text.h"

char *environment_get(const char *name)
{
    const char *value = getenv(name);
    return value && *value ? text_copy(value) : NULL;
}
#endif

double environment_get_positive(const char *name, double otherwise)
{
    char *value = environment_get(name);
    double number = value ? strtod(value, NULL) : 0;
    free(value);
    return isfinite(number) && number > 0 ? number : otherwise;
}
