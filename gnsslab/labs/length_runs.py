"""A known length used in different forms by the same filter on the same epochs: what each makes of them."""

from dataclasses import dataclass, replace

import numpy as np

from gnsslab.core.integers import SimulatedRate
from gnsslab.gnss import motion
from gnsslab.gnss.blocks import run_blocks
from gnsslab.gnss.frames import enu_rotation
from gnsslab.gnss.judging import believed_by_ratio
from gnsslab.gnss.known_length import code_scale, run_with_length, scaled
from gnsslab.gnss.preparation import path_of
from gnsslab.labs.degraded_pairs import with_model
from gnsslab.systems.constrained_filter import direct_path, run_filter, steady_path
from gnsslab.systems.dual_antenna import A_STATIC
from gnsslab.systems.length_row import LengthUse, RowState

WRONG = 0.5  # cycles between the carriers of any two satellites, as baseline and truth predict them: other integers are whole ones away

# What each form is called; the engine is that of `gnsslab heading`, with its own filter and its own way to believe.
FORMS = {
    "nowhere": LengthUse.NOWHERE,
    "guarded": LengthUse.GUARDED_ROW,
    "row": LengthUse.ROW,
    "iterated": LengthUse.ITERATED_ROW,
    "second": LengthUse.SECOND_ORDER_ROW,
    "search": LengthUse.SEARCH,
    "engine": None,
}


@dataclass(frozen=True, eq=False)
class FormRun:
    """What one form made of T epochs."""

    baseline: np.ndarray  # (T, 3) [m] east, north, up: fixed where it is, else float
    is_fixed: np.ndarray  # (T,) bool
    off: np.ndarray  # (T,) [m], distance from the truth
    cycles_off: np.ndarray  # (T,) most by which carriers of two satellites differ from what the truth predicts
    ratio: np.ndarray  # (T,)
    row_state: np.ndarray  # (T,) of RowState

    @property
    def length(self):
        """The baseline's length (T,) [m]."""
        return np.linalg.norm(self.baseline, axis=-1)

    @property
    def is_wrong(self):
        """Fixed, with a baseline that asks for other integers than the truth does, (T,) bool."""
        return self.is_fixed & (self.cycles_off > WRONG)

    @property
    def is_right(self):
        """Fixed, with one that asks for the same, (T,) bool."""
        return self.is_fixed & (self.cycles_off <= WRONG)

    @property
    def right(self):
        """How often it is fixed and right, counted."""
        return SimulatedRate(int(self.is_right.sum()), len(self.off))

    @property
    def wrong(self):
        """How often it is fixed and wrong, counted."""
        return SimulatedRate(int(self.is_wrong.sum()), len(self.off))

    @property
    def dropped(self):
        """Share of the epochs at which the row was dropped."""
        return float(np.mean(self.row_state == RowState.DROPPED))

    @property
    def first_fix(self):
        """Index of the first fixed epoch; None without one."""
        return int(np.argmax(self.is_fixed)) if self.is_fixed.any() else None


def run_form(pair, truth, form, memory, filter_settings):
    """Return the FormRun of a PreparedPair: one of FORMS, with a memory of "single" epochs, the ambiguities ("direct"), or all ("filter").

    `truth` (3,) or (T, 3) [m] east, north, up; FilterSettings whose `length_use` is set here. The engine takes length and sigma
    from them and nothing else.
    """
    if form == "engine":
        return run_engine(pair, truth, filter_settings.length, filter_settings.length_sigma)
    found = run_filter(pair.prepared, _path(pair, memory), replace(filter_settings, length_use=FORMS[form]))
    return _form_run(pair, truth, found.baseline, found.is_fixed, found.ratio, found.row_state)


def run_engine(pair, truth, length=None, length_sigma=0.005):
    """Return the FormRun of the engine, with a length [m] in its search or without."""
    model, path = pair.prepared.model, path_of(pair.prepared, pair.settings)
    if length is None:
        outcome = run_blocks(model, path).outcome
        is_fixed = believed_by_ratio(outcome, outcome.integers, pair.settings.acceptance)
    else:
        solution, is_fixed = run_with_length(model, path, length, length_sigma, pair.settings.acceptance)
        outcome = solution.outcome
    b_ecef = np.where(is_fixed[:, None], outcome.baseline_fixed, outcome.baseline_float)
    b = np.matvec(enu_rotation(pair.prepared.master_ecef), b_ecef)
    return _form_run(pair, truth, b, is_fixed, outcome.ratio, np.full(len(b), RowState.NONE))


def with_noise(pair, factor):
    """Return the PreparedPair with its assumed sigmas multiplied; a factor of None is learnt from its codes."""
    model = pair.prepared.model
    codes = code_scale(model) if factor is None else factor
    return with_model(pair, scaled(model, codes, codes))


def _path(pair, memory):
    prepared = pair.prepared
    if memory == "single":
        return motion.forgetful(prepared.model.pair.time, prepared.model.near)
    return direct_path(prepared) if memory == "direct" else steady_path(prepared, np.array(A_STATIC.velocity_noise))


def _form_run(pair, truth, baseline, is_fixed, ratio, row_state):
    error = baseline - truth
    return FormRun(baseline, is_fixed, np.linalg.norm(error, axis=-1), _cycles_off(pair, error), ratio, row_state)


def _cycles_off(pair, error):
    """Return the largest double difference (T,) [cycles] that an error (T, 3) [m] of the baseline makes between channels of one group.

    It leaves out what the satellites do not see: right integers may leave decimetres where few satellites stand badly.
    """
    model = pair.prepared.model
    e_ecef = np.matvec(enu_rotation(pair.prepared.master_ecef).swapaxes(-1, -2), error)
    cycles = np.einsum("tci,ti->tc", model.design, e_ecef) / model.pair.wavelength
    spread = np.zeros(len(error))
    for group in np.unique(model.pair.group):
        belongs = model.usable & (model.pair.group == group)
        top, bottom = (extreme(cycles, axis=1, initial=fill, where=belongs) for extreme, fill in ((np.max, -np.inf), (np.min, np.inf)))
        spread = np.maximum(spread, np.where(belongs.any(axis=1), top - bottom, 0.0))
    return spread
