"""The numbers of paper A's experiments, one dict for a seed; the spans of epochs are those of the paper's text."""

import numpy as np

from gnsslab.labs.filter_modes import rms

LENGTH = 1.167  # [m]
MM = 1e-3
SETTLED, QUIET = (100, 650), (150, 300)  # epochs, first and one past the last
AFTER_300, AFTER_500, TURN, CALM = (300, 330), (500, 530), (150, 181), (185, 216)
MISSING = 218
WRONG = 0.1  # [m], half a wavelength: a fixed baseline that far off has wrong integers


def numbers_of(at_rest, turning):
    """Return all numbers of one seed by key."""
    found = {}
    for name, solution in at_rest.solutions.items():
        found |= {f"rest {name} {key}": value for key, value in _at_rest(at_rest, solution).items()}
    for name, solution in turning.solutions.items():
        found |= {f"turn {name} {key}": value for key, value in _turning(turning, solution).items()}
    return found | _comparisons(found) | {"wrong": float(_is_ever_wrong(at_rest)), "late": float(not found["rest length first fix"] < SETTLED[0])}


def _at_rest(experiment, solution):
    settled, quiet, after_300, after_500 = (_within(experiment, span) for span in (SETTLED, QUIET, AFTER_300, AFTER_500))
    heading, pitch, length = solution.heading_error, solution.pitch_error, (solution.length - LENGTH) / MM
    return {
        "heading": rms(heading[settled]), "heading largest": _largest(heading[settled]),
        "pitch": rms(pitch[settled]), "pitch largest": _largest(pitch[settled]),
        "quiet heading": rms(heading[quiet]), "quiet pitch": rms(pitch[quiet]), "quiet pitch largest": _largest(pitch[quiet]),
        "length": np.std(length[settled]), "quiet length": np.std(length[quiet]),
        "shortest": np.min(length[settled]), "longest": np.max(length[settled]),
        "band": np.ptp(length[settled]), "quiet band": np.ptp(length[quiet]),
        "fixed": 100 * np.mean(solution.is_fixed[settled]),
        "spike 300": _largest(heading[after_300]), "spike 500": _largest(heading[after_500]),
        "first fix": _first_fix(experiment, solution),
    }  # fmt: skip


def _turning(experiment, solution):
    turn, calm = _within(experiment, TURN), _within(experiment, CALM)
    heading, pitch = solution.heading_error, solution.pitch_error
    at_missing = int(np.flatnonzero(experiment.seconds == MISSING)[0])
    off = np.linalg.norm(solution.baseline - experiment.truth, axis=1) > WRONG
    return {
        "spike 150": _largest(heading[turn]), "at 218": heading[at_missing], "pitch at 218": pitch[at_missing],
        "heading": rms(heading[calm]), "pitch": rms(pitch[calm]),
        "first fix": _first_fix(experiment, solution),
        "off and float": 100 * np.mean(~solution.is_fixed[off]) if off.any() else np.nan,
    }  # fmt: skip


def _comparisons(found):
    """Return the numbers that claims come down to: how many times its usual size an error is, and what is left without the row."""
    rest, turn = "rest length ", "turn length "
    return {
        "outlier 300": found["rest direct spike 300"] / found["rest direct quiet heading"],
        "outlier 500": found["rest direct spike 500"] / found["rest direct quiet heading"],
        "kept 300": found[rest + "spike 300"] / found[rest + "quiet heading"],
        "kept 500": found[rest + "spike 500"] / found[rest + "quiet heading"],
        "left 300": 100 * found["rest printed 16 spike 300"] / found["rest direct spike 300"],
        "left 500": 100 * found["rest printed 16 spike 500"] / found["rest direct spike 500"],
        "outlier 150": found["turn direct spike 150"] / found[turn + "heading"],
        "kept 150": found[turn + "spike 150"] / found[turn + "heading"],
        "pitch outlier 218": abs(found[turn + "pitch at 218"]) / found[turn + "pitch"],
        "heading outlier 218": abs(found[turn + "at 218"]) / found[turn + "heading"],
        "corrected heading 218": abs(found["turn position at 218"]) / found[turn + "heading"],
        "corrected pitch 218": abs(found["turn position pitch at 218"]) / found[turn + "pitch"],
        "narrower": (found["rest direct quiet band"] - found[rest + "quiet band"]) / 2,
        "length by 16": found["rest printed 16 length"] - found[rest + "length"],
        "heading by 25": found["rest printed 25 heading"] - found[rest + "heading"],
        "turning by 25": found["turn printed 25 heading"] - found[turn + "heading"],
        "heading by 31": found["rest printed 31 heading"] - found[rest + "heading"],
        "fixed by 31": found["rest printed 31 fixed"] - found[rest + "fixed"],
    }


def _is_ever_wrong(experiment):
    """Say whether wrong integers were believed at any settled epoch of the solution with the length."""
    solution, settled = experiment.solutions["length"], _within(experiment, SETTLED)
    off = np.linalg.norm(solution.baseline - experiment.truth, axis=1) > WRONG
    return (off & solution.is_fixed)[settled].any()


def _within(experiment, span):
    return (experiment.seconds >= span[0]) & (experiment.seconds < span[1])


def _largest(values):
    return np.max(np.abs(values))


def _first_fix(experiment, solution):
    """Return when the first epoch was fixed [s], NaN without one."""
    return experiment.seconds[np.argmax(solution.is_fixed)] if solution.is_fixed.any() else np.nan
