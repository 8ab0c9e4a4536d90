"""The orthonormal frame nearest to a measured one, in the metric of a full weight matrix: kernels, from below and from above.

rho axes u_1 ... u_rho (rho = 1, 2 or 3), stacked in u (3 rho,), have been measured as u_hat with weight matrix M:

    minimise (u - u_hat)' M (u - u_hat) over u_i . u_j = delta_ij, right-handed where rho = 3

If M were a multiple of the identity a singular value decomposition would do. For other M there is no formula, and there
may be several minima. So the answer is looked for from two sides:

* From below. For any symmetric multipliers Lambda (rho, rho) with K = M + Lambda x I positive definite, the sum over i, j of
  Lambda_ij (v_i . v_j - delta_ij) is zero for every frame v, so the minimum over ALL v of

      (v - u_hat)' M (v - u_hat) + sum over i, j of Lambda_ij (v_i . v_j - delta_ij)

  is no more than the answer. It is a concave function of Lambda, whose slope is v_i . v_j - delta_ij; Newton's steps climb it.
  Wherever they stop, the value is a lower bound. For rho = 1 this is the secular equation of the sphere.
* From above. The v of the best bound is made orthonormal, and Newton's steps on the rotations go down to a minimum.

Where both meet, the minimum is proved to be the global one: the usual case where the axes nearly fit. Else the descent starts
from the 24 rotations of the cube as well (no rotation is farther than 63 degrees from all of them), and the lowest counts.
Source: Briales and Gonzalez-Jimenez (2017), CVPR (bounds of registration problems by multipliers);
Absil, Mahony and Sepulchre (2008), Optimization algorithms on matrix manifolds, chapter 6 (Newton's method on rotations).
"""

import itertools
import math
from functools import cache

import numpy as np

from gnsslab.core.jit import kernel, kernel_input, matrix, vector
from gnsslab.core.sphere import principal_axes

_MOST_CLIMBS = 30  # four to ten are usual
_MOST_DESCENTS = 200  # five to fifteen are usual; narrow valleys take more
_HOPELESS = 10.0  # a Newton step that foresees less than a tenth of what is missing will not get there in the next steps either
_SMALLEST_CLIMB = 1e-4  # part of a Newton step; shorter ones are taken only where the maximum lies on the edge of K > 0
_GAIN = 1e-12  # relative: what Newton's next step would add to a bound is rounding
_STILL = 1e-10  # [rad] a turn too small to matter
_LONGEST_TURN = 1.0  # [rad] along one axis: farther away the curvature is another
_FLAT = 1e-14  # of the largest curvature: no curvature, as about the line of antennas in line
MEETING = 1e-7  # relative, and in squared sigmas: bound and misfit are one number


@cache
def rotations_of_the_cube():
    """Return the 24 rotations (24, 9) that take a cube to itself, the rows of each one after the other, for a kernel."""
    signed = [np.diag(signs)[list(order)] for order in itertools.permutations(range(3)) for signs in itertools.product((1.0, -1.0), repeat=3)]
    return kernel_input([R.ravel() for R in signed if np.linalg.det(R) > 0])


@kernel
def nearest_frame(M, u_hat, starts, E):
    """Write the nearest frame to the rows of E (3, 3), completed to a right-handed one; returns its squared distance and the lower bound."""
    v, other = vector(len(u_hat)), matrix(3, 3)
    bound = frame_bound(M, u_hat, math.inf, v)
    orthonormalise(v, E)
    misfit = descend(M, u_hat, E)
    if misfit > bound + MEETING * (bound + 1.0):
        for start in starts:
            for j in range(9):
                other[j // 3][j % 3] = start[j]
            value = descend(M, u_hat, other)
            if value < misfit:
                misfit = value
                for j in range(9):
                    E[j // 3][j % 3] = other[j // 3][j % 3]
    return misfit, bound


@kernel
def frame_bound(M, u_hat, enough, v):
    """Return a lower bound of the squared distance from u_hat (3 rho,) to any frame, and the v (3 rho,) that goes with it.

    The climb ends early where the bound is `enough` or more, or where no step promises to bring it there.
    """
    p, rho = len(u_hat), len(u_hat) // 3
    count = rho * (rho + 1) // 2
    K, C, A, H, F = matrix(p, p), matrix(p, p), matrix(count, p), matrix(count, count), matrix(count, count)
    scratch, w, v_trial = matrix(5, count), vector(p), vector(p)
    multipliers, trial, step, off, off_hat = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4]
    conditions(u_hat, A, off_hat)
    bound = bound_by(multipliers, M, u_hat, off_hat, K, C, w, v)
    for _ in range(_MOST_CLIMBS):
        conditions(v, A, off)
        gain = climb(C, A, off, H, F, step)
        if gain <= _GAIN * bound or bound >= enough or bound + _HOPELESS * gain < enough < math.inf:
            break
        part, value = 1.0, -math.inf
        while not value > bound and part > _SMALLEST_CLIMB:
            for c in range(count):
                trial[c] = multipliers[c] + part * step[c]
            value = bound_by(trial, M, u_hat, off_hat, K, C, w, v_trial)
            part *= 0.3
        if not value > bound:
            break
        bound = value
        for c in range(count):
            multipliers[c] = trial[c]
        for i in range(p):
            v[i] = v_trial[i]
    return bound


@kernel
def conditions(u, A, off):
    """Write how far u misses each condition, off_c = u_i . u_j - delta_ij for i <= j, and half of its slope to A_c (3 rho,)."""
    rho, c = len(u) // 3, 0
    for i in range(rho):
        for j in range(i, rho):
            A_c = A[c]
            for k in range(3 * rho):
                A_c[k] = 0.0
            off[c] = -1.0 if i == j else 0.0
            for k in range(3):
                off[c] += u[3 * i + k] * u[3 * j + k]
                A_c[3 * i + k] += 0.5 * u[3 * j + k]
                A_c[3 * j + k] += 0.5 * u[3 * i + k]
            c += 1


@kernel
def bound_by(multipliers, M, u_hat, off_hat, K, C, w, v):
    """Return the bound that belongs to multipliers, minus infinity where K is not positive definite; writes K = C C' and v.

    With w = (Lambda x I) u_hat: v = u_hat - K^-1 w, and the bound is sum of lambda_c off_hat_c - w' K^-1 w.
    """
    p, rho, c, bound = len(u_hat), len(u_hat) // 3, 0, 0.0
    for i in range(p):
        w[i] = 0.0
        for j in range(i + 1):
            K[i][j] = M[i][j]
    for i in range(rho):
        for j in range(i, rho):
            half = 0.5 * multipliers[c]
            bound += multipliers[c] * off_hat[c]
            for k in range(3):
                K[3 * j + k][3 * i + k] += half if i < j else 2.0 * half
                w[3 * i + k] += half * u_hat[3 * j + k]
                w[3 * j + k] += half * u_hat[3 * i + k]
            c += 1
    if not cholesky(K, C):
        return -math.inf
    forward(C, w)
    for i in range(p):
        bound -= w[i] * w[i]
    backward(C, w)
    for i in range(p):
        v[i] = u_hat[i] - w[i]
    return bound


@kernel
def climb(C, A, off, H, F, step):
    """Write the Newton step of the multipliers, (2 A K^-1 A')^-1 off, and return off . step, twice the gain it foresees; A is used up."""
    count, gain = len(off), 0.0
    for c in range(count):
        forward(C, A[c])
        for b in range(c + 1):
            total = 0.0
            for i in range(len(C)):
                total += A[c][i] * A[b][i]
            H[c][b] = 2.0 * total
        step[c] = off[c]
    if not cholesky(H, F):
        return 0.0
    forward(F, step)
    for c in range(count):
        gain += step[c] * step[c]
    backward(F, step)
    return gain


@kernel
def descend(M, u_hat, E):
    """Turn the frame in the rows of E (3, 3) down to a minimum of its squared distance to u_hat, and return that.

    Newton's steps with the curvature taken as positive along each of its principal axes, halved until they go down.
    """
    p = len(u_hat)
    y, J, MJ, H, V, turned = vector(p), matrix(3, p), matrix(3, p), matrix(3, 3), matrix(3, 3), matrix(3, 3)
    slope, curvature, theta = vector(3), vector(3), vector(3)
    misfit = misfit_of(M, u_hat, E, y)
    for _ in range(_MOST_DESCENTS):
        curve(M, E, y, J, MJ, H, slope)
        principal_axes(H, curvature, V)
        size = newton_turn(slope, curvature, V, theta)
        value = math.inf
        while not value < misfit and size > _STILL:
            turn(E, theta, turned)
            value = misfit_of(M, u_hat, turned, y)
            size *= 0.5
            for a in range(3):
                theta[a] *= 0.5
        if not value < misfit:
            break
        misfit = value
        for j in range(9):
            E[j // 3][j % 3] = turned[j // 3][j % 3]
    return misfit


@kernel
def newton_turn(slope, curvature, V, theta):
    """Write the turn theta = sum of v (v . slope) / |curvature| over the principal axes v, rows of V, and return its size [rad]."""
    largest, square = max(abs(curvature[0]), abs(curvature[1]), abs(curvature[2])), 0.0
    for a in range(3):
        theta[a] = 0.0
    for i in range(3):
        along = V[i][0] * slope[0] + V[i][1] * slope[1] + V[i][2] * slope[2]
        along /= max(abs(curvature[i]), _FLAT * largest)
        along = max(-_LONGEST_TURN, min(_LONGEST_TURN, along))
        square += along * along
        for a in range(3):
            theta[a] += along * V[i][a]
    return math.sqrt(square)


@kernel
def misfit_of(M, u_hat, E, y):
    """Write y = M (u - u_hat) for the frame in the rows of E; returns (u - u_hat)' y."""
    p, misfit = len(u_hat), 0.0
    for i in range(p):
        y[i] = 0.0
    for j in range(p):
        off = E[j // 3][j % 3] - u_hat[j]
        for i in range(p):
            y[i] += M[i][j] * off
    for i in range(p):
        misfit += (E[i // 3][i % 3] - u_hat[i]) * y[i]
    return misfit


@kernel
def curve(M, E, y, J, MJ, H, slope):
    """Write half the curvature H (3, 3) of the misfit, and minus half its slope (3,), for turns u_j -> u_j + theta x u_j + ...

    slope = -sum of u_j x y_j,    H = J' M J + sum of (u_j y_j' + y_j u_j') / 2 - (u_j . y_j) I,    J_j = -[u_j x]
    """
    p = len(y)
    for a in range(3):
        slope[a] = 0.0
        for b in range(3):
            H[a][b] = 0.0
        for i in range(p):
            J[a][i] = 0.0
    for j in range(p // 3):
        u, y_j = E[j], (y[3 * j], y[3 * j + 1], y[3 * j + 2])
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            slope[a] -= u[b] * y_j[c] - u[c] * y_j[b]
            J[a][3 * j + b], J[a][3 * j + c] = -u[c], u[b]
            H[a][a] -= u[b] * y_j[b] + u[c] * y_j[c]
            H[a][b] += 0.5 * (u[a] * y_j[b] + u[b] * y_j[a])
            H[b][a] = H[a][b]
    for a in range(3):
        for i in range(p):
            MJ[a][i] = 0.0
            for k in range(p):
                MJ[a][i] += M[i][k] * J[a][k]
        for b in range(3):
            for i in range(p):
                H[a][b] += J[b][i] * MJ[a][i]


@kernel
def turn(E, theta, turned):
    """Write the rows of E, turned about theta by 2 arctan(|theta| / 2), which is |theta| to second order, to `turned`."""
    scale = 1.0 / math.sqrt(4.0 + theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2)
    w, x, y, z = 2.0 * scale, theta[0] * scale, theta[1] * scale, theta[2] * scale  # a unit quaternion
    for j in range(3):
        e, f = E[j], turned[j]
        a, b, c = 2.0 * (y * e[2] - z * e[1]), 2.0 * (z * e[0] - x * e[2]), 2.0 * (x * e[1] - y * e[0])
        f[0] = e[0] + w * a + y * c - z * b
        f[1] = e[1] + w * b + z * a - x * c
        f[2] = e[2] + w * c + x * b - y * a


@kernel
def orthonormalise(v, E):
    """Write the axes v (3 rho,), made orthonormal one after the other, to the rows of E, and complete a right-handed frame."""
    rho = len(v) // 3
    for j in range(2):
        for k in range(3):
            E[j][k] = v[3 * j + k] if j < rho else 0.0
    if not normalise(E[0]):
        E[0][0] = 1.0
    make_square(E[0], E[1])
    if not normalise(E[1]):
        least = 0
        for k in range(3):
            E[1][k] = 0.0
            if abs(E[0][k]) < abs(E[0][least]):
                least = k
        E[1][least] = 1.0
        make_square(E[0], E[1])
        normalise(E[1])
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        E[2][k] = E[0][i] * E[1][j] - E[0][j] * E[1][i]


@kernel
def make_square(e, x):
    """Take off x its part along the unit vector e."""
    part = e[0] * x[0] + e[1] * x[1] + e[2] * x[2]
    for k in range(3):
        x[k] -= part * e[k]


@kernel
def normalise(x):
    """Bring x (3,) to length 1; returns False where it has none."""
    length = math.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    if not length > 1e-12:
        return False
    for k in range(3):
        x[k] /= length
    return True


@kernel
def cholesky(K, C):
    """Write the lower triangular C, C C' = K, from the lower part of K; returns whether K is positive definite."""
    for i in range(len(C)):
        K_i, C_i = K[i], C[i]
        for j in range(i + 1):
            C_j, rest = C[j], K_i[j]
            for k in range(j):
                rest -= C_i[k] * C_j[k]
            if i > j:
                C_i[j] = rest / C_j[j]
            elif rest > 0.0:
                C_i[i] = math.sqrt(rest)
            else:
                return False
    return True


@kernel
def forward(C, x):
    """Replace x by C^-1 x."""
    for i in range(len(x)):
        rest, C_i = x[i], C[i]
        for k in range(i):
            rest -= C_i[k] * x[k]
        x[i] = rest / C_i[i]


@kernel
def backward(C, x):
    """Replace x by C'^-1 x."""
    for i in range(len(x) - 1, -1, -1):
        C_i = C[i]
        x[i] /= C_i[i]
        for k in range(i):
            x[k] -= C_i[k] * x[i]
