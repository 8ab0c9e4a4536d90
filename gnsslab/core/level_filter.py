"""A level that drifts under coloured noise: Kalman filter of one axis, as small kernels on a row of numbers.

    z = x + u + v
    x <- x + r dt
    r <- r + walk, of variance q an epoch, more where r is large
    u <- a u + new, a = exp(-dt / tau), of variance c in the long run

x level, r its rate, u coloured noise, v white noise of variance w. A state is the row [x, r, u, P_xx, P_xr, P_xu, P_rr, P_ru, P_uu],
a noise the row [w, c, tau, q]; times count in epochs. A position has one such row an axis.
"""

import math

from gnsslab.core.jit import kernel

LEVEL, RATE, COLOUR, P_XX, P_XR, P_XU, P_RR, P_RU, P_UU = range(9)
WHITE, COLOURED, CORRELATION, WALK = range(4)
STATE_SIZE = 9
CHANGE_OF_RATE = 0.03  # of a rate, an epoch: what moves fast changes its speed sooner than what rests
SURE = 3.0  # [sigma] of a rate: the part below may be noise


@kernel
def predict(state, noise, dt):
    """Move a state dt epochs on, in place; return what is left of its coloured error, a.

    >>> import numpy as np
    >>> state = np.array([1.0, 0.25, 0.5, 1.0, 0.0, 0.0, 0.25, 0.0, 0.0])
    >>> a = predict(state, np.array([1.0, 4.0, 2.0, 0.0]), 2.0)
    >>> round(a, 6), state.round(6).tolist()  # a = exp(-1), and 4 (1 - a^2)
    (0.367879, [1.5, 0.25, 0.18394, 2.0, 0.5, 0.0, 0.25, 0.0, 3.458659])
    """
    a, q = math.exp(-dt / noise[CORRELATION]), noise[WALK]
    q += (CHANGE_OF_RATE * max(0.0, abs(state[RATE]) - SURE * math.sqrt(state[P_RR]))) ** 2
    state[LEVEL] += dt * state[RATE]
    state[COLOUR] *= a
    state[P_XX] += 2.0 * dt * state[P_XR] + dt * dt * state[P_RR] + q * dt * dt * dt / 3.0
    state[P_XR] += dt * state[P_RR] + q * dt * dt / 2.0
    state[P_XU] = a * (state[P_XU] + dt * state[P_RU])
    state[P_RR] += q * dt
    state[P_RU] *= a
    state[P_UU] = a * a * state[P_UU] + (1.0 - a * a) * noise[COLOURED]
    return a


@kernel
def innovation_variance(state, noise):
    """Return S = P_xx + 2 P_xu + P_uu + w."""
    return state[P_XX] + 2.0 * state[P_XU] + state[P_UU] + noise[WHITE]


@kernel
def innovation(state, z):
    """Return z - x - u."""
    return z - state[LEVEL] - state[COLOUR]


@kernel
def gains(state, S):
    """Return how much of an innovation of variance S level, rate and coloured noise take up."""
    return (state[P_XX] + state[P_XU]) / S, (state[P_XR] + state[P_RU]) / S, (state[P_XU] + state[P_UU]) / S


@kernel
def update(state, S, v):
    """Take up an innovation v of variance S, in place.

    >>> import numpy as np
    >>> state = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    >>> update(state, 4.0, 2.0)
    >>> state.tolist()
    [0.5, 0.0, 0.5, 0.75, 0.0, -0.25, 0.0, 0.0, 0.75]
    """
    on_level, on_rate, on_colour = gains(state, S)
    state[LEVEL] += on_level * v
    state[RATE] += on_rate * v
    state[COLOUR] += on_colour * v
    state[P_XX] -= on_level * on_level * S
    state[P_XR] -= on_level * on_rate * S
    state[P_XU] -= on_level * on_colour * S
    state[P_RR] -= on_rate * on_rate * S
    state[P_RU] -= on_rate * on_colour * S
    state[P_UU] -= on_colour * on_colour * S
