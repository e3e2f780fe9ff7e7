#include "interpreters.h"

#include "../platform/read_file.h"
#include "../platform/text.h"
#include "environment.h"

#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
static const char IN_ENVIRONMENT[] = "Scripts/python.exe", ON_PATH[] = "python";
#else
static const char IN_ENVIRONMENT[] = "bin/python", ON_PATH[] = "python3";
#endif

/* Return the first line of resources/python.txt, on the heap; NULL if it does not exist. */
static char *recorded_python(const char *resources)
{
    size_t size = 0;
    char *line = (char *)read_file(resources, "python.txt", &size);
    if (!line)
        return NULL;
    line[strcspn(line, "\r\n")] = '\0';
    if (*line)
        return line;
    free(line);
    return NULL;
}

static char *virtual_environment_python(void)
{
    struct text path = {NULL};
    char *folder = environment_get("VIRTUAL_ENV");
    if (folder)
        text_set(&path, "%s/%s", folder, IN_ENVIRONMENT);
    free(folder);
    return path.chars;
}

static size_t add(struct interpreter list[], size_t count, const char *source, char *program)
{
    if (!program)
        return count;
    list[count].source = source;
    list[count].program = program;
    return count + 1;
}

size_t interpreters_find(const char *resources, struct interpreter list[MAX_INTERPRETERS])
{
    size_t count = add(list, 0, "CARDSFLOW_PYTHON", environment_get("CARDSFLOW_PYTHON"));
    if (count)
        return count;
    count = add(list, count, "recorded in the FMU", recorded_python(resources));
    count = add(list, count, "VIRTUAL_ENV", virtual_environment_python());
    return add(list, count, "on the path", text_copy(ON_PATH));
}

void interpreters_free(struct interpreter list[], size_t count)
{
    for (size_t i = 0; i < count; i++)
        free(list[i].program);
}
