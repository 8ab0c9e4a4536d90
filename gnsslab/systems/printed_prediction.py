"""The filter's prediction as printed in paper A, equation (25), misprint and all: for comparison only.

The mended form is `core.kalman.predict`. It is a kernel, so that the paper's filter can be run with it.
"""

from gnsslab.core.jit import kernel, matrix
from gnsslab.core.kalman import add_multiple


@kernel
def predict_as_printed(x, P, F, Q, offset):
    """Move x and P one step on, in place, by P <- F P + Q: a factor F' is missing.

    F P is not symmetric: the example's is [[1.3, 2.3], [0.3, 2.0]]. The gain K = P H' (19) reads the columns of what is measured,
    which is never the velocity. So the half below the diagonal counts, and the other one is set alike. There the velocity
    has no part in what happens to the baseline: it is never learnt, and nothing loosens the baseline. Of the first p states only,
    as in `core.kalman.predict`: x_p <- F x_p + offset. The correlations with the others go F P as they should.

    >>> import numpy as np
    >>> x, P = np.zeros(2), np.array([[1.0, 0.3], [0.3, 2.0]])
    >>> predict_as_printed(x, P, np.array([[1.0, 1.0], [0.0, 1.0]]), np.zeros((2, 2)), np.zeros(2))
    >>> P.tolist()                     # right is [[3.6, 2.3], [2.3, 2.0]]
    [[1.3, 0.3], [0.3, 2.0]]
    """
    p, n = len(offset), len(x)
    moved = matrix(p, n + 1)  # F [P_p, x_p]
    for i in range(p):
        for j in range(p):
            add_multiple(moved[i], P[j], F[i][j])
            moved[i][n] += F[i][j] * x[j]
    for i in range(p):
        x[i] = moved[i][n] + offset[i]
        for j in range(i + 1):
            P[i][j] = P[j][i] = moved[i][j] + Q[i][j]
        for j in range(p, n):
            P[i][j] = P[j][i] = moved[i][j]
