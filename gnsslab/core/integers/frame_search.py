"""The search of MC-LAMBDA: the tree of integer least squares, with an orthonormal frame below its last integer.

As in the search of C-LAMBDA (`sphere_search`) the real unknowns come first in the joint factors, so that their mean and weight
are known at each level; here they are the turned axes u of a rigid body. A branch is cut where what its integers cost so far
and the lower bound of `nearest_frame` reach the bound together.
"""

import math

from gnsslab.core.integers.search import choose_integer, insert
from gnsslab.core.integers.sphere_search import float_value
from gnsslab.core.jit import integer_matrix, kernel, matrix, vector
from gnsslab.core.nearest_frame import frame_bound, nearest_frame


@kernel
def search_frames(M, d, G, weights, q_max, u_hat, starts, bound, n_best, node_limit):
    """Search the integer vectors that cost less than the bound; returns them and their costs, best first, how many, and the nodes visited.

    M (n, n + 1): U = L' and the float values; d (n,); G (n, p): what an integer moves u; weights (n, p, p) of u given z_k ... z_n,
    and q_max (n,), the largest variance left in it; u_hat (p,), p = 3 rho. Integers and branches as in `search_on_sphere`.
    """
    n, p, last, found = len(d), len(u_hat), n_best - 1, 0
    candidates, norms = integer_matrix(n_best, n), vector(n_best)
    levels, path, E = matrix(5, n), matrix(n + 1, p), matrix(3, 3)
    z, c, e, step, above = levels[0], levels[1], levels[2], levels[3], levels[4]
    for i in range(n_best):
        norms[i] = bound
    for i in range(p):
        path[n][i] = u_hat[i]
    k, nodes, norm, down = n, 0, 0.0, True
    while nodes < node_limit:
        nodes += 1
        if down:
            k -= 1
            above[k] = norm
            c[k] = float_value(M, n, e, k)
        choose_integer(z, c, step, k, down)
        e[k] = z[k] - c[k]
        norm = above[k] + e[k] * e[k] / d[k]
        down = False
        if norm >= norms[last]:
            k += 1
            if k == n:
                break
            continue
        for i in range(p):
            path[k][i] = path[k + 1][i] + e[k] * G[k][i]
        if reaches(weights[k], q_max[k], path[k], norms[last] - norm):
            continue
        if k > 0:
            down = True
            continue
        cost = norm + nearest_frame(weights[0], path[0], starts, E)[0]
        if cost < norms[last]:
            insert(candidates, 0, norms, z, cost)
            found = min(found + 1, n_best)
    return candidates, norms, found, nodes


@kernel
def reaches(weight, q_max, u, rest):
    """Return whether every frame is farther from u (p,) than `rest`: by the lengths of the axes alone, else by the bound."""
    squares = 0.0
    for j in range(len(u) // 3):
        off = math.sqrt(u[3 * j] ** 2 + u[3 * j + 1] ** 2 + u[3 * j + 2] ** 2) - 1.0
        squares += off * off
    if squares >= rest * q_max:
        return True
    return frame_bound(weight, u, rest, vector(len(u))) >= rest
