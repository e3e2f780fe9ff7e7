/* Log of an instance for any version of FMI. */
#ifndef LOG_H
#define LOG_H

#include <stddef.h>

/* The values are those of FMI 2 and FMI 3. A message with STATUS_OK reports an event. */
enum status { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR };

typedef void log_writer(void *context, enum status status, const char *text);

struct log {
    log_writer *write;
    void *context;
    int events; /* whether events are reported; warnings and errors always are */
};

void log_status(const struct log *log, enum status status, const char *text);

/* Return the log category of messages with a status. */
const char *log_category(enum status status);

/* Return whether `categories` include events (none: all categories); -1 if a category is unknown. */
int log_asks_for_events(size_t count, const char *const categories[]);

#endif
