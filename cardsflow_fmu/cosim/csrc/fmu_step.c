#include "fmu_step.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef int access_2(void *instance, const uint32_t *references, size_t count, void *values);
typedef int access_3(void *instance, const uint32_t *references, size_t count, void *values, size_t size);
typedef int do_step_2(void *instance, double t, double h, int no_set_state);
typedef int do_step_3(void *instance, double t, double h, bool no_set_state, bool *event_needed, bool *terminate,
                      bool *early_return, double *last_time);

union function { /* C does not convert pointers to objects into pointers to functions */
    void *address;
    access_2 *access_2;
    access_3 *access_3;
    do_step_2 *do_step_2;
    do_step_3 *do_step_3;
};

struct bank {
    int32_t type;
    union function get, set;
    uint32_t *references;
    size_t count, size;
    double *values;
    void *buffer; /* the values themselves if they are doubles */
};

struct fmu_row {
    int32_t version;
    void *instance;
    size_t count;
    struct bank *banks;
};

struct fmu {
    int32_t version;
    void *instance;
    union function do_step;
    struct fmu_row *inputs, *outputs;
};

static const size_t SIZES[] = {8, 4, 1, 1, 2, 2, 4, 4, 8, 8, sizeof(bool), 4};

struct fmu_row *fmu_row_open(int32_t version, void *instance)
{
    struct fmu_row *row = calloc(1, sizeof *row);
    if (row) {
        row->version = version;
        row->instance = instance;
    }
    return row;
}

static void free_bank(struct bank *bank)
{
    free(bank->references);
    if (bank->type != FMU_DOUBLE)
        free(bank->buffer);
}

void fmu_row_close(struct fmu_row *row)
{
    for (size_t i = 0; i < row->count; i++)
        free_bank(&row->banks[i]);
    free(row->banks);
    free(row);
}

int fmu_row_add(struct fmu_row *row, int32_t type, void *get, void *set, const uint32_t *references,
                size_t count, double *values, size_t size)
{
    struct bank *banks = realloc(row->banks, (row->count + 1) * sizeof *banks);
    if (!banks)
        return 1;
    row->banks = banks;
    struct bank *bank = &banks[row->count];
    const struct bank empty = {type, {get}, {set}, NULL, count, size, values, values};
    *bank = empty;
    bank->references = malloc(count * sizeof *references + 1);
    if (type != FMU_DOUBLE)
        bank->buffer = calloc(size + 1, SIZES[type]);
    if (!bank->references || !bank->buffer) {
        free_bank(bank);
        return 1;
    }
    memcpy(bank->references, references, count * sizeof *references);
    row->count++;
    return 0;
}

/* Return the value as an integer between two powers of two, or 0 if it is not a number. */
static double bounded(double value, double low, double high)
{
    const double rounded = rint(value);
    if (!(rounded >= low))
        return rounded < low ? low : 0;
    return rounded <= high ? rounded : high;
}

#define WRITE(kind, low, high)                                                                                 \
    for (size_t i = 0; i < bank->size; i++)                                                                    \
        ((kind *)bank->buffer)[i] = (kind)bounded(bank->values[i], low, high);                                 \
    return
#define READ(kind)                                                                                             \
    for (size_t i = 0; i < bank->size; i++)                                                                    \
        bank->values[i] = (double)((const kind *)bank->buffer)[i];                                             \
    return

static void write_buffer(struct bank *bank)
{
    switch ((enum fmu_type)bank->type) {
    case FMU_DOUBLE:
        return;
    case FMU_FLOAT:
        for (size_t i = 0; i < bank->size; i++)
            ((float *)bank->buffer)[i] = (float)bank->values[i];
        return;
    case FMU_INT8:
        WRITE(int8_t, -128.0, 127.0);
    case FMU_UINT8:
        WRITE(uint8_t, 0.0, 255.0);
    case FMU_INT16:
        WRITE(int16_t, -32768.0, 32767.0);
    case FMU_UINT16:
        WRITE(uint16_t, 0.0, 65535.0);
    case FMU_INT32:
        WRITE(int32_t, -2147483648.0, 2147483647.0);
    case FMU_UINT32:
        WRITE(uint32_t, 0.0, 4294967295.0);
    case FMU_INT64: /* the largest doubles below 2^63 and 2^64 */
        WRITE(int64_t, -9223372036854775808.0, 9223372036854774784.0);
    case FMU_UINT64:
        WRITE(uint64_t, 0.0, 18446744073709549568.0);
    case FMU_BOOL:
        for (size_t i = 0; i < bank->size; i++)
            ((bool *)bank->buffer)[i] = rint(bank->values[i]) != 0;
        return;
    case FMU_BOOL2:
        for (size_t i = 0; i < bank->size; i++)
            ((int32_t *)bank->buffer)[i] = rint(bank->values[i]) != 0;
    }
}

static void read_buffer(struct bank *bank)
{
    switch ((enum fmu_type)bank->type) {
    case FMU_DOUBLE:
        return;
    case FMU_FLOAT:
        READ(float);
    case FMU_INT8:
        READ(int8_t);
    case FMU_UINT8:
        READ(uint8_t);
    case FMU_INT16:
        READ(int16_t);
    case FMU_UINT16:
        READ(uint16_t);
    case FMU_INT32:
    case FMU_BOOL2:
        READ(int32_t);
    case FMU_UINT32:
        READ(uint32_t);
    case FMU_INT64:
        READ(int64_t);
    case FMU_UINT64:
        READ(uint64_t);
    case FMU_BOOL:
        READ(bool);
    }
}

static int call(const struct fmu_row *row, const struct bank *bank, union function function)
{
    if (row->version == 2)
        return function.access_2(row->instance, bank->references, bank->count, bank->buffer);
    return function.access_3(row->instance, bank->references, bank->count, bank->buffer, bank->size);
}

int fmu_row_get(struct fmu_row *row)
{
    int highest = 0;
    for (struct bank *bank = row->banks; bank < row->banks + row->count; bank++) {
        const int status = call(row, bank, bank->get);
        read_buffer(bank);
        highest = status > highest ? status : highest;
    }
    return highest;
}

int fmu_row_set(struct fmu_row *row)
{
    int highest = 0;
    for (struct bank *bank = row->banks; bank < row->banks + row->count; bank++) {
        write_buffer(bank);
        const int status = call(row, bank, bank->set);
        highest = status > highest ? status : highest;
    }
    return highest;
}

struct fmu *fmu_open(int32_t version, void *instance, void *do_step, struct fmu_row *inputs,
                     struct fmu_row *outputs)
{
    struct fmu *fmu = malloc(sizeof *fmu);
    const struct fmu opened = {version, instance, {do_step}, inputs, outputs};
    if (fmu)
        *fmu = opened;
    return fmu;
}

void fmu_close(struct fmu *fmu)
{
    free(fmu);
}

int fmu_step(void *instance, double t, double h)
{
    const struct fmu *fmu = instance;
    if (fmu_row_set(fmu->inputs) >= FMU_DISCARD)
        return FMU_STEP_FAILED;
    if (fmu->version == 2) {
        if (fmu->do_step.do_step_2(fmu->instance, t, h, 1) >= FMU_DISCARD)
            return FMU_STEP_FAILED;
    } else {
        bool event_needed = false, terminate = false, early_return = false;
        double last_time = t;
        if (fmu->do_step.do_step_3(fmu->instance, t, h, true, &event_needed, &terminate, &early_return,
                                   &last_time) >= FMU_DISCARD)
            return FMU_STEP_FAILED;
        if (terminate)
            return FMU_TERMINATED;
    }
    return fmu_row_get(fmu->outputs) >= FMU_DISCARD ? FMU_GET_FAILED : FMU_DONE;
}
