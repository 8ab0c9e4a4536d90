"""How often a fix is right: the success rate of bootstrapping, and ADOP."""

import math

import numpy as np

from gnsslab.core.integers.decorrelation import decorrelate


def success_rate(Q):
    """Return the probability that bootstrapping after decorrelation finds the true integers.

    P = prod over i of (2 Phi(1 / (2 sigma_i)) - 1) = prod over i of erf(1 / sqrt(8 d_i))

    d_i = sigma_i^2: conditional variances after decorrelation [cycles^2]. A lower bound for integer least squares,
    usually a sharp one, if the float ambiguities are normal and unbiased with covariance Q; no word on a biased model.

    Q: (n, n) or (..., n, n) [cycles^2]. Returns (...). Raises ValueError where Q is not a covariance matrix.
    Source: Teunissen (1998), J. Geodesy 72:606-612, eq. 24 and 28.

    >>> float(success_rate([[0.25]]).round(4))        # half a cycle is one sigma
    0.6827
    """
    d = decorrelate(Q).d
    chances = np.reshape([math.erf(1.0 / math.sqrt(8.0 * d_i)) for d_i in d.ravel()], d.shape)
    return np.prod(chances, axis=-1)


def adop(Q):
    """Return the ambiguity dilution of precision, the geometric mean of the conditional sigmas.

    ADOP = (det Q)^(1 / 2n) = prod over i of sqrt(d_i)^(1 / n)

    Q: (n, n) or (..., n, n) [cycles^2]. Returns (...) [cycles]; no integer change of variables alters it. Below 0.12
    cycles integer least squares succeeds in more than 99.9 % of the cases.
    Raises ValueError where Q is not a covariance matrix. Source: Teunissen (1997); Odijk and Teunissen (2008).

    >>> float(adop([[0.04, 0.0], [0.0, 0.01]]).round(4))      # sigmas 0.2 and 0.1
    0.1414
    """
    return np.exp(0.5 * np.mean(np.log(decorrelate(Q).d), axis=-1))
