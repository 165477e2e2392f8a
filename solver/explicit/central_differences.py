"""Central differences with a variable step (seed Eq. 16 to 18), and where the energy of a step goes.

Symbols: u places (n + k, 3) of nodes and slopes; v their velocities half a step before, and half a step after;
dt the step from u to the new u, dtm the mean of this step and the last one, m masses (n + k,).

    v_new = v + dtm (f_ext - f_int)/m,   u_new = u + dt v_new

A force f changes the kinetic energy of m v^2/2 at the half steps by f (v + v_new)/2 dtm exactly: the work of every
force is counted so, and no term of the balance is a remainder of the others. Sums run in chunks of fixed size, so
that they have the same bits on any number of threads.
"""

from math import exp

from numba import njit, prange

CHUNK = 256


def n_chunks(count):
    """Chunks that hold `count` rows."""
    return (count + CHUNK - 1) // CHUNK


@njit(parallel=True, cache=True)
def predict(u, v, mass, external, internal, fixed, movement, progress, dt, dtm, damping, u_new, v_new):
    """Fills v_new and u_new (n + k, 3), as they are without contact.

    fixed : (n + k, 3) bool, unknowns that move by movement (n + k, 3) [mm] per progress; damping : [1/s]
    """
    keep, gain = (1.0 - 0.5 * damping * dtm) / (1.0 + 0.5 * damping * dtm), dtm / (1.0 + 0.5 * damping * dtm)
    for row in prange(u.shape[0]):
        for c in range(3):
            if fixed[row, c]:
                v_new[row, c] = movement[row, c] * progress / dt
            else:
                v_new[row, c] = keep * v[row, c] + gain * (external[row, c] - internal[row, c]) / mass[row]
            u_new[row, c] = u[row, c] + dt * v_new[row, c]


@njit(parallel=True, cache=True)
def account(v, v_new, mass, external, internal, fixed, dtm, damping, sums):
    """Fills sums (chunks, 3): kinetic energy half a step on, work of loads and supports, work of damping [mJ]."""
    n = v.shape[0]
    for chunk in prange(sums.shape[0]):
        kinetic = outside = damped = 0.0
        for row in range(chunk * CHUNK, min((chunk + 1) * CHUNK, n)):
            m = mass[row]
            for c in range(3):
                a, b = v[row, c], v_new[row, c]
                path = 0.5 * (a + b) * dtm
                kinetic += 0.5 * m * b * b
                outside += external[row, c] * path
                if fixed[row, c]:
                    outside += (m * (b - a) / dtm + internal[row, c] - external[row, c]) * path
                else:
                    damped += damping * m * 0.5 * (a + b) * path
        sums[chunk, 0], sums[chunk, 1], sums[chunk, 2] = kinetic, outside, damped


@njit(parallel=True, cache=True)
def through_thickness(stress, stress_new, strain, strain_new, plastic, weight, volume, initial, thickness, sums):
    """Fills thickness (m,) [mm], and sums (chunks,) with the work of the stresses over the step [mJ].

    stress, strain, plastic (p, 3) of the points, layer by layer; weight (layers,) sums to 1; volume : (m,);
    initial : thickness

    The thickness is what it would be unloaded. Contact that followed the elastic part, some 1e-4 of it, a step late,
    would let an edge pressed against a wall feed on its own waves.
    """
    n_layers, m, plastic = weight.shape[0], thickness.shape[0], plastic.reshape(-1)
    stress, stress_new, strain, strain_new = (
        stress.reshape(-1), stress_new.reshape(-1), strain.reshape(-1), strain_new.reshape(-1)
    )  # fmt: skip
    for chunk in prange(sums.shape[0]):
        total = 0.0
        for tri in range(chunk * CHUNK, min((chunk + 1) * CHUNK, m)):
            mean = work = 0.0
            for layer in range(n_layers):
                w, i = weight[layer], 3 * (tri * n_layers + layer)
                j, k = i + 1, i + 2
                mean -= w * (plastic[i] + plastic[j])
                density = (stress[i] + stress_new[i]) * (strain_new[i] - strain[i])
                density += (stress[j] + stress_new[j]) * (strain_new[j] - strain[j])
                work += w * (density + (stress[k] + stress_new[k]) * (strain_new[k] - strain[k]))
            thickness[tri] = initial * exp(mean)
            total += 0.5 * volume[tri] * work
        sums[chunk] = total
