#include "client.h"

#include "../environment.h"
#include "../interpreters.h"
#include "channel.h"
#include "system/process.h"
#include "system/shared_memory.h"

#include <stdlib.h>
#include <string.h>

struct python_worker {
    struct shared_memory memory;
    struct channel channel;
    struct process process;
    int is_alive;
    char *program;   /* the interpreter */
    char *library;   /* path of this library: the worker loads it too */
    char *resources; /* folder */
    char *version;   /* of the package */
    size_t count;    /* of values */
    double longest_start, longest_call;
    const double *chosen_longest_call; /* the parameter for the maximum time of a call, or NULL */
};

/* This code must run in any Python 3, since the package may be missing. It does not import from the current
 * folder of the host. It closes files that the host left open for its children. It reports import errors to
 * the host. */
static const char START[] =
    "import sys\n"
    "sys.path[:] = [p for p in sys.path if p]\n"
    "import ctypes, os\n"
    "os.name == 'posix' and os.closerange(5, 65536)\n"
    "try:\n"
    "    from cardsflow_fmu.runtime.worker import main\n"
    "except BaseException as error:\n"
    "    text = type(error).__name__ + ': ' + str(error)\n"
    "    library = ctypes.CDLL(sys.argv[1])\n"
    "    library.cardsflow_worker_reject(sys.argv[-1].encode(), text.encode())\n"
    "else:\n"
    "    main(*sys.argv[1:])\n";

/* Maximum time for a process to quit, and minimum time for a process to terminate, in s. */
static const double MAX_QUIT = 5;

static void stop(struct python_worker *self, double patience)
{
    if (self->is_alive)
        process_end(&self->process, patience);
    self->is_alive = 0;
}

static void quit(struct python_worker *self)
{
    if (self->is_alive && process_is_child(&self->process))
        channel_quit(&self->channel, &self->process);
    stop(self, MAX_QUIT);
}

/* Return whether this process is a forked copy of the host. A copy shares the memory, but neither calls the
 * worker nor ends it. */
static int is_forked_copy(const struct python_worker *self, struct text *error)
{
    if (process_is_child(&self->process))
        return 0;
    text_set(error, "the instance belongs to the process that this one was forked from");
    return 1;
}

/* Send a command; the bytes of the answer are in the channel. A worker that does not answer is ended, since
 * it could write to the values later. Return 0, or nonzero with a message. */
static int exchange(struct python_worker *self, enum command command, const void *bytes, size_t size,
                    double longest, enum outcome *outcome, struct text *error)
{
    *outcome = OUTCOME_UNFIT;
    if (!self->is_alive) {
        text_set(error, "the worker process has ended; a reset starts a new one");
        return 1;
    }
    if (is_forked_copy(self, error))
        return 1;
    if (channel_ask(&self->channel, &self->process, command, bytes, size, longest, outcome, error)) {
        stop(self, 0);
        *outcome = OUTCOME_UNFIT;
        return 1;
    }
    if (*outcome == OUTCOME_DONE)
        return 0;
    text_set(error, "%s", self->channel.bytes.at ? (const char *)self->channel.bytes.at : "");
    return 1;
}

/* Start the worker and open the model there. */
static enum outcome start(struct python_worker *self, const char *program, struct text *error)
{
    const char *const arguments[] = {"-E",          "-c",          START,
                                     self->library, self->version, self->resources,
                                     NULL};
    enum outcome outcome = OUTCOME_UNFIT;
    channel_clear(&self->channel, self->count);
    if (process_start(&self->process, program, arguments, &self->memory, error))
        return OUTCOME_UNFIT;
    self->is_alive = 1;
    if (exchange(self, COMMAND_OPEN, NULL, 0, self->longest_start, &outcome, error))
        quit(self);
    return outcome;
}

/* Return the maximum time of a call. A parameter that is not positive, such as NaN, is ignored. */
static double max_call_time(const struct python_worker *self)
{
    const double *chosen = self->chosen_longest_call;
    return chosen && *chosen > 0 ? *chosen : self->longest_call;
}

/* Send a command to the model. */
static int call_with(struct model *model, enum command command, const void *bytes, size_t size)
{
    struct python_worker *self = model->backend;
    enum outcome outcome;
    return exchange(self, command, bytes, size, max_call_time(self), &outcome, &model->error);
}

static int initialize(struct model *model)
{
    return call_with(model, COMMAND_INITIALIZE, NULL, 0);
}

static int step(struct model *model)
{
    return call_with(model, COMMAND_STEP, NULL, 0);
}

/* Reset, also after a failure or the end of the worker. */
static int reset(struct model *model)
{
    struct python_worker *self = model->backend;
    if (is_forked_copy(self, &model->error))
        return 1;
    if (self->is_alive && call_with(model, COMMAND_RESET, NULL, 0) == 0)
        return 0;
    return self->is_alive || start(self, self->program, &model->error) != OUTCOME_DONE;
}

/* Terminate. A worker that has ended has no resources. */
static int terminate(struct model *model)
{
    struct python_worker *self = model->backend;
    enum outcome outcome;
    double longest = max_call_time(self);
    return self->is_alive &&
           exchange(self, COMMAND_TERMINATE, NULL, 0, longest > MAX_QUIT ? longest : MAX_QUIT,
                    &outcome, &model->error);
}

/* Move the bytes of the answer to the caller. */
static int take_bytes(struct channel *channel, void **bytes, size_t *size, struct text *error)
{
    *size = channel->bytes.size;
    *bytes = channel->bytes.at ? channel->bytes.at : malloc(1);
    channel->bytes.at = NULL;
    channel->bytes.size = 0;
    if (!*bytes)
        text_set(error, "out of memory");
    return *bytes == NULL;
}

static int get_state(struct model *model, void **bytes, size_t *size)
{
    struct python_worker *self = model->backend;
    return call_with(model, COMMAND_GET_STATE, NULL, 0) ||
           take_bytes(&self->channel, bytes, size, &model->error);
}

static int set_state(struct model *model, const void *bytes, size_t size)
{
    return call_with(model, COMMAND_SET_STATE, bytes, size);
}

static void free_worker(struct python_worker *self)
{
    stop(self, 0);
    channel_free(&self->channel);
    shared_memory_close(&self->memory);
    free(self->program);
    free(self->library);
    free(self->resources);
    free(self->version);
    free(self);
}

static void close_model(struct model *model)
{
    quit(model->backend);
    free_worker(model->backend);
}

static const struct model_functions FUNCTIONS = {
    .initialize = initialize,
    .step = step,
    .reset = reset,
    .terminate = terminate,
    .get_state = get_state,
    .set_state = set_state,
    .close = close_model,
};

/* Return the value of the parameter `worker_timeout`; NULL if it does not exist or the environment variable
 * takes precedence. */
static const double *find_timeout(const struct python_worker *self, const struct port_table *ports)
{
    char *decided = environment_get("CARDSFLOW_FMU_TIMEOUT");
    free(decided);
    for (size_t i = 0; i < ports->count && !decided; i++)
        if (ports->ports[i].causality == CAUSALITY_PARAMETER && ports->ports[i].size == 1 &&
            strcmp(ports->ports[i].name, "worker_timeout") == 0)
            return channel_clock(&self->channel) + 2 + i;
    return NULL;
}

static struct python_worker *make_worker(const struct port_table *ports, const char *resources,
                                         struct text *error)
{
    const double start = 60, call = 60; /* in s */
    struct python_worker *self = calloc(1, sizeof *self);
    if (self && shared_memory_create(&self->memory, channel_size(ports->count), error)) {
        free(self);
        return NULL;
    }
    if (self) {
        channel_attach(&self->channel, &self->memory);
        self->count = ports->count;
        self->longest_start = environment_get_positive("CARDSFLOW_FMU_START_TIMEOUT", start);
        self->longest_call = environment_get_positive("CARDSFLOW_FMU_TIMEOUT", call);
        self->chosen_longest_call = find_timeout(self, ports);
        self->library = process_own_library();
        self->resources = text_copy(resources);
        self->version = text_copy(ports->package_version);
        if (self->library && self->resources && self->version)
            return self;
        free_worker(self);
    }
    text_set(error, "out of memory, or the file of this library is unknown");
    return NULL;
}

/* Return the length of the first line, which contains the reason. */
static int first_line(const char *text)
{
    return (int)strcspn(text, "\n");
}

/* Start interpreters until one is suitable. */
static enum outcome start_any(struct python_worker *self, struct text *error)
{
    struct interpreter list[MAX_INTERPRETERS];
    struct text tried = {NULL}, reason = {NULL};
    enum outcome outcome = OUTCOME_UNFIT;
    size_t count = interpreters_find(self->resources, list);
    text_set(&tried, "no Python with the package cardsflow %s; tried", self->version);
    for (size_t i = 0; i < count && outcome == OUTCOME_UNFIT; i++) {
        outcome = start(self, list[i].program, &reason);
        if (outcome == OUTCOME_DONE)
            self->program = text_copy(list[i].program);
        text_set(&tried, "%s%s %s (%s): %.*s", text_get(&tried), i ? ";" : "", list[i].program,
                 list[i].source, first_line(text_get(&reason)), text_get(&reason));
    }
    if (outcome != OUTCOME_DONE)
        text_set(error, "%s", text_get(outcome == OUTCOME_FAILED ? &reason : &tried));
    interpreters_free(list, count);
    text_free(&tried);
    text_free(&reason);
    return outcome;
}

int python_worker_open(struct model *model, const struct port_table *ports, const char *resources,
                       struct text *error)
{
    struct python_worker *self = make_worker(ports, resources, error);
    if (!self)
        return 1;
    if (start_any(self, error) != OUTCOME_DONE || !self->program) {
        free_worker(self);
        return 1;
    }
    model->functions = &FUNCTIONS;
    model->backend = self;
    model->clock = channel_clock(&self->channel);
    model->values = model->clock + 2;
    return 0;
}
