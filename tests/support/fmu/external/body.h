/* Two joints pulled by four cables, in their own units. */
#define TOKEN "{body}"

enum { CABLES = 4, JOINTS = 2 };

static const double LEVERS[JOINTS][CABLES] = {{0.1, -0.1, 0.05, -0.05}, {0.0, 0.02, 0.1, -0.1}};
static const double DEGREES = 57.29577951308232;

typedef struct {
    double pulls[CABLES]; /* kN */
    double angles[JOINTS]; /* deg */
    double rates[JOINTS]; /* deg/s */
    double inertia; /* kg.m2 */
    model_boolean brake;
} model;

static void model_start(model *m)
{
    *m = (model){.angles = {-28.64788975654116, 28.64788975654116}, .inertia = 2.0};
}

#if FMI == 2 /* pulls 0..3, angles 4..5, rates 6..7, inertia 8, brake 9 */
static void *model_variable(model *m, unsigned r, size_t *size)
{
    *size = 1;
    return r < 9 ? (void *)(m->pulls + r) : r == 9 ? &m->brake : NULL;
}
#else /* pulls[4] 1, angles[2] 2, rates[2] 3, inertia 4, brake 5 */
static void *model_variable(model *m, unsigned r, size_t *size)
{
    void *const found[] = {NULL, m->pulls, m->angles, m->rates, &m->inertia, &m->brake};
    *size = r == 1 ? CABLES : r == 2 || r == 3 ? JOINTS : 1;
    return r < 6 ? found[r] : NULL;
}

static int is_structural(unsigned r)
{
    return (void)r, 0;
}

static int model_ends(const model *m, double t)
{
    return m->inertia == 1e7 && t > 0.0095;
}
#endif

static int model_initialise(const model *m)
{
    return !(m->inertia > 0.0);
}

/* Bodies with this inertia stop after a while. */
static int model_fails(const model *m, double t)
{
    return m->inertia == 1e6 && t > 0.0095;
}

static void model_step(model *m, double h)
{
    for (size_t i = 0; i < JOINTS && !m->brake; i++) {
        double torque = 0.0;
        for (size_t k = 0; k < CABLES; k++) {
            torque += LEVERS[i][k] * 1000.0 * m->pulls[k];
        }
        m->rates[i] += h * torque / m->inertia * DEGREES;
        m->angles[i] += h * m->rates[i];
    }
}
