/* Outputs that equal the inputs, with the types of the FMI project's Feedthrough: variable 2 k is the input
 * and 2 k + 1 the output of type k. */
#define TOKEN "{feedthrough}"

typedef union {
    double number;
    float single;
    int64_t whole;
    model_integer integer;
    model_boolean boolean;
} value;

enum { TYPES = 14 };

typedef struct {
    value values[2 * TYPES];
} model;

static void model_start(model *m)
{
    memset(m, 0, sizeof *m);
}

static void *model_variable(model *m, unsigned r, size_t *size)
{
    *size = 1;
    return r < 2 * TYPES ? m->values + r : NULL;
}

static int model_initialise(model *m)
{
    for (size_t k = 0; k < TYPES; k++)
        m->values[2 * k + 1] = m->values[2 * k];
    return 0;
}

#if FMI == 3
static int is_structural(unsigned r)
{
    return (void)r, 0;
}

static int model_ends(const model *m, double t)
{
    return (void)m, (void)t, 0;
}
#endif

static int model_fails(const model *m, double t)
{
    return (void)m, (void)t, 0;
}

static void model_step(model *m, double h)
{
    (void)h;
    model_initialise(m);
}
