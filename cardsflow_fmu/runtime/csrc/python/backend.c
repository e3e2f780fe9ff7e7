#include "../model/backend.h"

#include "../native/file.h"
#include "../native/open.h"
#include "environment.h"
#include "in_process.h"
#include "worker/client.h"

#include <stdlib.h>
#include <string.h>

static int open_in_process(struct model *model, const struct port_table *ports,
                           const char *resources, struct text *error)
{
    struct python_memory memory = {NULL, ports->count};
    return python_in_process_open(model, ports->package_version, &memory, resources, error);
}

static int open_suitable(struct model *model, const struct port_table *ports,
                         const char *resources, struct text *error)
{
    struct text why = {NULL};
    int fits = python_in_process_fits(ports->package_version, &why);
    text_free(&why);
    return (fits ? open_in_process : python_worker_open)(model, ports, resources, error);
}

int backend_open(struct model *model, const struct port_table *ports, const char *resources,
                 struct text *error)
{
    int failed = 1;
    if (native_file_exists(resources))
        return native_open(model, ports, resources, error);
    char *host = environment_get("CARDSFLOW_FMU_HOST");
    if (!host)
        failed = open_suitable(model, ports, resources, error);
    else if (strcmp(host, "in-process") == 0)
        failed = open_in_process(model, ports, resources, error);
    else if (strcmp(host, "worker") == 0)
        failed = python_worker_open(model, ports, resources, error);
    else
        text_set(error, "CARDSFLOW_FMU_HOST must be in-process or worker, not %s", host);
    free(host);
    return failed;
}
