"""Why an epoch has no single point position, in words."""

import numpy as np

from gnsslab.gnss.point_model import HIGHEST_RADIUS, LOWEST_RADIUS, is_trustworthy
from gnsslab.gnss.signals import SYSTEM_NAMES
from gnsslab.gnss.times import iso_text

LARGEST_SIGMA = 100.0  # [m]: satellites nearly in one cone; a position this loose helps nobody
_NAMES_TOLD = 4  # satellites named in a reason, the rest are counted


def no_solution_reasons(sky, located, mask):
    """Return for each epoch (T,) why its position cannot be used, empty where it can.

    Asked in this order: measurements, ephemerides, satellites above the mask, geometry, residuals (chi-square of the fit).
    """
    reasons = np.full(len(sky.time), "", dtype="<U200")
    good = is_trustworthy(located.fit, located.above) & (sigma_position(located.fit) < LARGEST_SIGMA)
    for epoch in np.flatnonzero(~good):
        reasons[epoch] = _reason(sky, located, mask, epoch)
    return reasons


def sigma_position(fit):
    """Return sqrt(tr Q) [m] of the position part (T,), infinite where there is no solution."""
    Q = np.trace(fit.Q[:, :3, :3], axis1=-2, axis2=-1)
    return np.sqrt(np.where(np.isfinite(Q), Q, np.inf))


def _reason(sky, located, mask, epoch):
    if not np.isfinite(sky.code[epoch]).any():
        return f"no code measurements of {_systems_in_words(sky)}"
    if not sky.usable[epoch].any():
        return _no_ephemeris_at_all(sky, epoch)
    return _rough_reason(sky, located, epoch) or _fine_reason(sky, located, mask, epoch)


def _rough_reason(sky, located, epoch):
    """Return what is wrong with the codes of all satellites together, empty if nothing is."""
    usable, radius = sky.usable[epoch], located.rough_radius[epoch]
    if not located.rough.is_solved[epoch]:
        return _too_few(sky, located.rough, epoch, usable, "with a code and an ephemeris")
    if not is_trustworthy(located.rough, sky.usable)[epoch]:
        return _too_large(located.rough, epoch, usable)
    if not LOWEST_RADIUS < radius < HIGHEST_RADIUS:
        return f"the codes of {usable.sum()} satellites lead to a place {radius / 1e3:.0f} km from the centre of the Earth"
    return ""


def _fine_reason(sky, located, mask, epoch):
    """Return what is wrong with the satellites above the mask."""
    fit, above = located.fit, located.above[epoch]
    if not fit.is_solved[epoch]:
        return _too_few(sky, fit, epoch, above, f"above {np.degrees(mask):g} deg")
    if not sigma_position(fit)[epoch] < LARGEST_SIGMA:
        return f"geometry too weak: {fit.used[epoch].sum()} satellites leave a sigma above {LARGEST_SIGMA:g} m"
    return _too_large(fit, epoch, above)


def _too_few(sky, fit, epoch, seen, where):
    """Return in words that the satellites seen (m,) are too few for position and clocks, or stand badly."""
    count, left = int(seen.sum()), int(fit.used[epoch].sum())
    systems = int((sky.clock_columns[seen].sum(axis=0) > 0).sum())
    words = f"only {count} satellite{'s' if count > 1 else ''} {where}" if count else f"no satellite {where}"
    if systems > 1:
        words += f", of {systems} systems: {3 + systems} are needed"
    if count >= 3 + systems:
        words = f"geometry too weak: {left} of {count} satellites {where} do not determine a position"
    without = _without_ephemeris(sky, epoch)
    return f"{words}; {without}" if without else words


def _too_large(fit, epoch, seen):
    used = fit.used[epoch]
    rms = np.sqrt(np.mean(fit.residual[epoch, used] ** 2))
    removed = int(seen.sum() - used.sum())
    if removed > fit.redundancy[epoch]:
        return f"residuals too large: {removed} of {seen.sum()} satellites were taken out, more than the other {used.sum()} can vouch for"
    words = f"residuals too large: {rms:.1f} m rms with {used.sum()} satellites"
    return words if removed == 0 else f"{words} after {removed} were taken out"


def _no_ephemeris_at_all(sky, epoch):
    count = int(np.isfinite(sky.code[epoch]).sum())
    if not len(sky.toe):
        return f"no ephemeris for any of {count} satellites: there are none at all"
    first, last = (iso_text(time)[:16] for time in (sky.toe.min(), sky.toe.max()))
    return f"no healthy ephemeris for any of {count} satellites: those given are for {first} to {last}, the epoch is {iso_text(sky.time[epoch])[:16]}"


def _without_ephemeris(sky, epoch):
    """Return "no ephemeris for G01, G05" for the satellites measured but not known, empty where there are none."""
    missing = np.flatnonzero(np.isfinite(sky.code[epoch]) & (sky.states.index[epoch] < 0))
    if not len(missing):
        return ""
    told = ", ".join(sky.names[i] for i in missing[:_NAMES_TOLD])
    more = f" and {len(missing) - _NAMES_TOLD} more" if len(missing) > _NAMES_TOLD else ""
    return f"no healthy ephemeris for {told}{more}"


def _systems_in_words(sky):
    return ", ".join(SYSTEM_NAMES[letter] for letter in sky.systems) or "the systems asked for"
