"""The pressure under which a sheet flows across its thickness.

No pressure of all sides makes metal flow, so a pressure p through the thickness does what equal tensions p in the
sheet's plane do: a free sheet flows under the equibiaxial flow stress, and so does one that flows already under a
compression of that size along one direction.
"""

import numpy as np

FIRST, FURTHER = np.geomspace(2e-4, 0.02, 30), np.arange(0.03, 1.0, 0.01)  # strains of the test


def flow_pressure(law):
    """What a law says of a sheet stretched alike in all directions: equivalent plastic strains (k,), from 0 on, and the
    mean stress (k,) [MPa] in its plane; inf where it does not flow.

    law : any material of the solver
    """
    old, new = law.new_state(1), law.new_state(1)
    equivalent, stress = [], []
    for strain in (*FIRST, *FURTHER):
        stretch = np.exp(2.0 * strain)
        law.update(np.array([[stretch, stretch, 0.0]]), old, new, tangent=False)
        old, new = new, old
        if old.equivalent[0] > 0.0:
            equivalent.append(float(old.equivalent[0]))
            stress.append(0.5 * float(old.stress[0, 0] + old.stress[0, 1]))
    if not equivalent:
        return np.zeros(1), np.full(1, np.inf)
    equivalent[0] = 0.0  # the flow sets in within the first of these small steps
    # Contact knows no falling force: metal that softens is taken to bear on what it bore.
    return np.array(equivalent), np.maximum.accumulate(stress)
