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


def run_with_length(model, path, length, length_sigma, acceptance, progress=None):
    """Return the Solution of a Model with a known length [m] and its sigma [m], and which epochs (T,) of it are believed.

    Two runs. The ratio test, which needs no noise level, says which epochs of the first are fixed; the residuals of their
    carriers tell the noise of the second. There an epoch is believed by its ratio or by its odds; the length counts as one
    integer more.
    """
    run = partial(run_blocks, path=path, run=partial(filter_block, length=length, length_sigma=length_sigma))
    codes = code_scale(model)
    carriers = min(1.0, codes)  # until the carriers themselves are heard: good codes come from good antennas and receivers
    first = run(scaled(model, codes, carriers), progress=_part(progress, 0)).outcome
    carriers *= np.sqrt(variance_factor(first, believed_by_ratio(first, first.integers + 1, acceptance)))
    solution = run(scaled(model, codes, carriers), progress=_part(progress, 1))
    outcome, integers = solution.outcome, solution.outcome.integers + 1
    return solution, believed_by_ratio(outcome, integers, acceptance) | believed_by_odds(outcome, integers)


def code_scale(model):
    """Return by what factor the codes' sigmas of a Model are to be multiplied: the codes of an epoch must agree on one baseline.

    Of all epochs the median of chi-square over its own median, k (1 - 2 / 9k)^3 for k degrees of freedom, tells: outliers do not.
    1 where no epoch has a code to spare.
    """
    groups = model.pair.group[:, None] == np.unique(model.pair.group)  # (c, g): a clock for each group of channels
    A = np.concatenate([model.design, np.broadcast_to(groups, (*model.code.shape, groups.shape[1]))], axis=-1)
    fit = least_squares(A, model.code, model.sigma_code, model.usable)
    spare = fit.is_solved & (fit.redundancy > 0)
    if not spare.any():
        return 1.0
    k = fit.redundancy[spare]
    return float(np.sqrt(np.median(fit.chi_square[spare] / (k * (1 - 2 / (9 * k)) ** 3))))


def scaled(model, codes, carriers):
    """Return the Model with the sigmas of its codes and carriers multiplied."""
    return replace(model, sigma_code=model.sigma_code * codes, sigma_phase=model.sigma_phase * carriers)


def _part(progress, part):
    """Return the progress of one of two runs."""
    return progress and (lambda done, total: progress(part * total + done, 2 * total))
