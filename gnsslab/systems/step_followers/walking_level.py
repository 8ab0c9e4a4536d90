"""A level that walks under coloured noise: Kalman filter of one axis, as small kernels on a row of numbers.

    z = x + u + v,    x <- x + walk (variance q an epoch),    u <- a u + ..., a = exp(-dt / tau), variance c in the long run,    v white, variance w

A state is the row [x, u, P_xx, P_xu, P_uu], a noise the row [w, c, tau, q]; times count in epochs. A position has one such row an axis.
"""

import math

from gnsslab.core.jit import kernel

LEVEL, COLOUR, P_LEVEL, P_BOTH, P_COLOUR = range(5)
WHITE, COLOURED, CORRELATION, WALK = range(4)
STATE_SIZE = 5


@kernel
def predict(state, noise, dt):
    """Move a state dt epochs on, in place; return what is left of its coloured error, a.

    >>> import numpy as np
    >>> state = np.array([1.0, 0.5, 0.0, 0.0, 0.0])
    >>> a = predict(state, np.array([1.0, 4.0, 2.0, 0.25]), 2.0)
    >>> round(a, 6), state.round(6).tolist()  # a = exp(-1), and 4 (1 - a^2)
    (0.367879, [1.0, 0.18394, 0.5, 0.0, 3.458659])
    """
    a = math.exp(-dt / noise[CORRELATION])
    state[COLOUR] *= a
    state[P_LEVEL] += dt * noise[WALK]
    state[P_BOTH] *= a
    state[P_COLOUR] = a * a * state[P_COLOUR] + (1.0 - a * a) * noise[COLOURED]
    return a


@kernel
def innovation_variance(state, noise):
    """Return S = P_xx + 2 P_xu + P_uu + w."""
    return state[P_LEVEL] + 2.0 * state[P_BOTH] + state[P_COLOUR] + noise[WHITE]


@kernel
def innovation(state, z):
    """Return z - x - u."""
    return z - state[LEVEL] - state[COLOUR]


@kernel
def update(state, S, v):
    """Take up an innovation v of variance S, in place.

    >>> import numpy as np
    >>> state = np.array([0.0, 0.0, 1.0, 0.0, 1.0])
    >>> update(state, 4.0, 2.0)
    >>> state.tolist()
    [0.5, 0.5, 0.75, -0.25, 0.75]
    """
    on_level, on_colour = state[P_LEVEL] + state[P_BOTH], state[P_BOTH] + state[P_COLOUR]
    state[LEVEL] += on_level / S * v
    state[COLOUR] += on_colour / S * v
    state[P_LEVEL] -= on_level * on_level / S
    state[P_BOTH] -= on_level * on_colour / S
    state[P_COLOUR] -= on_colour * on_colour / S
