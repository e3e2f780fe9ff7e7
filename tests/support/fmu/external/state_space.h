/* x' = A x + B u, y = C x + D u, with the variables of the FMI project's StateSpace. Structural parameters
 * specify the sizes: m inputs, n states and r outputs. */
#define TOKEN "{state space}"

enum { MAX_SIZE = 5, SQUARE = MAX_SIZE * MAX_SIZE };

typedef struct {
    uint64_t m, n, r;
    double A[SQUARE], B[SQUARE], C[SQUARE], D[SQUARE], x0[MAX_SIZE], u[MAX_SIZE], y[MAX_SIZE], x[MAX_SIZE];
} model;

static void model_start(model *s)
{
    *s = (model){.m = 3, .n = 3, .r = 3, .u = {1.0, 2.0, 3.0}};
    for (size_t k = 0; k < 3; k++)
        s->A[4 * k] = s->B[4 * k] = s->C[4 * k] = s->D[4 * k] = 1.0;
}

static void *model_variable(model *s, unsigned reference, size_t *size)
{
    void *const found[] = {NULL, &s->m, &s->n, &s->r, s->A, s->B, s->C, s->D, s->x0, s->u, s->y, s->x};
    const size_t m = s->m, n = s->n, r = s->r;
    const size_t sizes[] = {0, 1, 1, 1, n * n, n * m, r * n, r * m, n, m, r, n};
    *size = reference < 12 ? sizes[reference] : 0;
    return reference < 12 ? found[reference] : NULL;
}

static int is_structural(unsigned reference)
{
    return reference >= 1 && reference <= 3;
}

/* Compute out = M x + N u, with `rows` rows. */
static void multiply(const model *s, size_t rows, const double *M, const double *N, double *out)
{
    for (size_t i = 0; i < rows; i++) {
        out[i] = 0.0;
        for (size_t k = 0; k < s->n; k++)
            out[i] += M[i * s->n + k] * s->x[k];
        for (size_t k = 0; k < s->m; k++)
            out[i] += N[i * s->m + k] * s->u[k];
    }
}

static int model_initialise(model *s)
{
    memcpy(s->x, s->x0, sizeof s->x);
    multiply(s, s->r, s->C, s->D, s->y);
    return s->m > MAX_SIZE || s->n > MAX_SIZE || s->r > MAX_SIZE;
}

static int model_ends(const model *s, double t)
{
    return (void)s, (void)t, 0;
}

static int model_fails(const model *s, double t)
{
    return (void)s, (void)t, 0;
}

static void model_step(model *s, double h)
{
    double rates[MAX_SIZE];
    multiply(s, s->n, s->A, s->B, rates);
    for (size_t k = 0; k < s->n; k++)
        s->x[k] += h * rates[k];
    multiply(s, s->r, s->C, s->D, s->y);
}
