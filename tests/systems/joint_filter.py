"""Paper A's filter once more, written differently on purpose: whole matrices, code and carrier in one update, every channel a state.

Differences are taken against the first channel of each group, integers found by the public search, the iterated row by the
root of one equation, the others by adding information. Nothing is kept symmetric, so that a misprinted prediction has all its effects.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from gnsslab.core.integers import constrained_integer_least_squares, integer_least_squares
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.motion import SIGMA_OPEN
from gnsslab.systems.length_row import LengthUse

GUARD = 0.1  # of the length, on each axis


class JointRun(NamedTuple):
    """What the filter found at each of T epochs, vectors in ENU."""

    baseline_float: np.ndarray  # (T, 3) [m]
    Q_float: np.ndarray  # (T, 3, 3) [m^2]
    baseline_fixed: np.ndarray  # (T, 3) [m]
    Q_fixed: np.ndarray  # (T, 3, 3) [m^2]
    velocity: np.ndarray  # (T, 3) [m/s]
    ratio: np.ndarray  # (T,)
    is_held: np.ndarray  # (T,) bool
    nis: np.ndarray  # (T,) of code and carrier together
    nis_code: np.ndarray  # (T,)
    phase_innovation: list  # of T: z (d,), S (d, d) given the codes, channels (d,), references (d,)


def run_jointly(prepared, path, settings):
    """Return the JointRun of Prepared epochs along a Path."""
    model = prepared.model
    T, c = model.usable.shape
    p = path.offset.shape[1]
    x, P, seen, fixes, rows = np.zeros(p + c), np.zeros((p + c, p + c)), np.zeros(c, bool), 0, []
    for t in range(T):
        x, P = predicted(x, P, path, t, model, settings.printed_prediction)
        for i in np.flatnonzero(model.usable[t] & (model.slip[t] | ~seen)):
            x, P = opened(x, P, p, i, model, t)
        seen |= model.usable[t]
        x, P, health = measured(x, P, p, model, t, settings.printed_residual)
        x, P = with_length(x, P, settings)
        D, _ = differences(model, t)
        b, Q_b, ratio, integers = fixed(x, P, p, D, settings)
        found = x[:3].copy(), P[:3, :3].copy(), b, Q_b, x[3:6].copy() if p == 6 else np.full(3, np.nan), ratio
        fixes = fixes + 1 if ratio >= settings.ratio else 0
        is_held = 0 < settings.hold_after <= fixes
        if is_held:
            H = np.hstack([np.zeros((len(D), p)), D])
            x, P, *_ = updated(x, P, H, integers - H @ x, settings.hold_sigma**2 * D @ D.T / 2)
        rows.append((*found, is_held, *health))
    *columns, innovations = zip(*rows, strict=True)
    return in_enu(JointRun(*map(np.array, columns), innovations), enu_rotation(prepared.master_ecef))


def in_enu(run, R):
    """Return the run with its vectors turned from ECEF."""
    turned = {
        name: np.array([R_t @ v for R_t, v in zip(R, getattr(run, name), strict=True)]) for name in ("baseline_float", "baseline_fixed", "velocity")
    }
    spread = {name: np.array([R_t @ Q @ R_t.T for R_t, Q in zip(R, getattr(run, name), strict=True)]) for name in ("Q_float", "Q_fixed")}
    return run._replace(**turned, **spread)


def predicted(x, P, path, t, model, as_printed):
    """x <- F x + u, P <- F P F' + Q, or F P + Q as (25) is printed; ambiguities measured now drift."""
    p, n = path.offset.shape[1], len(x)
    F, Q, u = np.eye(n), np.zeros((n, n)), np.zeros(n)
    F[:p, :p], Q[:p, :p], u[:p] = path.F[t], path.Q[t], path.offset[t]
    Q[range(p, n), range(p, n)] = np.where(model.usable[t], path.drift[t] / model.pair.wavelength**2, 0.0)
    if not path.F[t].any():  # all starts anew
        return F @ x + u, F @ P @ F.T + Q
    return F @ x + u, F @ P @ (np.eye(n) if as_printed else F.T) + Q


def opened(x, P, p, i, model, t):
    """Open the ambiguity of channel i at carrier minus code."""
    keep, wavelength = np.ones(len(x)), model.pair.wavelength[i]
    keep[p + i] = 0.0
    x, P = x.copy(), P * keep * keep[:, None]
    x[p + i] = (model.phase[t, i] - model.code[t, i]) / wavelength
    P[p + i, p + i] = (SIGMA_OPEN / wavelength) ** 2
    return x, P


def differences(model, t):
    """Return D (d, c) of the usable channels of an epoch and the reference (d,) of each row: the first channel of the group."""
    rows, references = [], []
    for group in np.unique(model.pair.group):
        first, *others = np.flatnonzero(model.usable[t] & (model.pair.group == group)).tolist() or [None]
        for other in others:
            rows.append(np.eye(model.usable.shape[1])[other] - np.eye(model.usable.shape[1])[first])
            references.append(first)
    return np.array(rows).reshape(-1, model.usable.shape[1]), references


def measured(x, P, p, model, t, without_range):
    """Return x, P after code and carrier together, and the health of the update."""
    D, references = differences(model, t)
    d, fill = len(D), np.nan_to_num
    B, velocity = D @ fill(model.design[t]), np.zeros((len(D), p - 3))
    H = np.vstack([np.hstack([B, velocity, 0 * D]), np.hstack([B, velocity, D * model.pair.wavelength])])
    R = np.zeros((2 * d, 2 * d))
    R[:d, :d], R[d:, d:] = (D @ np.diag(fill(sigma[t])) ** 2 @ D.T for sigma in (model.sigma_code, model.sigma_phase))
    y = np.concatenate([D @ fill(model.code[t]), D @ fill(model.phase[t])]) + np.tile(B @ model.near[t], 2)  # the measurements themselves
    z = y - H @ x
    if without_range:  # (30), (31) as printed leave rho = B b out; what the codes' update changes of b is seen by the carriers' after it
        return sequentially_without_range(x, P, H, y, R)
    x_new, P_new, S = updated(x, P, H, z, R)
    given = z[d:] - S[d:, :d] @ np.linalg.solve(S[:d, :d], z[:d])
    S_given = S[d:, d:] - S[d:, :d] @ np.linalg.solve(S[:d, :d], S[:d, d:])
    channels = [int(np.flatnonzero(row > 0)[0]) for row in D]
    return x_new, P_new, (z @ np.linalg.solve(S, z), z[:d] @ np.linalg.solve(S[:d, :d], z[:d]), (given, S_given, channels, references))


def sequentially_without_range(x, P, H, y, R):
    """Return the update by codes, then by carriers, whose residuals as printed hold the ambiguities only."""
    d, nis = len(y) // 2, []
    for part in (slice(0, d), slice(d, 2 * d)):
        z = y[part] - H[part, 6:] @ x[6:]
        x, P, S = updated(x, P, H[part], z, R[part, part])
        nis.append(z @ np.linalg.solve(S, z))
    return x, P, (sum(nis), nis[0], None)


def updated(x, P, H, z, R):
    """K = P H' (H P H' + R)^-1 (19), x + K z, (I - K H) P (20, 21)."""
    S = H @ P @ H.T + R
    K = np.linalg.solve(S.T, (P @ H.T).T).T
    return x + K @ z, P - K @ H @ P, S


def with_length(x, P, settings):
    """Return x, P after the row of the known length, where the settings have one."""
    use, length, sigma = settings.length_use, settings.length, settings.length_sigma
    b, Q = x[:3], P[:3, :3]
    if use in (LengthUse.NOWHERE, LengthUse.SEARCH) or (use == LengthUse.GUARDED_ROW and np.trace(Q) / 3 > (GUARD * length) ** 2):
        return x, P
    if use == LengthUse.ITERATED_ROW:
        at = most_likely(b, Q, length, sigma)
        return moved_to(x, P, at, informed(Q, at / np.linalg.norm(at), sigma))
    h, bias = b / np.linalg.norm(b), 0.0
    if use == LengthUse.SECOND_ORDER_ROW:
        hessian = (np.eye(3) - np.outer(h, h)) / np.linalg.norm(b)
        bias, sigma = np.trace(hessian @ Q) / 2, np.sqrt(sigma**2 + np.trace(hessian @ Q @ hessian @ Q) / 2)
    Q_new = informed(Q, h, sigma)
    return moved_to(x, P, b + Q_new @ h * (length - np.linalg.norm(b) - bias) / sigma**2, Q_new)


def most_likely(b, Q, length, sigma):
    """Return the baseline c of least cost (b - c)' Q^-1 (b - c) + (|c| - l)^2 / sigma^2.

    Where its gradient is zero c = (I + nu Q)^-1 b, nu = (|c| - l) / (sigma^2 |c|): the largest root, right of -1 over the largest eigenvalue.
    """

    def place(nu):
        return np.linalg.solve(np.eye(3) + nu * Q, b)

    def excess(nu):
        return np.linalg.norm(place(nu)) * (1 - nu * sigma**2) - length

    return place(brentq(excess, -(1 - 1e-12) / np.linalg.eigvalsh(Q)[-1], 1 / sigma**2, xtol=1e-14, rtol=1e-14))


def informed(Q, h, sigma):
    """Return the covariance after a measurement along h: information adds up."""
    return np.linalg.inv(np.linalg.inv(Q) + np.outer(h, h) / sigma**2)


def moved_to(x, P, b, Q_b):
    """Return x, P with another baseline and covariance; the other states follow by regression on the baseline."""
    G = np.linalg.solve(P[:3, :3].T, P[:, :3].T).T
    return x + G @ (b - x[:3]), P - G @ (P[:3, :3] - Q_b) @ G.T


def fixed(x, P, p, D, settings):
    """Return the baseline and its covariance given the best integers, the ratio and the integers."""
    a, Q_a, Q_ba, Q_b = D @ x[p:], D @ P[p:, p:] @ D.T, P[:3, p:] @ D.T, P[:3, :3]
    Q_a = (Q_a + Q_a.T) / 2
    if settings.length_use == LengthUse.SEARCH:
        wide = (Q_b + Q_b.T) / 2 + settings.length_sigma**2 * np.eye(3)
        solution = constrained_integer_least_squares(a, Q_a, x[:3], wide, Q_ba, settings.length)
    else:
        solution = integer_least_squares(a, Q_a)
    G = np.linalg.solve(Q_a, Q_ba.T).T
    b, Q = x[:3] - G @ (a - solution.best), Q_b - G @ Q_ba.T
    if settings.length_use == LengthUse.SEARCH:
        h, sigma = b / np.linalg.norm(b), settings.length_sigma
        Q = informed(Q, h, sigma)
        b = b + Q @ h * (settings.length - np.linalg.norm(b)) / sigma**2
    return b, Q, float(solution.ratio), solution.best
