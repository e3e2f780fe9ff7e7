/* Where an instance reports to, whatever the version of FMI. */
#ifndef LOG_H
#define LOG_H

#include <stddef.h>

/* The numbers are those of FMI 2 and FMI 3. A message with STATUS_OK reports an event. */
enum status { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR };

typedef void log_writer(void *context, enum status status, const char *text);

struct log {
    log_writer *write;
    void *context;
    int events; /* whether events are reported; anything worse always is */
};

void log_status(const struct log *log, enum status status, const char *text);

/* The log category of messages with a status. */
const char *log_category(enum status status);

/* Whether `categories` (all, when there are none) ask for events; -1 when one of them is unknown. */
int log_asks_for_events(size_t count, const char *const categories[]);

#endif
