"""Paper A (Wang, Li, Sun and Ji 2019): its stated numbers, its claims and its printed equations against our simulations."""

from math import inf

import numpy as np

from gnsslab.reproduce.paper_a_formulas import formula_numbers
from gnsslab.reproduce.paper_a_numbers import numbers_of
from gnsslab.reproduce.paper_a_runs import experiments
from gnsslab.reproduce.papers import Outcome, Picture
from gnsslab.reproduce.rule import Item

TITLE = "Wang S., Li Y., Sun X., Ji Y. (2019): Dual-antenna attitude determination algorithm based on low-cost receiver. J. Comput. Appl. 39(8)"
SEEDS = 20


def reproduce(seeds, progress=None):
    """Return the Outcome over these seeds; the pictures are those of the first."""
    found, first = [], None
    for done, pair in enumerate(experiments(seeds), start=1):
        first = first or pair
        found.append(numbers_of(*pair))
        if progress:
            progress(done, len(seeds))
    numbers = {key: np.array([each[key] for each in found]) for key in found[0]}
    formulas = {key: np.array([value]) for key, value in formula_numbers().items()}
    return Outcome(numbers | formulas, _pictures(*first), _notes(numbers))


def _pictures(at_rest, turning):
    from gnsslab.figures.reproduce_a import figures_4_to_8

    return tuple(Picture(*each) for each in figures_4_to_8(at_rest, turning))


def _notes(numbers):
    late, wrong, all_ = int(numbers["late"].sum()), int(numbers["wrong"].sum()), len(numbers["late"])
    return (
        f"At rest the first fix came after epoch 100 in {late} of {all_} draws: their errors until then are in all numbers from epoch 100 on, "
        "so that means and standard deviations lie far above medians.",
        f"At rest, with the length, wrong integers were believed after epoch 100 in {wrong} of {all_} draws.",
        "The paper's field data are not public. Ours are simulated: the paper's site, systems, mask, baseline and events, with a noise "
        "calibrated so that its figures' scatter comes out. The calibration's own numbers are medians of 8 draws under another sky.",
    )


_SKY = "another sky and other draws: the calibration's number is a median of 8"
_ONE_RMS = "the paper's numbers are near its largest errors, not their rms"
_CALIBRATED = "calibration"
_NOT_ROW = "the steady velocity and the held integers remove the errors: with (16) as printed the row does next to nothing, and they are gone as well"
_HORIZONTAL = "a master that moves level displaces the baseline level: the heading jumps by arctan(v dt / l) = 3 deg, the pitch does not"
_DOPPLER = "the correction is as good as the master's velocity: 0.05 m/s of Doppler noise a satellite leaves centimetres after one second"


def _calibrated(item, quantity, unit, value, key, cause=_SKY):
    return Item(item, quantity, unit, value, _CALIBRATED, key, cause)


def _claim(item, quantity, unit, value, source, key, cause=""):
    return Item(item, quantity, unit, value, source, key, cause, is_claim=True)


def _formula(number, quantity, unit, cause):
    return _claim(f"Equation ({number})", f"printed minus mended: {quantity}", unit, 0.0, f"equation ({number})", f"formula {number}", cause)


_STATED = (
    Item("Fig. 4, + length", "length, largest minus smallest", "mm", 10.0, "section 4: 1.16 to 1.17 m", "rest length band"),
    Item("Fig. 4, gain by the length", "half of the length's band, direct minus + length, epochs 150-299", "mm", 10.0, "section 4: about 1 cm",
         "narrower"),
    Item("Figs. 5, 6, + length", "heading error, rms", "deg", 0.5, "section 4", "rest length heading", _ONE_RMS),
    Item("Figs. 5, 6, + length", "heading error, largest", "deg", 1.0, "abstract", "rest length heading largest"),
    Item("Figs. 5, 6, + length", "heading error, largest", "deg", 0.5, "conclusion", "rest length heading largest",
         "the paper states its accuracy in three ways; 0.5 deg is between our rms and our largest error"),
    Item("Figs. 5, 6, + length", "pitch error, rms", "deg", (2.0, 3.0), "section 4",  "rest length pitch",
         "an rms of 2 to 3 deg is 4 to 6 cm of height: with carriers that bad the ratio test hardly ever passes; " + _ONE_RMS),
    Item("Figs. 5, 6, + length", "pitch error, largest", "deg", (2.0, 3.0), "abstract, section 4", "rest length pitch largest"),
    Item("Figs. 5, 6, + length", "pitch error, largest", "deg", 2.0, "conclusion", "rest length pitch largest"),
    Item("Initialisation at rest", "first fix", "s", (30.0, 40.0), "conclusion", "rest length first fix",
         "how soon the first fix comes is chance: the middle half of the draws is wide"),
    Item("Initialisation, turntable", "first fix", "s", (30.0, 40.0), "conclusion", "turn length first fix",
         "how soon the first fix comes is chance: the middle half of the draws is wide"),
)  # fmt: skip

_CLAIMS = (
    _claim("Fig. 5a, epoch 300", "largest direct heading error over its usual rms", "times", (3.0, inf), "section 4: gross error", "outlier 300"),
    _claim("Fig. 5a, epoch 500", "largest direct heading error over its usual rms", "times", (3.0, inf), "section 4: gross error", "outlier 500"),
    _claim("Fig. 5c, epoch 300", "the same, + length", "times", (0.0, 3.0), "section 4: all filtered out", "kept 300"),
    _claim("Fig. 5c, epoch 500", "the same, + length", "times", (0.0, 3.0), "section 4: all filtered out", "kept 500"),
    _claim("The length removes the error at 300", "left of it where the row is without effect, (16) as printed", "%", 100.0, "section 4", "left 300",
           _NOT_ROW),
    _claim("The length removes the error at 500", "left of it where the row is without effect, (16) as printed", "%", 100.0, "section 4", "left 500",
           _NOT_ROW),
    _claim("Fig. 7a, epochs 150-180", "largest direct heading error over + length's rms", "times", (3.0, inf), "section 4: gross error",
           "outlier 150"),
    _claim("Fig. 7c, epochs 150-180", "the same, + length", "times", (0.0, 3.0), "section 4: removed", "kept 150"),
    _claim("Fig. 7d, epoch 218", "pitch error over its usual rms, + length", "times", (3.0, inf), "section 4: outlier in pitch", "pitch outlier 218",
           _HORIZONTAL),
    _claim("Fig. 7c, epoch 218", "heading error over its usual rms, + length", "times", (0.0, 3.0), "section 4: none is said", "heading outlier 218",
           _HORIZONTAL),
    _claim("Fig. 7e, epoch 218", "heading error over its usual rms, + length + (29)", "times", (0.0, 3.0), "section 4: removed",
           "corrected heading 218", _DOPPLER),
    _claim("Fig. 7f, epoch 218", "pitch error over its usual rms, + length + (29)", "times", (0.0, 3.0), "section 4: removed",
           "corrected pitch 218", _DOPPLER),
    _claim("The clocks' offset is the cause at 218", "offset that turns the heading by 0.5 deg at 0.061 m/s", "ms", (0.0, 1.0),
           "section 4; receivers keep within 1 ms", "offset needed",
           "milliseconds do nothing on a turntable; a master epoch that is missing altogether does"),
    _claim("Fig. 8, points off the circle", "share of them that are not fixed", "%", 100.0, "section 4", "turn length off and float"),
)  # fmt: skip

_CALIBRATION = (
    _calibrated("At rest, direct", "heading error, rms", "deg", 9.96, "rest direct heading"),
    _calibrated("At rest, direct", "heading error, largest", "deg", 99.0, "rest direct heading largest"),
    _calibrated("At rest, direct, epochs 150-299", "heading error, rms", "deg", 0.30, "rest direct quiet heading"),
    _calibrated("At rest, direct", "pitch error, rms", "deg", 12.2, "rest direct pitch",
                "direct, an epoch without integers is as good as its codes: a matter of the sky and of each draw"),
    _calibrated("At rest, direct", "pitch error, largest", "deg", 68.0, "rest direct pitch largest"),
    _calibrated("At rest, direct, epochs 150-299", "pitch error, rms", "deg", 0.70, "rest direct quiet pitch"),
    _calibrated("At rest, direct, epochs 150-299", "pitch error, largest", "deg", 1.85, "rest direct quiet pitch largest"),
    _calibrated("At rest, direct, epochs 150-299", "length, standard deviation", "mm", 5.0, "rest direct quiet length"),
    _calibrated("At rest, direct", "epochs fixed", "%", 77.0, "rest direct fixed"),
    _calibrated("At rest, direct", "largest heading error, epochs 300-329", "deg", 33.0, "rest direct spike 300"),
    _calibrated("At rest, direct", "largest heading error, epochs 500-529", "deg", 52.0, "rest direct spike 500"),
    _calibrated("At rest, + length", "heading error, rms", "deg", 0.30, "rest length heading"),
    _calibrated("At rest, + length", "heading error, largest", "deg", 0.87, "rest length heading largest"),
    _calibrated("At rest, + length", "pitch error, rms", "deg", 0.86, "rest length pitch"),
    _calibrated("At rest, + length", "pitch error, largest", "deg", 2.3, "rest length pitch largest"),
    _calibrated("At rest, + length", "length, standard deviation", "mm", 2.0, "rest length length",
                "the calibration's 2 mm is rounded, its number lies between 1.5 and 2.5; ours obeys the row a little better"),
    _calibrated("At rest, + length", "shortest length minus 1.167 m", "mm", -4.0, "rest length shortest"),
    _calibrated("At rest, + length", "longest length minus 1.167 m", "mm", 5.0, "rest length longest"),
    _calibrated("At rest, + length", "epochs fixed", "%", 100.0, "rest length fixed"),
    _calibrated("At rest, + length", "largest heading error, epochs 300-329", "deg", 0.55, "rest length spike 300"),
    _calibrated("At rest, + length", "largest heading error, epochs 500-529", "deg", 0.52, "rest length spike 500"),
    _calibrated("At rest, (16) as printed", "heading error, rms", "deg", 0.31, "rest printed 16 heading"),
    _calibrated("At rest, (16) as printed", "heading error, largest", "deg", 0.87, "rest printed 16 heading largest"),
    _calibrated("At rest, (16) as printed", "pitch error, rms", "deg", 0.89, "rest printed 16 pitch"),
    _calibrated("At rest, (16) as printed", "pitch error, largest", "deg", 2.4, "rest printed 16 pitch largest"),
    _calibrated("At rest, (16) as printed", "length, standard deviation", "mm", 6.0, "rest printed 16 length"),
    _calibrated("At rest, (16) as printed", "shortest length minus 1.167 m", "mm", -16.0, "rest printed 16 shortest"),
    _calibrated("At rest, (16) as printed", "longest length minus 1.167 m", "mm", 19.0, "rest printed 16 longest"),
    _calibrated("At rest, (16) as printed", "epochs fixed", "%", 100.0, "rest printed 16 fixed"),
    _calibrated("At rest, (16) as printed", "largest heading error, epochs 300-329", "deg", 0.55, "rest printed 16 spike 300"),
    _calibrated("At rest, (16) as printed", "largest heading error, epochs 500-529", "deg", 0.54, "rest printed 16 spike 500"),
    _calibrated("Turntable, direct", "largest heading error, epochs 150-180", "deg", 44.6, "turn direct spike 150"),
    _calibrated("Turntable, + length", "largest heading error, epochs 150-180", "deg", 0.63, "turn length spike 150"),
    _calibrated("Turntable, direct", "heading error at 218", "deg", -3.42, "turn direct at 218"),
    _calibrated("Turntable, + length", "heading error at 218", "deg", -3.12, "turn length at 218"),
    _calibrated("Turntable, + length + (29)", "heading error at 218", "deg", -0.32, "turn position at 218", _DOPPLER),
    _calibrated("Turntable, direct", "pitch error at 218", "deg", 0.10, "turn direct pitch at 218"),
    _calibrated("Turntable, + length", "pitch error at 218", "deg", -0.01, "turn length pitch at 218"),
    _calibrated("Turntable, + length + (29)", "pitch error at 218", "deg", -0.04, "turn position pitch at 218", _DOPPLER),
    _calibrated("Turntable, + length + (29), epochs 185-215", "heading error, rms", "deg", 0.41, "turn position heading"),
    _calibrated("Turntable, + length + (29), epochs 185-215", "pitch error, rms", "deg", 0.75, "turn position pitch"),
    _calibrated("Initialisation at rest", "first fix", "s", 20.0, "rest length first fix"),
    _calibrated("Initialisation, turntable", "first fix", "s", 55.0, "turn length first fix"),
)  # fmt: skip

_PRINTED = (
    _formula("4", "heading of a level baseline at 35 deg", "deg", "the second entry of S's first row is cos lambda: with cos phi, S is no rotation"),
    _formula("5", "heading of a baseline at 120 deg", "deg", "a quotient loses the quadrant: atan2(e, n)"),
    _formula("6", "pitch of a baseline at 20 deg", "deg", "it is an arctan of u over the level distance, not an arcsin"),
    _formula("16", "sigma along a baseline known to 10 mm, after the row", "mm",
             "the row's variance is that of the tape, (5 mm)^2, not the square of the length"),
    _claim("Equation (16), at rest", "printed minus mended: length, standard deviation", "mm", 0.0, "equation (16)", "length by 16",
           "as printed the row is without effect"),
    _formula("25", "asymmetry of F P for F = [1 1; 0 1], P = [1 0.3; 0.3 2]", "", "a covariance is carried on by F P F' + Q"),
    _claim("Equation (25), at rest", "printed minus mended: heading error, rms", "deg", 0.0, "equation (25)", "heading by 25",
           "without F' the baseline's covariance hardly grows: at rest the filter averages for longer, which does no harm there"),
    _claim("Equation (25), turntable", "printed minus mended: heading error, rms", "deg", 0.0, "equation (25)", "turning by 25",
           "without F' the baseline's covariance hardly grows, and the filter does not follow"),
    _formula("28", "variance of the velocity along the baseline", "(m/s)^2",
             "S' diag(sigma^2) S dt is a matrix of variances; printed is a single number made of standard deviations"),
    _claim("Equations (30), (31), at rest", "printed minus mended: heading error, rms", "deg", 0.0, "equation (31)", "heading by 31",
           "the geometric range is missing from the residuals"),
    _claim("Equations (30), (31), at rest", "printed minus mended: epochs fixed", "%", 0.0, "equation (31)", "fixed by 31",
           "the geometric range is missing from the residuals"),
    _formula("33", "sigma of heading at heading 50, pitch 25 deg; sigma 6, 9, 16 mm", "deg",
             "a sigma is not squared, and bl cos p is not below the line"),
    _formula("34", "sigma of pitch at heading 50, pitch 25 deg; sigma 6, 9, 16 mm", "deg",
             "cos^2 of the heading is missing, east and north have changed places"),
)  # fmt: skip

ITEMS = (*_STATED, *_CLAIMS, *_CALIBRATION, *_PRINTED)
