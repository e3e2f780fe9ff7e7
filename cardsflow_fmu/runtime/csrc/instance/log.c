#include "log.h"

#include <string.h>

/* By status. */
static const char *const CATEGORIES[] = {"logEvents", "logStatusWarning", "logStatusDiscard",
                                         "logStatusError"};

void log_status(const struct log *log, enum status status, const char *text)
{
    if (status != STATUS_OK || log->events)
        log->write(log->context, status, text);
}

const char *log_category(enum status status)
{
    return CATEGORIES[status];
}

static int is_known(const char *category)
{
    for (size_t i = 0; i < sizeof CATEGORIES / sizeof *CATEGORIES; i++)
        if (strcmp(category, CATEGORIES[i]) == 0)
            return 1;
    return strcmp(category, "logAll") == 0;
}

int log_asks_for_events(size_t count, const char *const categories[])
{
    int asked = count == 0;
    for (size_t i = 0; i < count; i++) {
        if (!categories[i] || !is_known(categories[i]))
            return -1;
        if (strcmp(categories[i], "logAll") == 0 || strcmp(categories[i], "logEvents") == 0)
            asked = 1;
    }
    return asked;
}
