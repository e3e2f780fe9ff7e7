/* Inverse dynamics by the Newton-Euler method, C and G; the mass matrix by composite bodies; J' qd. */
#include "inverse.h"

#include "../kinematics/bodies.h"
#include "../kinematics/joint_variables.h"
#include "../laws/laws.h"
#include "limit_forces.h"
#include "spatial.h"

#include <string.h>

/* Compute the wrench of frame i for its acceleration and angular velocity:
     f = m a + alpha x c + w x (w x c),   n = I alpha + c x a + w x I w,   with c = m r */
static void newton_euler(const core *c, int32_t i, const real acceleration[6], const real spin[3],
                         real wrench[6])
{
    const real *centre = c->centre + 3 * i, *moment = c->moment + 9 * i;
    const real *alpha = acceleration, *a = acceleration + 3;
    real Iw[3];
    for (int k = 0; k < 3; k++) wrench[3 + k] = c->blob.mass[i] * a[k];
    add_cross3(wrench + 3, alpha, centre);
    add_centripetal(wrench + 3, spin, centre);
    rotate3(wrench, moment, alpha);
    add_cross3(wrench, centre, a);
    rotate3(Iw, moment, spin);
    add_cross3(wrench, spin, Iw);
}

/* Project the wrenches of all frames on the variables, passing each wrench on to the parent. The result is
   in `forces`, or in a row that the caller must fold into `forces`. */
static real *collect(core *c, real *forces)
{
    if (c->is_driven) memset(forces = c->row, 0, (size_t)c->blob.counts.variables * sizeof(real));
    for (int32_t i = c->blob.counts.frames - 1; i >= 0; i--) {
        const int32_t parent = c->blob.parent[i];
        forces[c->blob.coordinate[i]] = generalised_force(c, i, c->wrench + 6 * i);
        if (parent >= 0) add_to_parent(c, i, c->wrench + 6 * i, c->wrench + 6 * parent);
    }
    return forces;
}

/* Add the springs of joints and the weight of heavy cables, about half of it at either end. */
static void add_static_forces(const core *c, real *forces)
{
    if (c->has_weight) laws_weigh(c, NULL, -1, forces);
    for (int32_t j = 0; j < c->blob.counts.variables; j++)
        forces[j] += c->blob.stiffness[j] * (c->at[j] - c->blob.rest[j]);
    for (int32_t l = 0; l < c->blob.counts.limit_forces; l++) {
        const limit_force f = limit_force_at(c, l);
        forces[c->blob.limit_variable[l]] += f.stiffness * f.beyond;
    }
}

void core_gravity(core *c)
{
    static const real still[3] = {0, 0, 0};
    const real *g = c->blob.gravity;
    const real up[6] = {0, 0, 0, -g[0], -g[1], -g[2]};
    bodies_links(c);
    bodies_inertias(c);
    for (int32_t i = 0; i < c->blob.counts.frames; i++) newton_euler(c, i, up, still, c->wrench + 6 * i);
    real *forces = collect(c, c->gravity);
    add_static_forces(c, forces);
    if (c->is_driven) variables_fold(c, forces, c->gravity);
}

/* Compute the forces at qdd = 0 in a world with the acceleration `world`; returns the same as `collect`. */
static real *zero_acceleration_forces(core *c, const real *qd, const real world[3], real *forces)
{
    bodies_links(c);
    bodies_inertias(c);
    bodies_velocities(c, qd);
    for (int32_t i = 0; i < c->blob.counts.frames; i++) {
        real *acceleration = c->acceleration + 6 * i;
        bodies_parent_acceleration(c, i, c->acceleration, acceleration);
        if (c->blob.parent[i] < 0) add3(acceleration + 3, world);
        add3(acceleration, c->drift + 6 * i);
        add3(acceleration + 3, c->drift + 6 * i + 3);
        newton_euler(c, i, acceleration, c->spin + 3 * i, c->wrench + 6 * i);
    }
    forces = collect(c, forces);
    for (int32_t j = c->blob.counts.dofs; j < c->blob.counts.variables; j++)
        forces[j] += c->blob.armature[j] * c->bend[j];
    return forces;
}

void core_coriolis(core *c, const real *qd)
{
    static const real still[3] = {0, 0, 0};
    real *forces = zero_acceleration_forces(c, qd, still, c->coriolis);
    if (c->is_driven) variables_fold(c, forces, c->coriolis);
}

void core_bias(core *c, const real *qd)
{
    const real *g = c->blob.gravity, up[3] = {-g[0], -g[1], -g[2]};
    real *forces = zero_acceleration_forces(c, qd, up, c->coriolis);
    add_static_forces(c, forces);
    if (c->is_driven) variables_fold(c, forces, c->coriolis);
}

void inverse_fall(core *c, const real *qd, real *forces)
{
    const real *g = c->blob.gravity, up[3] = {-g[0], -g[1], -g[2]};
    variables_fold(c, zero_acceleration_forces(c, qd, up, forces), forces);
}

/* Add the moments of a composite body about the origin of frame i to its parent:
     I + 2 (c.r) 1 - c r' - r c' + m (r.r 1 - r r') */
static void add_composite(core *c, int32_t i, real *mass)
{
    const int32_t parent = c->blob.parent[i];
    const real *r = c->link + 3 * i, *centre = c->centre + 3 * i, m = mass[i];
    const real *from = c->moment + 9 * i;
    real *to = c->moment + 9 * parent;
    const real trace = 2 * dot3(centre, r) + m * dot3(r, r);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            to[3 * a + b] += from[3 * a + b] - centre[a] * r[b] - r[a] * centre[b] - m * r[a] * r[b] +
                             (a == b ? trace : 0);
    for (int k = 0; k < 3; k++) c->centre[3 * parent + k] += centre[k] + m * r[k];
    mass[parent] += m;
}

/* Compute the wrench on a composite body for a unit acceleration of the motion of its frame. */
static void unit_wrench(const core *c, int32_t i, real mass, real wrench[6])
{
    const real *axis = c->axis + 3 * i, *centre = c->centre + 3 * i;
    if (c->blob.motion[i] == ROTATION) {
        rotate3(wrench, c->moment + 9 * i, axis);
        cross3(wrench + 3, axis, centre);
    } else {
        cross3(wrench, centre, axis);
        for (int k = 0; k < 3; k++) wrench[3 + k] = mass * axis[k];
    }
}

void inverse_mass(core *c, const real *armature, real *matrix)
{
    const size_t width = (size_t)c->blob.counts.variables;
    real *mass = c->drive, *entries = c->is_driven ? c->wide_matrix : matrix;
    bodies_links(c);
    bodies_inertias(c);
    memcpy(mass, c->blob.mass, (size_t)c->blob.counts.frames * sizeof(real));
    memset(entries, 0, width * width * sizeof(real));
    for (int32_t i = c->blob.counts.frames - 1; i >= 0; i--) {
        real wrench[6];
        unit_wrench(c, i, mass[i], wrench);
        const size_t row = (size_t)c->blob.coordinate[i];
        for (int32_t j = i; j >= 0; j = c->blob.parent[j]) {
            const size_t column = (size_t)c->blob.coordinate[j];
            const real entry = generalised_force(c, j, wrench);
            entries[row * width + column] = entries[column * width + row] = entry;
            add_cross3(wrench, c->link + 3 * j, wrench + 3); /* about the origin of the parent */
        }
        if (c->blob.parent[i] >= 0) add_composite(c, i, mass);
    }
    for (size_t j = 0; j < width; j++) entries[j * width + j] += armature[j];
    if (c->is_driven) variables_fold_matrix(c, matrix);
}

void core_mass_matrix(core *c)
{
    inverse_mass(c, c->blob.armature, c->mass_matrix);
}
