#include "in_process.h"

#include "python_api.h"

#include <stdlib.h>
#include <string.h>

#define ENTRY_MODULE "cardsflow_fmu.runtime.in_process"

enum { CLOCK_SIZE = 2 };

/* The callables return None on success, or an error message; get_state returns bytes or an error message. */
enum callable { INITIALIZE, STEP, RESET, TERMINATE, GET_STATE, SET_STATE, CALLABLES };

static const char *const NAMES[CALLABLES] = {"initialize", "step", "reset", "terminate", "get_state", "set_state"};

struct python_model {
    struct python_api py;
    python_object *memory; /* a bytearray or memoryview: the clock, then the values */
    python_object *callables[CALLABLES];
};

static void drop(const struct python_api *py, python_object *object)
{
    if (object)
        py->Py_DecRef(object);
}

/* Set the text from a str. Return 0, or nonzero if the object is not a str. */
static int take_text(const struct python_api *py, python_object *object, struct text *text)
{
    const char *chars = py->PyUnicode_AsUTF8AndSize(object, NULL);
    if (chars)
        text_set(text, "%s", chars);
    else
        py->PyErr_Clear();
    return chars == NULL;
}

/* Do the same as take_text for str(object); an empty text is a failure. */
static int take_str(const struct python_api *py, python_object *object, struct text *text)
{
    python_object *as_str = object ? py->PyObject_Str(object) : NULL;
    int failed = !as_str || take_text(py, as_str, text) || !*text_get(text);
    py->PyErr_Clear();
    drop(py, as_str);
    return failed;
}

/* Set the text from the current exception, and clear the exception. */
static void take_exception(const struct python_api *py, struct text *text)
{
    python_object *type = NULL, *value = NULL, *traceback = NULL;
    py->PyErr_Fetch(&type, &value, &traceback);
    if (take_str(py, value, text) && take_str(py, type, text))
        text_set(text, "an exception without a text");
    drop(py, type);
    drop(py, value);
    drop(py, traceback);
}

/* Process and release the result of a callable. Return 0, or nonzero with a message. */
static int finish(const struct python_api *py, python_object *result, struct text *error)
{
    if (!result) {
        take_exception(py, error);
        return 1;
    }
    int failed = py->PyObject_IsTrue(result);
    if (failed && take_text(py, result, error))
        text_set(error, "the model returned neither None nor a string");
    drop(py, result);
    return failed;
}

static int call(struct model *model, enum callable callable)
{
    struct python_model *self = model->backend;
    const struct python_api *py = &self->py;
    int gil = py->PyGILState_Ensure();
    int failed = finish(py, py->PyObject_CallNoArgs(self->callables[callable]), &model->error);
    py->PyGILState_Release(gil);
    return failed;
}

static int initialize(struct model *model)
{
    return call(model, INITIALIZE);
}

static int step(struct model *model)
{
    return call(model, STEP);
}

static int reset(struct model *model)
{
    return call(model, RESET);
}

static int terminate(struct model *model)
{
    return call(model, TERMINATE);
}

static int copy_bytes(const struct python_api *py, python_object *object, void **bytes, size_t *size,
                      struct text *error)
{
    char *chars = NULL;
    python_ssize length = 0;
    if (py->PyBytes_AsStringAndSize(object, &chars, &length) != 0) {
        py->PyErr_Clear();
        if (take_text(py, object, error))
            text_set(error, "the model returned neither bytes nor a string");
        return 1;
    }
    *size = (size_t)length;
    *bytes = malloc(*size + 1);
    if (!*bytes) {
        text_set(error, "out of memory");
        return 1;
    }
    memcpy(*bytes, chars, *size);
    return 0;
}

static int get_state(struct model *model, void **bytes, size_t *size)
{
    struct python_model *self = model->backend;
    const struct python_api *py = &self->py;
    int failed = 1;
    int gil = py->PyGILState_Ensure();
    python_object *result = py->PyObject_CallNoArgs(self->callables[GET_STATE]);
    if (result)
        failed = copy_bytes(py, result, bytes, size, &model->error);
    else
        take_exception(py, &model->error);
    drop(py, result);
    py->PyGILState_Release(gil);
    return failed;
}

static int set_state(struct model *model, const void *bytes, size_t size)
{
    struct python_model *self = model->backend;
    const struct python_api *py = &self->py;
    python_object *result = NULL;
    int gil = py->PyGILState_Ensure();
    python_object *state = py->PyBytes_FromStringAndSize(bytes, (python_ssize)size);
    if (state)
        result = py->PyObject_CallFunctionObjArgs(self->callables[SET_STATE], state, NULL);
    int failed = finish(py, result, &model->error);
    drop(py, state);
    py->PyGILState_Release(gil);
    return failed;
}

static void drop_all(struct python_model *self)
{
    for (int i = 0; i < CALLABLES; i++)
        drop(&self->py, self->callables[i]);
    drop(&self->py, self->memory);
}

static void close_model(struct model *model)
{
    struct python_model *self = model->backend;
    if (self->py.Py_IsInitialized()) { /* otherwise Python has already freed the objects */
        int gil = self->py.PyGILState_Ensure();
        drop_all(self);
        self->py.PyGILState_Release(gil);
    }
    free(self);
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

static void explain_import(const struct python_api *py, const char *version, struct text *error)
{
    struct text reason = {NULL}, executable = {NULL};
    take_exception(py, &reason);
    python_object *path = py->PySys_GetObject("executable"); /* borrowed reference */
    if (!path || take_text(py, path, &executable))
        text_set(&executable, "no executable");
    text_set(error,
             "this FMU needs the package cardsflow %s in the host's Python, which is %.*s at %s: %s",
             version, (int)strcspn(py->Py_GetVersion(), " "), py->Py_GetVersion(),
             text_get(&executable), text_get(&reason));
    text_free(&reason);
    text_free(&executable);
}

/* Return a new reference to the result of open_model; NULL with a message on failure. */
static python_object *call_entry(const struct python_model *self, python_object *entry,
                                 const char *resources, struct text *error)
{
    const struct python_api *py = &self->py;
    python_object *hosted = NULL;
    python_object *folder = py->PyUnicode_DecodeFSDefault(resources);
    if (folder)
        hosted = py->PyObject_CallFunctionObjArgs(entry, folder, self->memory, NULL);
    drop(py, folder);
    if (!hosted) {
        take_exception(py, error);
    } else if (take_text(py, hosted, error) == 0) {
        drop(py, hosted);
        hosted = NULL;
    }
    return hosted;
}

static int bind(struct python_model *self, python_object *hosted, struct text *error)
{
    for (int i = 0; i < CALLABLES; i++) {
        self->callables[i] = self->py.PyObject_GetAttrString(hosted, NAMES[i]);
        if (!self->callables[i]) {
            take_exception(&self->py, error);
            return 1;
        }
    }
    return 0;
}

static int get_memory(struct python_model *self, struct model *model,
                      const struct python_memory *memory, struct text *error)
{
    enum { WRITABLE = 0x200 }; /* PyBUF_WRITE */
    size_t size = (CLOCK_SIZE + memory->count) * sizeof(double);
    if (memory->clock)
        self->memory = self->py.PyMemoryView_FromMemory((char *)(void *)memory->clock,
                                                        (python_ssize)size, WRITABLE);
    else
        self->memory = self->py.PyByteArray_FromStringAndSize(NULL, (python_ssize)size);
    if (!self->memory) {
        take_exception(&self->py, error);
        return 1;
    }
    model->clock = memory->clock;
    if (!model->clock)
        model->clock = (double *)(void *)self->py.PyByteArray_AsString(self->memory);
    model->values = model->clock + CLOCK_SIZE;
    memset(model->clock, 0, size);
    return 0;
}

/* Return a new reference to an attribute of the Python module; NULL with a message on failure. */
static python_object *from_entry_module(const struct python_api *py, const char *name,
                                        const char *version, struct text *error)
{
    python_object *module = py->PyImport_ImportModule(ENTRY_MODULE);
    python_object *attribute = module ? py->PyObject_GetAttrString(module, name) : NULL;
    drop(py, module);
    if (!attribute)
        explain_import(py, version, error);
    return attribute;
}

static int open_hosted(struct python_model *self, const char *version, const char *resources,
                       struct text *error)
{
    const struct python_api *py = &self->py;
    python_object *entry = from_entry_module(py, "open_model", version, error);
    if (!entry)
        return 1;
    python_object *hosted = call_entry(self, entry, resources, error);
    drop(py, entry);
    int failed = !hosted || bind(self, hosted, error);
    drop(py, hosted);
    return failed;
}

/* Find Python in this process. Return 0, or nonzero with a message. */
static int find_api(struct python_api *py, const char *version, struct text *error)
{
    struct text missing = {NULL};
    if (python_api_find(py, &missing) == 0)
        return 0;
    text_set(error, "this FMU needs a Python with the package cardsflow %s as its host: %s", version,
             text_get(&missing));
    text_free(&missing);
    return 1;
}

int python_in_process_fits(const char *version, struct text *why)
{
    struct python_api py;
    struct text host_version = {NULL};
    if (find_api(&py, version, why))
        return 0;
    int gil = py.PyGILState_Ensure();
    python_object *object = from_entry_module(&py, "__version__", version, why);
    int fits = object && take_text(&py, object, &host_version) == 0 && !strcmp(text_get(&host_version), version);
    if (object && !fits)
        text_set(why, "the host's Python has cardsflow %s", text_get(&host_version));
    drop(&py, object);
    py.PyGILState_Release(gil);
    text_free(&host_version);
    return fits;
}

int python_in_process_open(struct model *model, const char *version,
                           const struct python_memory *memory, const char *resources,
                           struct text *error)
{
    struct python_model *self = calloc(1, sizeof *self);
    if (!self) {
        text_set(error, "out of memory");
        return 1;
    }
    if (find_api(&self->py, version, error)) {
        free(self);
        return 1;
    }
    int gil = self->py.PyGILState_Ensure();
    int failed = get_memory(self, model, memory, error) ||
                 open_hosted(self, version, resources, error);
    if (failed)
        drop_all(self);
    self->py.PyGILState_Release(gil);
    if (failed) {
        free(self);
        return 1;
    }
    model->functions = &FUNCTIONS;
    model->backend = self;
    return 0;
}
