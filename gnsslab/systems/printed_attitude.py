"""Angles from two antennas and their sigma as printed in paper A, (5), (6), (33), (34): for comparison only, called by labs and tests.

The mended forms are `core.rotations.heading_pitch_of` and `systems.dual_antenna.angle_sigmas`. The paper's heading y counts
counter-clockwise; here it is turned round, psi = -y. Of its three dilutions, PRDOP takes the place of sigma_e, HRDOP that of
sigma_n and VRDOP that of sigma_u, each as a standard deviation in metres.
"""

import numpy as np


def heading_as_printed(baseline_enu):
    """Return the heading (...) [rad], in (-pi/2, pi/2], that equation (5) gives for baselines (..., 3): psi = arctan(e / n).

    The quotient keeps neither of the two signs: whatever points south comes out half a turn off.

    >>> e, n = np.sin(np.radians(120)), np.cos(np.radians(120))
    >>> float(np.degrees(heading_as_printed([e, n, 0.0])).round(6))
    -60.0
    """
    e, n, _ = np.moveaxis(np.asarray(baseline_enu, dtype=float), -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.arctan(e / n)


def pitch_as_printed(baseline_enu):
    """Return the pitch (...) [rad] that equation (6) gives for baselines (..., 3): theta = arcsin(u / sqrt(e^2 + n^2)).

    An arcsin where an arctan belongs: too steep by about theta^3 / 2, and NaN above 45 degrees.

    >>> [round(float(np.degrees(pitch_as_printed([0.0, 1.0, np.tan(np.radians(p))]))), 3) for p in (2, 20, 60)]
    [2.001, 21.344, nan]
    """
    e, n, u = np.moveaxis(np.asarray(baseline_enu, dtype=float), -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.arcsin(u / np.hypot(e, n))


def sigma_heading_as_printed(heading, pitch, length, sigma_enu):
    """Return sigma (...) [rad] of heading by equation (33): sqrt(cos^2 psi sigma_e^2 + sin^2 psi sigma_n) / l cos theta.

    sigma_n is not squared, so that the result changes with the unit; and read from left to right it is multiplied by cos theta.

    >>> sigma = sigma_heading_as_printed(np.radians(50), np.radians(25), 1.167, [0.006, 0.009, 0.016])
    >>> round(float(np.degrees(sigma)), 2)
    3.24
    """
    sigma_e, sigma_n, _ = np.moveaxis(np.asarray(sigma_enu, dtype=float), -1, 0)
    return np.sqrt((np.cos(heading) * sigma_e) ** 2 + np.sin(heading) ** 2 * sigma_n) / length * np.cos(pitch)


def sigma_pitch_as_printed(heading, pitch, length, sigma_enu):
    """Return sigma (...) [rad] of pitch by (34): sqrt(cos^2 theta sigma_u^2 + sin^2 theta sigma_e^2 + sin^2 theta sin^2 psi sigma_n^2) / l.

    A cos^2 psi is missing, and sigma_e and sigma_n have changed places.

    >>> sigma = sigma_pitch_as_printed(np.radians(50), np.radians(25), 1.167, [0.006, 0.009, 0.016])
    >>> round(float(np.degrees(sigma)), 3)
    0.737
    """
    sigma_e, sigma_n, sigma_u = np.moveaxis(np.asarray(sigma_enu, dtype=float), -1, 0)
    level = sigma_e**2 + (np.sin(heading) * sigma_n) ** 2
    return np.sqrt((np.cos(pitch) * sigma_u) ** 2 + np.sin(pitch) ** 2 * level) / length
