"""Ellipses: a covariance matrix as an outline."""

import numpy as np

CHI_SQUARE_95 = 5.991  # of two degrees of freedom: an ellipse that holds 95 %


def set_ellipse(patch, middle, Q):
    """Give a matplotlib Ellipse the outline (x - middle)' Q^-1 (x - middle) = 1, Q (2, 2).

    >>> from matplotlib.patches import Ellipse
    >>> patch = Ellipse((0, 0), 1, 1)
    >>> set_ellipse(patch, (5.0, 7.0), np.diag([9.0, 4.0]))
    >>> patch.center, float(patch.height), float(patch.width), float(patch.angle)
    ((5.0, 7.0), 6.0, 4.0, 90.0)
    """
    variances, directions = np.linalg.eigh(Q)
    width, height = 2 * np.sqrt(variances)
    patch.set(center=tuple(middle), width=width, height=height, angle=np.degrees(np.arctan2(directions[1, 0], directions[0, 0])))
