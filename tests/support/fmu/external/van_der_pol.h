/* The oscillator x0'' = mu (1 - x0^2) x0' - x0, with the variables of the FMI project's VanDerPol. */
#define TOKEN "{van der Pol}"

typedef struct {
    double x0, rate0, x1, rate1, mu;
} model;

static void model_start(model *m)
{
    *m = (model){.x0 = 2.0, .mu = 1.0};
}

static void *model_variable(model *m, unsigned r, size_t *size)
{
    double *const found[] = {NULL, &m->x0, &m->rate0, &m->x1, &m->rate1, &m->mu};
    *size = 1;
    return r < 6 ? found[r] : NULL;
}

static int model_initialise(model *m)
{
    m->rate0 = m->x1;
    m->rate1 = m->mu * (1.0 - m->x0 * m->x0) * m->x1 - m->x0;
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
    model_initialise(m);
    m->x0 += h * m->rate0;
    m->x1 += h * m->rate1;
    model_initialise(m);
}
