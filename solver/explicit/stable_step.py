"""The longest stable step, 2/omega_max of the elastic sheet in its current shape.

omega_max^2 is the largest eigenvalue of M^-1 K. It is approached from below by a preconditioner-free LOBPCG (Knyazev
2001) of one vector, each round one difference of internal forces; no matrix is built. Theta + |r|, Ritz value and
norm of the residual, at least 2 %, bounds the eigenvalue it approaches from above, and gives the step. Between two
such looks the step follows the fastest triangle's wave.
"""

import numpy as np

SMALL = 1e-6  # movement in a difference of forces, relative to the mesh size
FIRST, AGAIN = 40, 12  # rounds of the first look, and of one that starts near where the last one ended
FRESH = 0.5  # of noise in that start, so that a mode that has become the fastest is not missed
CLOSE = 0.02  # residual at which a look ends, relative to the eigenvalue


class StableStep:
    """Looks at one sheet with its masses.

    sheet_pass : whose elastic forces these are; mass : (n + k,); fixed : (n + k, 3) bool
    """

    def __init__(self, sheet, sheet_pass, mass, fixed):
        self.size, self.elastic_forces = sheet.size, sheet_pass.elastic_forces
        self.root = np.where(fixed, 0.0, 1.0 / np.sqrt(mass)[:, None])
        self.vector, self.looks = None, 0

    def limit(self, u):
        """2/omega_max [s] of the sheet at places u (n + k, 3)."""
        return float(2.0 / np.sqrt(self._largest(u)))

    def recall(self, vector, root, looks):
        """Go on from where another one of this sheet was after some looks, with its vector and root."""
        self.vector, self.root, self.looks = vector, root, looks

    def _largest(self, u):
        self.start = self.elastic_forces(u)
        x = np.random.default_rng(self.looks).standard_normal(self.root.shape) * (self.root > 0.0)
        self.looks += 1
        x /= np.linalg.norm(x)
        rounds = FIRST if self.vector is None else AGAIN
        if self.vector is not None:
            x = self.vector + FRESH * x
            x /= np.linalg.norm(x)
        ax = self._apply(x, u)
        p = ap = np.zeros_like(x)
        for _ in range(rounds):
            theta = np.vdot(x, ax)
            r = ax - theta * x
            rest = np.linalg.norm(r)
            if rest <= CLOSE * theta:
                break
            r /= rest
            basis, images = [x, r], [ax, self._apply(r, u)]
            for q, aq in zip(basis[:2], images[:2], strict=True):
                part = np.vdot(q, p)
                p, ap = p - part * q, ap - part * aq
            size = np.linalg.norm(p)
            if size > 1e-8:
                basis.append(p / size)
                images.append(ap / size)
            small = np.array([[np.vdot(q, aq) for aq in images] for q in basis])
            weight = np.linalg.eigh(0.5 * (small + small.T))[1][:, -1]
            p = sum(w * q for w, q in zip(weight[1:], basis[1:], strict=True))
            ap = sum(w * aq for w, aq in zip(weight[1:], images[1:], strict=True))
            x, ax = weight[0] * x + p, weight[0] * ax + ap
            size = np.linalg.norm(x)
            x, ax = x / size, ax / size
        self.vector = x
        theta = np.vdot(x, ax)
        return theta + max(np.linalg.norm(ax - theta * x), CLOSE * theta)

    def _apply(self, vector, u):
        """M^-1/2 K M^-1/2 times a vector, by a difference of forces."""
        movement = self.root * vector
        step = SMALL * self.size / np.abs(movement).max()
        return self.root * (self.elastic_forces(u + step * movement) - self.start) / step
