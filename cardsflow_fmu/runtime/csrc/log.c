#include "log.h"

void log_status(const struct log *log, enum status status, const char *text)
{
    if (status != STATUS_OK || log->events)
        log->write(log->context, status, text);
}
