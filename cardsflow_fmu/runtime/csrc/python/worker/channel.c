#include "channel.h"

#include "../../platform/clock.h"

#include <stdlib.h>
#include <string.h>

enum { BUFFER_SIZE = 1 << 16, CLOCK_SIZE = 2, LINE = 64 };

/* The host writes the first half, the worker the second half; each half has separate cache lines. */
struct channel_block {
    struct {
        uint32_t asked;  /* number of commands */
        uint32_t sleeps; /* whether a ring is needed */
        uint32_t command;
        uint32_t count; /* of values */
        uint64_t size;  /* size of the bytes in the buffer */
        unsigned char rest[LINE - 24];
    } host;
    struct {
        uint32_t answered; /* number of commands */
        uint32_t sleeps;
        uint32_t outcome;
        uint32_t unused;
        uint64_t size;  /* size of the bytes in the buffer */
        uint64_t total; /* size of all bytes of the answer */
        unsigned char rest[LINE - 32];
    } worker;
    unsigned char buffer[BUFFER_SIZE];
    double clock[]; /* then the values */
};

size_t channel_size(size_t count)
{
    return sizeof(struct channel_block) + (CLOCK_SIZE + count) * sizeof(double);
}

void channel_attach(struct channel *channel, const struct shared_memory *memory)
{
    memset(channel, 0, sizeof *channel);
    channel->block = memory->bytes;
}

void channel_clear(struct channel *channel, size_t count)
{
    memset(channel->block, 0, sizeof *channel->block);
    channel->block->host.count = (uint32_t)count;
    channel->patience.usual = 0;
}

double *channel_clock(const struct channel *channel)
{
    return channel->block->clock;
}

size_t channel_count(const struct channel *channel)
{
    return channel->block->host.count;
}

static void clear_bytes(struct channel *channel)
{
    free(channel->bytes.at);
    channel->bytes.at = NULL;
    channel->bytes.size = 0;
}

void channel_free(struct channel *channel)
{
    clear_bytes(channel);
}

/* Append the bytes in the buffer. Return 0, or nonzero if the total size is invalid. */
static int append(struct channel *channel, uint64_t size)
{
    if (size > BUFFER_SIZE)
        return 1;
    if (size == 0)
        return 0;
    unsigned char *grown = realloc(channel->bytes.at, channel->bytes.size + (size_t)size + 1);
    if (!grown)
        return 1;
    memcpy(grown + channel->bytes.size, channel->block->buffer, (size_t)size);
    channel->bytes.at = grown;
    channel->bytes.size += (size_t)size;
    grown[channel->bytes.size] = '\0';
    return 0;
}

/* Publish a new number to the other side, after everything written before. */
static void notify(uint32_t *number, const uint32_t *others_sleep, const struct bell *bell)
{
    __atomic_store_n(number, *number + 1, __ATOMIC_SEQ_CST);
    if (__atomic_load_n(others_sleep, __ATOMIC_SEQ_CST))
        bell_ring(bell);
}

/* Sleep until a ring, unless the number has already the value. */
static enum bell_answer sleep_for(const uint32_t *number, uint32_t value, uint32_t *sleeps,
                                  const struct bell *bell, double seconds)
{
    enum bell_answer answer = BELL_RUNG;
    __atomic_store_n(sleeps, 1, __ATOMIC_SEQ_CST);
    if (__atomic_load_n(number, __ATOMIC_SEQ_CST) != value)
        answer = bell_wait(bell, seconds);
    __atomic_store_n(sleeps, 0, __ATOMIC_SEQ_CST);
    return answer;
}

/* Maximum time asleep, in s; then the process is checked. */
static const double MAX_SLEEP = 0.1;

static int explain(struct process *process, enum bell_answer answer, double longest, double waited,
                   struct text *error)
{
    struct text how = {NULL};
    int failed = 1;
    const double last_moment = 1; /* time between the end of the connection and that of the process */
    if (process_has_ended(process, answer == BELL_GONE ? last_moment : 0, &how))
        text_set(error, "the worker process %s", text_get(&how));
    else if (answer == BELL_GONE)
        text_set(error, "the worker process has closed its connection");
    else if (waited > longest)
        text_set(error, "no answer from the worker process within %.12g s", longest);
    else
        failed = 0;
    text_free(&how);
    return failed;
}

/* Return 0, or nonzero with a message. */
static int wait_for_answer(struct channel *channel, struct process *process, double longest,
                           struct text *error)
{
    struct channel_block *block = channel->block;
    const uint32_t *number = &block->worker.answered;
    uint32_t value = block->host.asked;
    double begin = monotonic_seconds();
    int has_arrived = wait_polling(number, value, &channel->patience);
    while (!has_arrived) {
        enum bell_answer answer = sleep_for(number, value, &block->host.sleeps, &process->bell,
                                            longest < MAX_SLEEP ? longest : MAX_SLEEP);
        has_arrived = __atomic_load_n(number, __ATOMIC_ACQUIRE) == value;
        if (!has_arrived && answer != BELL_RUNG &&
            explain(process, answer, longest, monotonic_seconds() - begin, error))
            return 1;
    }
    patience_learn(&channel->patience, monotonic_seconds() - begin);
    return 0;
}

/* Exchange one command and answer, with bytes that fit into the buffer. */
static int exchange(struct channel *channel, struct process *process, enum command command,
                    const void *bytes, size_t size, double longest, struct text *error)
{
    struct channel_block *block = channel->block;
    block->host.command = (uint32_t)command;
    block->host.size = size;
    if (size)
        memcpy(block->buffer, bytes, size);
    notify(&block->host.asked, &block->worker.sleeps, &process->bell);
    return wait_for_answer(channel, process, longest, error);
}

/* Receive all bytes of an answer. */
static int collect(struct channel *channel, struct process *process, double longest,
                   struct text *error)
{
    uint64_t total = channel->block->worker.total;
    if (total == 0)
        return 0;
    for (;;) {
        uint64_t size = channel->block->worker.size;
        if (size == 0 || size > total - channel->bytes.size || append(channel, size)) {
            text_set(error, "the worker process returned more data than fits into memory");
            return 1;
        }
        if (channel->bytes.size == total)
            return 0;
        if (exchange(channel, process, COMMAND_NEXT, NULL, 0, longest, error))
            return 1;
    }
}

int channel_ask(struct channel *channel, struct process *process, enum command command,
                const void *bytes, size_t size, double longest, enum outcome *outcome,
                struct text *error)
{
    const unsigned char *at = bytes;
    clear_bytes(channel);
    for (; size > BUFFER_SIZE; at += BUFFER_SIZE, size -= BUFFER_SIZE)
        if (exchange(channel, process, COMMAND_PART, at, BUFFER_SIZE, longest, error))
            return 1;
    if (exchange(channel, process, command, at, size, longest, error))
        return 1;
    *outcome = (enum outcome)channel->block->worker.outcome;
    return collect(channel, process, longest, error);
}

void channel_quit(struct channel *channel, struct process *process)
{
    struct channel_block *block = channel->block;
    block->host.command = COMMAND_QUIT;
    block->host.size = 0;
    notify(&block->host.asked, &block->worker.sleeps, &process->bell);
}

static void wait_for_command(struct channel *channel, const struct bell *bell)
{
    struct channel_block *block = channel->block;
    const uint32_t *number = &block->host.asked;
    uint32_t value = block->worker.answered + 1;
    double begin = monotonic_seconds();
    int has_arrived = wait_polling(number, value, &channel->patience);
    while (!has_arrived) {
        const double long_enough = 3600;
        sleep_for(number, value, &block->worker.sleeps, bell, long_enough);
        has_arrived = __atomic_load_n(number, __ATOMIC_ACQUIRE) == value;
    }
    patience_learn(&channel->patience, monotonic_seconds() - begin);
}

static void post(struct channel *channel, const struct bell *bell, enum outcome outcome)
{
    struct channel_block *block = channel->block;
    size_t left = channel->bytes.size - channel->sent;
    size_t size = left < BUFFER_SIZE ? left : BUFFER_SIZE;
    if (size)
        memcpy(block->buffer, channel->bytes.at + channel->sent, size);
    channel->sent += size;
    block->worker.size = size;
    block->worker.total = channel->bytes.size;
    block->worker.outcome = (uint32_t)outcome;
    notify(&block->worker.answered, &block->host.sleeps, bell);
}

/* Confirm a part. */
static void acknowledge(struct channel *channel, const struct bell *bell)
{
    channel->block->worker.size = channel->block->worker.total = 0;
    notify(&channel->block->worker.answered, &channel->block->host.sleeps, bell);
}

enum command channel_next(struct channel *channel, const struct bell *bell)
{
    int failed = 0, is_first = 1;
    for (;;) {
        wait_for_command(channel, bell);
        enum command command = (enum command)channel->block->host.command;
        if (command == COMMAND_NEXT) {
            post(channel, bell, (enum outcome)channel->block->worker.outcome);
            continue;
        }
        if (is_first)
            clear_bytes(channel);
        is_first = 0;
        failed = append(channel, channel->block->host.size) || failed;
        if (command != COMMAND_PART)
            return failed ? COMMAND_QUIT : command;
        acknowledge(channel, bell);
    }
}

void channel_answer(struct channel *channel, const struct bell *bell, enum outcome outcome,
                    void *bytes, size_t size)
{
    clear_bytes(channel);
    channel->bytes.at = bytes;
    channel->bytes.size = size;
    channel->sent = 0;
    post(channel, bell, outcome);
}
