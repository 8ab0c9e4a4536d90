"""A known length of a moving baseline, used where it helps most: in the search for the integers.

The float solution stays without the length: linearised, it would bend a baseline that is not known to centimetres yet. The
search knows the sphere exactly (C-LAMBDA, core.integers.constrained). How far its answer may be believed depends on the noise
of these receivers at this place, so that is learnt from the data: from the codes of all epochs, which need no integers, then
from the carriers of the epochs fixed in a first run.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from gnsslab.core.least_squares import least_squares
from gnsslab.gnss.ambiguity_filter import filter_block
from gnsslab.gnss.blocks import run_blocks
from gnsslab.gnss.judging import believed_by_odds, believed_by_ratio, variance_factor

NOVELTY_TIME = 20.0  # [s], for which a measurement is no news, at least: with the length there is no need to hurry, and hurry makes wrong fixes
_MOST = 0.5  # share of epochs
_PRIOR_FREEDOM = 10.0  # what is assumed of the codes; four recordings, three simulations are 0.3 to 2 times that, so it counts for little


def cautious(noise):
    """Return the NoiseModel for a search that knows the length: measurements are news less soon."""
    return replace(noise, novelty_time=max(noise.novelty_time, NOVELTY_TIME))


def run_with_length(model, path, length, length_sigma, acceptance, progress=None):
    """Return the Solution of a Model with a known length [m] and its sigma [m], and which epochs (T,) of it are believed.

    Two runs. Of the first, with the carriers' noise guessed from that of the codes, the ratio test says which epochs are fixed;
    where these are most, the residuals of their carriers tell the noise of the second (a few could be the wrong ones, whose
    residuals are small by chance). There the odds decide. The length counts as one integer more.
    """
    run = partial(run_blocks, path=path, run=partial(filter_block, length=length, length_sigma=length_sigma))
    codes = code_scale(model)
    carriers = min(codes, np.sqrt(codes))  # the same where codes are better than assumed; half as far, by the logarithm, where worse
    first = run(scaled(model, codes, carriers), progress=_part(progress, 0)).outcome
    is_fixed = believed_by_ratio(first, first.integers + 1, acceptance)
    if is_fixed.mean() > _MOST:
        carriers *= np.sqrt(variance_factor(first, is_fixed))
    solution = run(scaled(model, codes, carriers), progress=_part(progress, 1))
    return solution, believed_by_odds(solution.outcome, solution.outcome.integers + 1)


def code_scale(model):
    """Return by what factor the codes' sigmas of a Model are to be multiplied: the codes of an epoch must agree on one baseline.

    sqrt((nu + r q) / (nu + r)): r is the redundancy of all epochs together, nu = 10 counts for what was assumed, and q is the
    median over the epochs of chi-square divided by its own median, k (1 - 2 / 9k)^3 for k degrees of freedom, so that outliers
    do not matter.
    """
    groups = model.pair.group[:, None] == np.unique(model.pair.group)  # (c, g): a clock for each group of channels
    A = np.concatenate([model.design, np.broadcast_to(groups, (*model.code.shape, groups.shape[1]))], axis=-1)
    fit = least_squares(A, model.code, model.sigma_code, model.usable)
    spare = fit.is_solved & (fit.redundancy > 0)
    k = fit.redundancy[spare]
    q = np.median(fit.chi_square[spare] / (k * (1 - 2 / (9 * k)) ** 3)) if spare.any() else 1.0
    return float(np.sqrt((_PRIOR_FREEDOM + k.sum() * q) / (_PRIOR_FREEDOM + k.sum())))


def scaled(model, codes, carriers):
    """Return the Model with the sigmas of its codes and carriers multiplied."""
    return replace(model, sigma_code=model.sigma_code * codes, sigma_phase=model.sigma_phase * carriers)


def _part(progress, part):
    """Return the progress of one of two runs."""
    return progress and (lambda done, total: progress(part * total + done, 2 * total))
