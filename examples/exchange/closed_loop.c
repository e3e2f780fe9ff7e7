/* A host in C99: steps the FMI 2.0 FMUs of reference, controller and plant with a fixed step, without
   Python.

       cc -std=c99 -O2 closed_loop.c -o closed_loop -ldl
       ./closed_loop FOLDER [hardware] > results.csv     FOLDER contains each unpacked .fmu in a folder of its name

   In each step the controller ticks with the current outputs of robot and reference, then both advance with
   constant forces. An input is set to the output with its name, or keeps its start value. Variables that are
   not real numbers do not change. */
#define _XOPEN_SOURCE 700
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_VARIABLES = 1000, MAX_NAME = 200, PATHS = 4096 };

typedef void *Component; /* the required part of fmi2TypesPlatform.h and fmi2FunctionTypes.h */
typedef struct {
    void (*log)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    char name[MAX_NAME];
    unsigned reference;
    double value;
} Variable;

typedef struct {
    Variable inputs[MAX_VARIABLES], outputs[MAX_VARIABLES];
    const Variable *sources[MAX_VARIABLES]; /* of the inputs; NULL: keep the start value */
    size_t input_count, output_count;
    double step, stop;
    void *library;
    Component component;
    int (*get_real)(Component, const unsigned *, size_t, double *);
    int (*set_real)(Component, const unsigned *, size_t, const double *);
    int (*do_step)(Component, double, double, int);
    int (*terminate)(Component);
    void (*release)(Component);
} Participant;

static void fail(const char *problem, const char *where)
{
    fprintf(stderr, "closed_loop: %s: %s\n", where, problem);
    exit(1);
}

static void log_message(void *environment, const char *instance, int status, const char *category,
                        const char *message, ...)
{
    (void)environment;
    fprintf(stderr, "%s: status %d: %s: %s\n", instance, status, category, message);
}

static char *read_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END)) fail("cannot be read", path);
    const long size = ftell(file);
    char *text = size < 0 ? NULL : malloc((size_t)size + 1);
    rewind(file);
    if (!text || fread(text, 1, (size_t)size, file) != (size_t)size) fail("cannot be read", path);
    text[size] = '\0';
    fclose(file);
    return text;
}

/* Read an attribute of the element that begins at `element`. Return 0 if it does not exist. */
static int attribute(const char *element, const char *name, char *value)
{
    const char *end = strchr(element, '>'), *at = element;
    const size_t length = strlen(name);
    while ((at = strstr(at + 1, name)) && at < end)
        if (at[-1] == ' ' && at[length] == '=' && at[length + 1] == '"') {
            const size_t size = strcspn(at + length + 2, "\"");
            if (size >= MAX_NAME) fail("too long", name);
            memcpy(value, at + length + 2, size);
            value[size] = '\0';
            return 1;
        }
    return 0;
}

static void read_variables(Participant *p, const char *description, const char *path)
{
    for (const char *at = description; (at = strstr(at, "<ScalarVariable")); at++) {
        char causality[MAX_NAME], reference[MAX_NAME];
        const char *type = strchr(at, '>') + 1;
        type += strspn(type, " \r\n\t");
        if (strncmp(type, "<Real", 5) || !attribute(at, "causality", causality)) continue;
        const int is_input = !strcmp(causality, "input");
        if (!is_input && strcmp(causality, "output")) continue;
        size_t *count = is_input ? &p->input_count : &p->output_count;
        if (*count == MAX_VARIABLES) fail("has too many variables", path);
        Variable *v = (is_input ? p->inputs : p->outputs) + (*count)++;
        if (!attribute(at, "name", v->name) || !attribute(at, "valueReference", reference))
            fail("has a variable without a name", path);
        v->reference = (unsigned)strtoul(reference, NULL, 10);
    }
}

static void read_outputs(Participant *p)
{
    for (size_t i = 0; i < p->output_count; i++)
        if (p->get_real(p->component, &p->outputs[i].reference, 1, &p->outputs[i].value))
            fail("does not have this output", p->outputs[i].name);
}

static void *function(void *library, const char *name)
{
    void *found = dlsym(library, name);
    if (!found) fail("is not in the FMU", name);
    return found;
}

/* Load the FMU in a folder and initialize it. */
static Participant *participant(const char *folder, const char *name)
{
    static const Callbacks callbacks = {log_message, calloc, free, NULL, NULL};
    char path[PATHS], absolute[PATHS], guid[MAX_NAME], model[MAX_NAME], number[MAX_NAME];
    Participant *p = calloc(1, sizeof *p);
    snprintf(path, sizeof path, "%s/%s/modelDescription.xml", folder, name);
    char *description = read_text(path);
    const char *root = strstr(description, "<fmiModelDescription");
    const char *kind = strstr(description, "<CoSimulation");
    const char *experiment = strstr(description, "<DefaultExperiment");
    if (!p || !root || !kind || !experiment || !attribute(root, "guid", guid) ||
        !attribute(kind, "modelIdentifier", model))
        fail("is not an FMI 2.0 FMU for co-simulation", path);
    if (attribute(experiment, "stepSize", number)) p->step = strtod(number, NULL);
    if (attribute(experiment, "stopTime", number)) p->stop = strtod(number, NULL);
    read_variables(p, description, path);
    free(description);

    snprintf(path, sizeof path, "%s/%s", folder, name);
    if (!realpath(path, absolute)) fail("does not exist", path);
    if (strlen(absolute) + strlen(model) + 30 > sizeof path) fail("is too long", absolute);
    strcat(strcat(strcat(strcpy(path, absolute), "/binaries/linux64/"), model), ".so");
    void *const library = p->library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) fail(dlerror(), path);
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
    int (*setup)(Component, int, double, double, int, double), (*enter)(Component), (*leave)(Component);
    *(void **)&instantiate = function(library, "fmi2Instantiate");
    *(void **)&setup = function(library, "fmi2SetupExperiment");
    *(void **)&enter = function(library, "fmi2EnterInitializationMode");
    *(void **)&leave = function(library, "fmi2ExitInitializationMode");
    *(void **)&p->get_real = function(library, "fmi2GetReal");
    *(void **)&p->set_real = function(library, "fmi2SetReal");
    *(void **)&p->do_step = function(library, "fmi2DoStep");
    *(void **)&p->terminate = function(library, "fmi2Terminate");
    *(void **)&p->release = function(library, "fmi2FreeInstance");
    strcat(strcat(strcpy(path, "file://"), absolute), "/resources");
    p->component = instantiate(name, 1, guid, path, &callbacks, 0, 0);
    if (!p->component || setup(p->component, 0, 0.0, 0.0, 0, 0.0) || enter(p->component) ||
        leave(p->component))
        fail("does not start", name);
    read_outputs(p);
    return p;
}

static void connect_inputs(Participant *p, Participant *const *all, size_t count)
{
    for (size_t i = 0; i < p->input_count; i++)
        for (size_t j = 0; j < count; j++)
            for (size_t k = 0; k < all[j]->output_count; k++)
                if (all[j] != p && !strcmp(p->inputs[i].name, all[j]->outputs[k].name))
                    p->sources[i] = &all[j]->outputs[k];
}

static void write_inputs(Participant *p)
{
    for (size_t i = 0; i < p->input_count; i++)
        if (p->sources[i] &&
            p->set_real(p->component, &p->inputs[i].reference, 1, &p->sources[i]->value))
            fail("rejects this input", p->inputs[i].name);
}

static void step(Participant *p, double time, double size, const char *name)
{
    if (p->do_step(p->component, time, size, 1)) fail("failed in a step", name);
}

static void print_row(Participant *const *all, size_t count, double time, int names)
{
    printf(names ? "time" : "%.17g", time);
    for (size_t j = 0; j < count; j++)
        for (size_t k = 0; k < all[j]->output_count; k++) {
            const Variable *v = &all[j]->outputs[k];
            if (names)
                printf(",%s", v->name);
            else
                printf(",%.17g", v->value);
        }
    putchar('\n');
}

int main(int count, char **arguments)
{
    if (count < 2 || count > 3) fail("requires the folder of the unpacked FMUs [hardware]", "usage");
    const char *robot = count > 2 ? arguments[2] : "plant";
    Participant *reference = participant(arguments[1], "reference");
    Participant *controller = participant(arguments[1], "controller");
    Participant *plant = participant(arguments[1], robot);
    Participant *const all[] = {plant, reference, controller};
    for (size_t j = 0; j < 3; j++) connect_inputs(all[j], all, 3);
    if (!(plant->step > 0.0)) fail("has no step size", robot);
    const long last = (long)(plant->stop / plant->step + 0.5);
    const long ticks = (long)(controller->step / plant->step + 0.5);
    print_row(all, 3, 0.0, 1);
    for (long k = 0; k <= last; k++) {
        const double time = (double)k * plant->step;
        if (k < last && (ticks < 2 || k % ticks == 0)) {
            write_inputs(controller);
            step(controller, time, controller->step, "controller");
            read_outputs(controller);
        }
        print_row(all, 3, time, 0);
        if (k == last) break;
        write_inputs(reference);
        write_inputs(plant);
        step(reference, time, plant->step, "reference");
        step(plant, time, plant->step, robot);
        read_outputs(reference);
        read_outputs(plant);
    }
    for (size_t j = 0; j < 3; j++) {
        all[j]->terminate(all[j]->component);
        all[j]->release(all[j]->component);
        dlclose(all[j]->library);
        free(all[j]);
    }
    return 0;
}
