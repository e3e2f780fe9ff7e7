#include "backend.h"

#include "python_in_process.h"

/* Backends are tried from the fastest on; the host's own Python is the only one so far. */
int backend_open(struct model *model, const struct port_table *ports, const char *resources,
                 struct text *error)
{
    return python_in_process_open(model, ports, resources, error);
}
