"""Equivalent weights of robust estimation: what a measurement still counts for when its standardised residual is v.

A measurement of weight p and residual v counts as one of weight eta p, eta from 1 (nothing wrong) down to 0 (left out): robust
estimation becomes least squares with changed weights. A `Weight` is such a function of v; igg3, huber, tukey and danish make it,
estimators and filters take it, and `*_weight` evaluates it at once.
"""

import math
from dataclasses import dataclass

import numpy as np

from gnsslab.core.jit import kernel, kernel_input, vector


@dataclass(frozen=True)
class Weight:
    """An equivalent weight eta(v): the product of three factors, each of them 1 where its thresholds are infinite.

    A call takes standardised residuals v, of any shape, and returns eta in [0, 1] of that shape; NaN stays NaN.
    """

    full: float = math.inf  # k0 of IGG III, c of Huber: full weight up to here
    zero: float = math.inf  # k1 of IGG III: no weight from here on
    biweight: float = math.inf  # c of Tukey's biweight
    danish: float = math.inf  # c of the Danish method

    def __call__(self, v):
        v = np.asarray(v, dtype=np.float64)
        return np.reshape(_weights(kernel_input(v.ravel()), *self.thresholds), v.shape)[()]

    @property
    def thresholds(self):
        """The four numbers, as kernels take them."""
        return self.full, self.zero, self.biweight, self.danish


def igg3(k0, k1):
    """Return the Weight of IGG III, three parts: keep, reduce, reject.

        eta = 1                                      |v| <= k0
        eta = k0 / |v| ((k1 - |v|) / (k1 - k0))^2    k0 < |v| < k1
        eta = 0                                      |v| >= k1

    Raises ValueError unless 0 < k0 < k1. Source: Yang (1994), Manuscripta Geodaetica 19:10-17; usual are k0 1 to 2, k1 2.5 to 8.
    """
    if not (_is_threshold(k0) and _is_threshold(k1) and k0 < k1):
        raise ValueError(f"IGG III expects 0 < k0 < k1, both finite, such as 1.5 and 3; got k0 = {k0}, k1 = {k1}")
    return Weight(full=float(k0), zero=float(k1))


def huber(c):
    """Return the Weight of Huber (1964), Annals of Mathematical Statistics 35:73-101: 1 up to c, then c / |v|; never 0. Usual is c = 1.345."""
    return Weight(full=_threshold(c, "Huber's weight", 1.345))


def tukey(c):
    """Return Tukey's biweight (Beaton and Tukey 1974, Technometrics 16:147-185): (1 - (v / c)^2)^2 up to c, then 0. Usual is c = 4.685."""
    return Weight(biweight=_threshold(c, "Tukey's biweight", 4.685))


def danish(c):
    """Return the Weight of the Danish method: 1 up to c, then exp(1 - (v / c)^2). Usual are c = 1.5 to 3.

    The method is of Krarup, Juhl and Kubik (1980, Goetterdaemmerung over least squares adjustment, 14th ISP congress), who lower
    the weights exponentially and have several exponents; this is the form with a square, without a jump at c.
    """
    return Weight(danish=_threshold(c, "the Danish weight", 2.0))


def igg3_weight(v, k0, k1):
    """Return the weights eta of IGG III, see `igg3`, of standardised residuals v.

    >>> igg3_weight([0.5, 1.5, -2.0], k0=1.0, k1=2.0).round(4).tolist()
    [1.0, 0.1667, 0.0]
    """
    return igg3(k0, k1)(v)


def huber_weight(v, c):
    """Return the weights eta of Huber, see `huber`, of standardised residuals v.

    >>> huber_weight([1.0, -3.0], c=1.5).tolist()
    [1.0, 0.5]
    """
    return huber(c)(v)


def tukey_weight(v, c):
    """Return the weights eta of Tukey's biweight, see `tukey`, of standardised residuals v.

    >>> tukey_weight([0.0, -2.0, 4.0], c=4.0).tolist()
    [1.0, 0.5625, 0.0]
    """
    return tukey(c)(v)


def danish_weight(v, c):
    """Return the weights eta of the Danish method, see `danish`, of standardised residuals v.

    >>> danish_weight([2.0, -4.0], c=2.0).round(4).tolist()
    [1.0, 0.0498]
    """
    return danish(c)(v)


def _threshold(c, name, usual):
    """Return a threshold as a float."""
    if not _is_threshold(c):
        raise ValueError(f"{name} expects a threshold above zero and finite, such as {usual}; got c = {c}")
    return float(c)


def _is_threshold(c):
    return np.ndim(c) == 0 and np.isfinite(c) and c > 0


@kernel
def equivalent_weight(size, full, zero, biweight, danish):
    """Return eta at |v| = size: see `Weight`."""
    eta = 1.0
    if size > full:  # 1 - (|v| - k0) / (k1 - k0) is the printed fraction, and 1 for k1 infinite
        rest = 1.0 - (size - full) / (zero - full)
        eta = full / size * rest * rest if size < zero else 0.0
    if size > danish:
        eta *= math.exp(1.0 - size / danish * size / danish)
    if biweight < math.inf:
        rest = max(1.0 - size / biweight * size / biweight, 0.0)
        eta *= rest * rest
    return eta


@kernel
def _weights(v, full, zero, biweight, danish):
    """Return eta of each v; NaN of NaN."""
    eta = vector(len(v))
    for i in range(len(v)):
        eta[i] = equivalent_weight(abs(v[i]), full, zero, biweight, danish) if v[i] == v[i] else math.nan
    return eta
