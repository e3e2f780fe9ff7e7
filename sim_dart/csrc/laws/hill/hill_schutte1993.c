/* hill_schutte1993: curves through points, Hill's hyperbola and another one for lengthening, and an
   activation that rises faster with higher excitation.

   Schutte, Rodgers, Zajac & Glaser 1993, IEEE Trans. Rehabil. Eng. 1: Improving the efficacy of electrical
   stimulation-induced leg cycle ergometry; as implemented in OpenSim, with the curves of its wrist model:

     fV(w) = 0.15 (1 + w) / (0.15 - w) for w < 0, (1.4 w + k) / (w + k) else, k = 0.13 0.15 / 1.15
     a' = (u - a) (u / tau_a + (1 - u) / tau_d) while it rises, (u - a) / tau_d while it falls */
#include "../../math/elementary.h"
#include "hill.h"

#include <math.h>
#include <stddef.h>

/* Begin of a piece, and a, b, c, d of a + D (b + D (c + D d)), with D the distance from the begin: OpenSim's
   splines through the points that the tests contain. */
static const real SCHUTTE_TENDON[][5] = {
    {0, 0, 3.4275708665873026, 5875.842767334536, -1678602.6936864045},
    {0.00131, 0.0108, 10.18032866909807, -721.0658188530332, 370934.8411176944},
    {0.00281, 0.0257, 10.520941390083408, 948.1409661765915, -33993.85452516815},
    {0.00431, 0.0435, 13.135905770568296, 795.1686208133349, 61336.873279270905},
    {0.00581, 0.0652, 15.935435527643381, 1071.1845505700542, -3946.2311844980236},
    {0.00731, 0.0915, 19.12235211885818, 1053.426510239813, 132225.8292364849},
    {0.00881, 0.123, 23.175155996923895, 1648.4427418039952, -57646.04185120351},
    {0.0103, 0.161, 27.703575434958232, 1390.7649347291156, 686049.1094584131},
    {0.0118, 0.208, 36.506701727989864, 4477.985927291974, -2982778.7665433995},
    {0.0123, 0.227, 38.74760358037429, 3.8177774768707424, -0.4300089346293674},
    {9.2, 345.0, 0.004686845876752339, -8.034601789211974, 3347.7559124612717},
    {9.201, 345.0, -0.0013390899642828835, 2.0086659481841154, -669.5759839008607},
    {9.202, 345.0, 0.0006695139803827653, -6.200351735346964e-05, 3.137740126891277e-22},
    {20.0, 345.0, -0.0006695139803827653, 0, 0},
};
static const real SCHUTTE_ACTIVE[][5] = {
    {0, 0, -0.0007549029024379338, -2.156865435536954e-05, 0.004748427763723092},
    {0.401, 0, 0.0015184548352723708, 0.005690789945403511, -1524.1456252177716},
    {0.402, 0, -0.0030426004604901455, -4.566746085707916, 4396.764261800891},
    {0.4035, 0, 0.01293532004954212, 15.218693092396116, -4.218088112219415},
    {0.52725, 0.226667, 3.5857736654744747, 13.652727880734659, -90.47700049736419},
    {0.62875, 0.636667, 3.560927390141699, -13.897518770712747, 16.57947452677694},
    {0.71875, 0.856667, 1.4622552424140847, -9.421060648482975, 26.35712261236668},
    {0.86125, 0.95, 0.3828959207385494, 1.8466092683037778, -14.405391041117527},
    {1.045, 0.993333, -0.39762874350750865, -6.094362543112257, 5.182851475685266},
    {1.2175, 0.77, -2.037517148211159, -3.4122369044451304, 8.725516589266707},
    {1.43875, 0.246667, -2.266048966435301, 2.3793247316806454, 14.425873225634655},
    {1.61875, 0, -0.007297185498581663, 10.169296273523356, -3465.238299726609},
    {1.62, 0, 0.001882750655257144, -2.825347350453459, 942.596695196211},
    {1.621, 0, -0.0009401539600611408, 0.0024427351348630002, -0.0014144740142898289},
    {2.2, 0, 0.000465964277036604, -1.420622795843305e-05, 0},
    {35.0, 0, -0.000465964277036604, 0, 0},
};
static const real SCHUTTE_PASSIVE[][5] = {
    {-35.0, 0, -0.00029104366839627555, 8.084995510758253e-06, 0},
    {0.998, 0, 0.00029104366839627545, 8.084995510758253e-06, -291.0517533917857},
    {0.999, 0, -0.0005820954217880599, -0.8731471751798472, 5.807961004953514},
    {1.15, 0, 0.13300941429573293, 1.757859160064093, 4.120466969785725},
    {1.25, 0.035, 0.6081952554021237, 2.9939992509998117, -5.7595180502105885},
    {1.35, 0.12, 1.0342095640957687, 1.2661438359366333, 23.917605231057074},
    {1.45, 0.26, 2.004966488214805, 8.441425405253746, 5.089097125981703},
    {1.55, 0.55, 3.8459244830450077, 9.968154543048259, 135.7260062650179},
    {1.65, 1.17, 9.911335579605183, 50.68595642255357, -667.9931221860538},
    {1.75, 2.0, 0.00873319853425637, -149.71198023326275, 623799.948906963},
    {1.7501, 2.0, -0.0024951990451881137, 37.42800443880554, -124760.13986923029},
    {1.7502, 2.0, 0.0012475976464960852, -3.7521959425202115e-05, -5.0949656674885285e-23},
    {35.0, 2.0, -0.0012475976464960852, 0, 0},
};

#define PIECES(table) (int)(sizeof(table) / sizeof *(table))

static real through_points(const real (*pieces)[5], int count, real x, real *slope)
{
    int k = 0;
    while (k + 1 < count && value_of(x) >= value_of(pieces[k + 1][0])) k++;
    const real *p = pieces[k], D = x - p[0];
    if (slope) *slope = p[2] + D * (2 * p[3] + D * 3 * p[4]);
    return p[1] + D * (p[2] + D * (p[3] + D * p[4]));
}

static real schutte_active(const real *k, real x, real *slope)
{
    (void)k;
    const real y = through_points(SCHUTTE_ACTIVE, PIECES(SCHUTTE_ACTIVE), x, slope);
    if (value_of(y) >= 0) return y;
    if (slope) *slope = 0;
    return 0;
}

static real schutte_passive(const real *k, real x, real *slope)
{
    (void)k;
    return through_points(SCHUTTE_PASSIVE, PIECES(SCHUTTE_PASSIVE), x, slope);
}

static real schutte_tendon(const real *k, real x, real *slope)
{
    (void)k;
    if (value_of(x) > 1) return through_points(SCHUTTE_TENDON, PIECES(SCHUTTE_TENDON), x - 1, slope);
    if (slope) *slope = 0;
    return 0;
}

static real schutte_velocity(const real *k, real w, real *slope)
{
    (void)k;
    const real bend = value_of(w) < 0 ? -0.15 : 0.13 * 0.15 / 1.15, most = value_of(w) < 0 ? -0.15 : 1.4;
    const real under = w + bend, top = most * w + bend;
    if (slope) *slope = bend * (most - 1) / (under * under);
    return top / under;
}

static void schutte_prepare(const void *parameters, real *k)
{
    hill_prepare(parameters, 1e-6, 1.57, ((const hill_schutte1993_parameters *)parameters)->fibre_damping, 0, k);
}

static real schutte_rate_constant(const real *k, real a, real u)
{
    return value_of(u) >= value_of(a) ? u * k[HILL_RISE] + (1 - u) * k[HILL_FALL] : k[HILL_FALL];
}

/* Return the activation after a time h, exactly: its rate depends on the excitation only. */
static real schutte_activation(const real *k, real a, real u, real h)
{
    a = hill_activation(k, a);
    return hill_activation(k, u + (a - u) * exponential(-h * schutte_rate_constant(k, a, u)));
}

static const hill_curves schutte_curves = {schutte_active, schutte_velocity, schutte_passive,
                                           schutte_tendon, NULL,             NULL};

static real schutte_tension(const real *k, const real *x, real l, real v, real u)
{
    (void)u;
    if (k[HILL_ELASTIC]) return hill_elastic_tension(&schutte_curves, k, x, l);
    return hill_rigid_tension(&schutte_curves, k, hill_activation(k, x[0]), l, v);
}

static void schutte_rates(const real *k, const real *x, real l, real v, real u, real *xd)
{
    hill_rates(&schutte_curves, k, x, l, v, u, xd);
    const real a = hill_activation(k, x[0]);
    xd[0] = (u - a) * schutte_rate_constant(k, a, u);
}

static void schutte_start(const real *k, real l, real u, real *x)
{
    hill_start(&schutte_curves, k, l, u, x);
}

static void schutte_advance(const real *k, real *x, real l, real v, real u, real h)
{
    const real a = x[0], middle = schutte_activation(k, a, u, HILL_STAGE * h);
    x[0] = schutte_activation(k, a, u, h);
    hill_advance_fibre(&schutte_curves, k, x, middle, l, v, h);
}

static real schutte_curve(const real *k, const char *name, real x, real *slope)
{
    return hill_curve_by_name(&schutte_curves, k, name, x, slope);
}

TENSION_LAW(hill_schutte1993) = {
    .constants = HILL_CONSTANTS,
    .prepare = schutte_prepare,
    .tension = schutte_tension,
    .rates = schutte_rates,
    .start = schutte_start,
    .advance = schutte_advance,
    .curve = WHEN_OPENED(schutte_curve),
};
