"""Whether a known length fits what two antennas measured: a tape read wrongly must not pass in silence.

Wrong by decimetres, a length leaves few epochs fixed or none; by centimetres, it contradicts the carriers of those that are.
"""

from dataclasses import replace

import numpy as np

from gnsslab.gnss.relative import Status

CONTRADICTION = 5.0  # sigma between the measured and the known length: an innocent epoch fails once in two million times
_DOUBTFUL = 3.0  # sigma, of the median of all fixed epochs: what is worth a word
_HALF = 0.5
_SOME = 0.1  # share of the solved epochs that must agree on another length before a tape is called wrong: single wrong fixes agree on none
_FAR = 10.0  # [m] by which a float baseline may be too short
_OTHER_UNIT = 10.0  # times too long: centimetres or millimetres


def checked_by_length(relative, length, length_sigma, solve_without):
    """Return a Relative with its fixed epochs that contradict the length [m] made float, and warnings in words about the length.

    A fixed epoch contradicts where ||b| - l| exceeds 5 sigma, sigma^2 = b' Q b / |b|^2 + sigma_l^2. Where less than half of the
    solved epochs are fixed, `solve_without()` gives the Relative without the length, to see whether the length is to blame.
    Raises ValueError where most fixed epochs, with the length or without it, agree on another one, or where the length is
    metres more than the codes have it.
    """
    _refuse_contradicted(relative, length, length_sigma)
    warnings = []
    if _fixed(relative).sum() < _HALF * _solved(relative).sum():
        without = solve_without()
        _refuse_contradicted(without, length, length_sigma)
        _refuse_far(without, length)
        warnings.append(_few_fixed(relative, without, length, length_sigma))
    warnings += _misfit(relative, length, length_sigma)
    contradicts = _contradicts(relative, length, length_sigma)
    return replace(relative, status=np.where(contradicts, np.int8(Status.FLOAT), relative.status)), tuple(warnings)


def _fixed(relative):
    return relative.status == Status.FIXED


def _solved(relative):
    return relative.status > Status.NONE


def _measured(relative, length_sigma):
    """Return the lengths (T,) [m] measured, and the sigma (T,) [m] of what a known one differs from them."""
    norm = np.linalg.norm(relative.baseline_enu, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        H = relative.baseline_enu / norm[:, None]
        return norm, np.sqrt(np.einsum("ti,tij,tj->t", H, relative.Q_enu, H) + length_sigma**2)


def _contradicts(relative, length, length_sigma):
    norm, sigma = _measured(relative, length_sigma)
    return _fixed(relative) & (np.abs(norm - length) > CONTRADICTION * sigma)


def _agreed_length(relative, length_sigma, chosen):
    """Return the median length [m] of the chosen epochs (T,), and how many of them agree on it."""
    norm, sigma = _measured(relative, length_sigma)
    measured = np.median(norm[chosen])
    return measured, (chosen & (np.abs(norm - measured) <= CONTRADICTION * sigma)).sum()


def _refuse_contradicted(relative, length, length_sigma):
    contradicts = _contradicts(relative, length, length_sigma)
    if not contradicts.any():
        return
    measured, agreeing = _agreed_length(relative, length_sigma, contradicts)
    if agreeing > max(_HALF * _fixed(relative).sum(), _SOME * _solved(relative).sum()):
        raise ValueError(f"the antennas are {measured:.3f} m apart by most fixed epochs, not {_advice(length, measured)}")


def _refuse_far(relative, length):
    norm = np.linalg.norm(relative.baseline_enu[_solved(relative)], axis=-1)
    if len(norm) and np.median(length - norm) > _FAR:  # bad codes make a baseline too long, hardly too short
        measured = np.median(norm)
        raise ValueError(f"the antennas are about {measured:.1f} m apart by their codes, not {_advice(length, measured)}")


def _advice(length, measured):
    """Return the end of a refusal."""
    unit = " in metres" if length > _OTHER_UNIT * measured else ""
    return f"{length:g} m: {'give' if unit else 'measure'} the length{unit or ' again'}, or leave it out"


def _few_fixed(relative, without, length, length_sigma):
    fixed = _fixed(relative).sum()
    which = f"{_fixed(without).sum() or 'none'} without it{_apart(without, length_sigma)}"
    return (
        f"{f'only {fixed}' if fixed else 'none'} of {_solved(relative).sum()} epochs are fixed with the length of {length:g} m ({which}): "
        "a length that is wrong by centimetres does that, and so does noise"
    )


def _apart(without, length_sigma):
    """Return what most epochs that are fixed without the length agree on, in words; wrong fixes agree on nothing."""
    if not _fixed(without).any():
        return ""
    measured, agreeing = _agreed_length(without, length_sigma, _fixed(without))
    return f", {measured:.3f} m apart" if agreeing > _HALF * _fixed(without).sum() else ""


def _misfit(relative, length, length_sigma):
    """Return what there is to say about how the fixed epochs fit the length."""
    fixed, contradicts = _fixed(relative), _contradicts(relative, length, length_sigma)
    if not fixed.any():
        return []
    norm, sigma = _measured(relative, length_sigma)
    measured = f"the fixed epochs measure {np.median(norm[fixed]):.3f} m, the length given is {length:g} m"
    if contradicts.any():
        return [f"{measured}: {contradicts.sum()} of {fixed.sum()} contradict it and count as float"]
    is_doubtful = np.abs(np.median((norm[fixed] - length) / sigma[fixed])) > _DOUBTFUL
    return [f"{measured}: more than three of their sigma apart, measure it again"] if is_doubtful else []
