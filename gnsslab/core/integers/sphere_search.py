"""The search of C-LAMBDA: the tree of integer least squares, with a baseline on a sphere below its last integer.

Ambiguities and baseline have one joint covariance. With the baseline as the first variables its factors are those of Q_a,
and one row G_i (p,) more for each integer:

    b given z_k ... z_n  =  b_hat + sum over i >= k of (z_i - c_i) G_i,    Q_k = Q_b - sum over i >= k of d_i G_i G_i'

    Q_zb = L' diag(d) G,    z = Z' a
"""

import math

from gnsslab.core.integers.decorrelation import GOOD, factor, reduce
from gnsslab.core.integers.search import choose_integer, insert, restore, split
from gnsslab.core.jit import cube, integer_matrix, kernel, matrix
from gnsslab.core.sphere import principal_axes, sphere_kernel

NOT_JOINTLY_POSITIVE = -10  # beside the statuses of decorrelation and of `split`
_LONGEST = 64.0  # entries of L left as they are; see `search`
_GROWTH = 2.0  # of the bound: one twice too large costs 2^(n/2) times the nodes, one too small another pass
_SAFELY = 1 + 1e-9  # a bound is exclusive, and known but for rounding
_ROUNDING = 1e-13  # of a variance of b: rounding leaves this much of one that is zero


@kernel
def fix_groups_on_sphere(a, Q_a, b, Q_b, Q_ba, length, bounds, n_best, node_limit):
    """Fix a (groups, m, n), b (groups, m, p), the m of a group sharing Q_a (n, n), Q_b (p, p), Q_ba (p, n), decorrelated once.

    bounds (groups, m) are the first ones; where fewer than n_best vectors cost less, the bound expands: to the least cost of the
    best one's neighbours where one is missing (a second best is often thousands of times worse), else by steps. Returns candidates
    (groups m n_best, n), norms (groups m, n_best), nodes (groups m, 1), baselines (groups m n_best, p), status and group.
    """
    groups = len(Q_a)
    n, p, m = (len(Q_a[0]), len(Q_b[0]), len(a[0])) if groups > 0 else (0, 0, 0)
    rows = groups * m
    candidates, norms, nodes, baselines = integer_matrix(rows * n_best, n), matrix(rows, n_best), integer_matrix(rows, 1), matrix(rows * n_best, p)
    M, W, d, G = matrix(n, n + m + p), matrix(n, n), matrix(1, n)[0], matrix(n, p)
    spread, axes, levels, path = matrix(n, p), cube(n, p, p), matrix(5, n), matrix(n + 3, p)
    for group in range(groups):
        status = prepare(a[group], Q_a[group], Q_b[group], Q_ba[group], M, W, d, G, spread, axes)
        if status != GOOD:
            return candidates, norms, nodes, baselines, status, group
        for v in range(m):
            row, bound = group * m + v, bounds[group][v]
            first, found = row * n_best, 0
            for j in range(p):
                path[n][j] = b[group][v][j]
            while found < n_best and nodes[row][0] < node_limit:
                rest = node_limit - nodes[row][0]
                found, passed = search_on_sphere(M, n + v, d, G, spread, axes, levels, path, length, bound, candidates, first, norms[row], rest)
                nodes[row][0] += passed
                beyond = math.inf
                if found > 0 and found == n_best - 1:
                    beyond = neighbour_beyond(M, n + v, d, G, spread, axes, levels, path, length, candidates[first], bound) * _SAFELY
                bound = beyond if beyond < math.inf else bound * _GROWTH
            for i in range(found, n_best):
                norms[row][i] = math.inf
                for j in range(p):
                    baselines[first + i][j] = math.nan
            for i in range(first, first + found):
                land(M, n + v, d, G, spread, axes, levels, path, length, candidates[i], baselines[i])
            for i in range(first, first + n_best):
                restore(candidates, i, a[group], v, W, levels[0], levels[1])
    return candidates, norms, nodes, baselines, GOOD, groups


@kernel
def prepare(a, Q_a, Q_b, Q_ba, M, W, d, G, spread, axes):
    """Decorrelate one group, and find at each level how b hangs on the integer there and how it is spread below; returns a status."""
    n, p, m = len(W), len(Q_b), len(a)
    status = split(a, M)
    for k in range(n):
        for j in range(p):
            M[k][n + m + j] = Q_ba[j][k]
    if status == GOOD:
        status = factor(Q_a, M, W, d)
    if status == GOOD:
        status = reduce(M, W, d, _LONGEST)
    if status == GOOD:
        solve_gains(M, d, G)
        status = spread_below(Q_b, d, G, spread, axes)
    return status


@kernel
def solve_gains(M, d, G):
    """Solve L' diag(d) G = Q_zb, whose right side stands in the last columns of M, from the last row up."""
    n, p = len(G), len(G[0])
    behind = len(M[0]) - p
    for k in range(n - 1, -1, -1):
        for j in range(p):
            rest = M[k][behind + j]
            for i in range(k + 1, n):
                rest -= M[k][i] * d[i] * G[i][j]
            G[k][j] = rest / d[k]


@kernel
def spread_below(Q_b, d, G, spread, axes):
    """Write the variances (n, p) and principal axes (n, p, p) of b given z_k ... z_n, k the level; returns a status."""
    n, p = len(G), len(Q_b)
    Q, turned = matrix(p, p), matrix(p, p)
    for i in range(p):
        for j in range(p):
            Q[i][j] = 0.5 * (Q_b[i][j] + Q_b[j][i])
    for k in range(n - 1, -1, -1):
        for i in range(p):
            for j in range(p):
                Q[i][j] -= d[k] * G[k][i] * G[k][j]
                turned[i][j] = Q[i][j]
        principal_axes(turned, spread[k], axes[k])
        for i in range(p):
            if not spread[k][i] > _ROUNDING * Q_b[i][i]:
                return NOT_JOINTLY_POSITIVE
    return GOOD


@kernel
def search_on_sphere(M, column, d, G, spread, axes, levels, path, length, bound, candidates, first, norms, node_limit):
    """Search the vectors that cost less than the bound; writes them and their costs, best first; returns how many, and the nodes visited.

    The float values stand in a column of M (n, ...), b_hat in path[n]; path[k] becomes b given z_k ... z_n. At each level the
    integers come in the order of their distance to the float value. Too far ends a level; off the sphere ends a branch.
    """
    z, c, e, step, above = levels[0], levels[1], levels[2], levels[3], levels[4]
    n, last, found = len(d), len(norms) - 1, 0
    for i in range(last + 1):
        norms[i] = bound
    k, nodes, norm, down = n, 0, 0.0, True
    while nodes < node_limit:
        nodes += 1
        if down:
            k -= 1
            above[k] = norm
            c[k] = float_value(M, column, e, k)
        choose_integer(z, c, step, k, down)
        e[k] = z[k] - c[k]
        norm = above[k] + e[k] * e[k] / d[k]
        down = False
        if norm >= norms[last]:
            k += 1
            if k == n:
                break
            continue
        cost = norm + cost_on_sphere(k, e[k], G, spread, axes, path, length, norms[last] - norm)
        if cost < norms[last]:
            if k == 0:
                insert(candidates, first, norms, z, cost)
                found = min(found + 1, last + 1)
            else:
                down = True
    return found, nodes


@kernel
def float_value(M, column, e, k):
    """Return c_k = z_hat_k + sum over i > k of (z_i - c_i) L_ik."""
    c, row = M[k][column], M[k]
    for i in range(k + 1, len(e)):
        c += e[i] * row[i]
    return c


@kernel
def cost_on_sphere(k, e_k, G, spread, axes, path, length, rest):
    """Return the least cost of putting b, given z_k ... z_n, on the sphere; infinite where it is `rest` or more for certain.

    (|b| - l)^2 / q_max <= cost <= (|b| - l)^2 / q_min: where these decide whether a branch is cut the cost itself does not matter, but
    at the last level. path[k] becomes b's mean; the two rows behind path[n] are scratch.
    """
    p, n = len(path[0]), len(G)
    b, above, turned, q = path[k], path[k + 1], path[n + 1], spread[k]
    square, q_max, q_min = 0.0, 0.0, math.inf
    for j in range(p):
        b[j] = above[j] + e_k * G[k][j]
        square += b[j] * b[j]
        q_max, q_min = max(q_max, q[j]), min(q_min, q[j])
    off = math.sqrt(square) - length
    if off * off >= rest * q_max:
        return math.inf
    if k > 0 and off * off < rest * q_min:
        return 0.0
    turn(axes[k], b, turned)
    return sphere_kernel(turned, q, length, path[n + 2])


@kernel
def turn(V, b, turned):
    """Write V b to `turned`: the coordinates of b along the rows of V."""
    for i in range(len(V)):
        total = 0.0
        for j in range(len(b)):
            total += V[i][j] * b[j]
        turned[i] = total


@kernel
def neighbour_beyond(M, column, d, G, spread, axes, levels, path, length, candidate, bound):
    """Return the least cost, of those not below the bound, of the neighbours of a candidate z (n,): one integer moved by one, either way."""
    least = math.inf
    descend(M, column, d, G, levels, path, candidate, len(d) - 1, math.inf)
    for i in range(len(d)):  # from the bottom up: what stands above a level stays right
        for move in (1, -2):
            candidate[i] += move
            norm = descend(M, column, d, G, levels, path, candidate, i, least)
            if norm < least:
                turn(axes[0], path[0], path[len(d) + 1])
                cost = norm + sphere_kernel(path[len(d) + 1], spread[0], length, path[len(d) + 2])
                least = cost if bound <= cost < least else least
        candidate[i] += 1
    return least


@kernel
def descend(M, column, d, G, levels, path, candidate, top, most):
    """Write b given z_k ... z_n to path[k] for each level from the top one down; returns the squared distance, infinite where it reaches `most`.

    What stands in `levels` and `path` above the top one must be the candidate's, z (n,), already.
    """
    e, above = levels[2], levels[4]
    norm = above[top] if top < len(d) - 1 else 0.0
    for k in range(top, -1, -1):
        above[k] = norm
        e[k] = candidate[k] - float_value(M, column, e, k)
        norm += e[k] * e[k] / d[k]
        if norm >= most:
            return math.inf
        for j in range(len(path[k])):
            path[k][j] = path[k + 1][j] + e[k] * G[k][j]
    return norm


@kernel
def land(M, column, d, G, spread, axes, levels, path, length, candidate, baseline):
    """Write the baseline (p,) on the sphere that goes with a candidate z (n,)."""
    n, p = len(G), len(baseline)
    descend(M, column, d, G, levels, path, candidate, n - 1, math.inf)
    turn(axes[0], path[0], path[n + 1])
    sphere_kernel(path[n + 1], spread[0], length, path[n + 2])
    for j in range(p):
        baseline[j] = 0.0
        for i in range(p):
            baseline[j] += axes[0][i][j] * path[n + 2][i]
