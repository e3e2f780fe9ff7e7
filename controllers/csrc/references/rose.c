/* A rose curve (the flower), traversed once from rest to rest:

     y = c + R cos(k phi) u,    u = cos(phi) e1 + sin(phi) e2,    phi = phi_end s(t/T) */
#include "references.h"

#include "../../../sim_dart/csrc/math/elementary.h"

/* With v = u', v' = -u and rho = R cos(k phi):
     dy/dphi = rho' u + rho v,    d2y/dphi2 = -(k^2 + 1) rho u + 2 rho' v                               */
void rose_at(const reference_part *part, real t, real *rows)
{
    const size_t r = part->r;
    const real *centre = part->data, *e1 = centre + r, *e2 = e1 + r;
    const real R = e2[r], k = e2[r + 1], last = e2[r + 2];
    real s[3], sn, cs, ksn, kcs;
    quintic(t, part->duration, s);
    const real phi = last * s[0], phid = last * s[1], phidd = last * s[2];
    sine_cosine(phi, &sn, &cs);
    sine_cosine(k * phi, &ksn, &kcs);
    const real rho = R * kcs, rho_rate = -R * k * ksn;
    for (size_t i = 0; i < r; i++) {
        const real u = cs * e1[i] + sn * e2[i], v = cs * e2[i] - sn * e1[i];
        const real first = rho_rate * u + rho * v;
        const real second = -(k * k + 1) * rho * u + 2 * rho_rate * v;
        rows[i] = centre[i] + rho * u;
        rows[r + i] = first * phid;
        rows[2 * r + i] = second * phid * phid + first * phidd;
    }
}
