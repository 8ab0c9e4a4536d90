"""What paper B states and claims, what its calibration found, and what is wrong with its equations: an Item each."""

from math import inf

from gnsslab.reproduce.paper_b_formulas import STATED, STATED_GAIN
from gnsslab.reproduce.paper_b_runs import WALKS
from gnsslab.reproduce.rule import Item

_CALIBRATED = "calibration"
_POINTS = "16.7 and 21.8 are differences of two percentages, 57.6 - 40.9 and 57.6 - 35.8: percentage points. Relative to the method alone it is more"
_ROUNDED = "both 2.36 and 2.37 cm stand for the raw series in the paper; from its table's own numbers the percentage is another"
_LAG = "an adjusted epoch holds half of a step at once; the rest comes as the window fills with adjusted epochs, and the Kalman filter waits as well"
_LUCK = "reflections that last 110 s leave about 1 mm in a mean of nine hours, filtered or not: 0.3 mm is luck, as good a draw as any"
_FEWER = "the calibration's number is of fewer seeds"
_DATUM = "two points may move together without changing their difference: a datum defect of 3. (12) has no inverse"
_OWN_MEAN = "with the series' own mean for the truth it is a standard deviation: blind to bias and to lag, 0 for a constant, however wrong"


def _claim(item, quantity, unit, value, source, key, cause=""):
    return Item(item, quantity, unit, value, source, key, cause, is_claim=True)


def _calibrated(item, quantity, unit, value, key, cause=_FEWER):
    return Item(item, quantity, unit, value, _CALIBRATED, key, cause)


NAMES = {"raw": "Raw", "joint": "Joint", "adjustment": "Adjustment alone", "robust Kalman": "Robust Kalman alone",
         "moving average": "Moving average", "wavelet": "Wavelet", "EEMD": "EEMD-wavelet"}  # fmt: skip
_TABLES = {"raw": "tables 1, 2", "joint": "tables 1, 2", "adjustment": "table 2", "robust Kalman": "table 2"}
_RMSE = "RMSE of the length about its own mean"
_LESS = "less than raw"

_STATED = (
    *(Item(f"{NAMES[name]}, at rest", _RMSE, "cm", value, _TABLES.get(name, "table 1"), f"fixed {name}") for name, value in STATED.items()),
    *(Item(f"{NAMES[name]}, at rest", _LESS, "%", value, _TABLES.get(name, "table 1"), f"gain {name}") for name, value in STATED_GAIN.items()),
    Item("Raw, with the step", "RMSE of the length about its means before and after", "cm", 2.30, "table 3", "step raw"),
    Item("Joint, with the step", "RMSE of the length about its means before and after", "cm", 1.02, "table 3", "step joint"),
    Item("Fig. 4, joint", "step of the means minus the true one", "cm", 0.03, "section 5.3", "deviation joint", _LUCK),
)

_CLAIMS = (
    _claim("Fig. 1, joint", "moves from epoch to epoch more than the moving average by", "%", (0.0, inf), "section 5.1: keeps more detail",
           "detail joint", "what is kept from epoch to epoch is noise, and the joint method is the smoother of the two"),
    _claim("Fig. 1, wavelet", "moves from epoch to epoch more than the moving average by", "%", (0.0, inf), "section 5.1", "detail wavelet"),
    _claim("Fig. 1, EEMD-wavelet", "moves from epoch to epoch more than the moving average by", "%", (0.0, inf), "section 5.1", "detail EEMD"),
    _claim("Fig. 1, wavelet", "left of errors beyond 10 cm", "%", (25.0, 100.0), "section 5.1: removes them badly", "left wavelet"),
    _claim("Fig. 1, EEMD-wavelet", "left of errors beyond 10 cm", "%", (25.0, 100.0), "section 5.1: removes them badly", "left EEMD"),
    _claim("Fig. 2, adjustment alone", "left of errors beyond 10 cm", "%", (25.0, 100.0), "section 5.2: cannot remove them", "left adjustment"),
    _claim("Fig. 2, joint", "left of errors beyond 10 cm", "%", (0.0, 25.0), "section 5.2: makes up for it", "left joint"),
    _claim("Joint against adjustment alone", _RMSE + ", less by", "%", 16.7, "section 5.2", "joint over adjustment", _POINTS),
    _claim("Joint against robust Kalman alone", _RMSE + ", less by", "%", 21.8, "section 5.2", "joint over Kalman", _POINTS),
    _claim("Fig. 3, reaction", "joint, to 50 % of 3.6 cm", "epochs", 0.0, "section 5.3: as fast as raw", "joint 50", _LAG),
    _claim("Fig. 3, reaction", "joint, to 90 % of 3.6 cm", "epochs", 0.0, "section 5.3: as fast as raw", "joint 90", _LAG),
    _claim("Fig. 3, reaction", "joint, to 99 % of 3.6 cm", "epochs", 0.0, "section 5.3: as fast as raw", "joint 99",
           _LAG + "; among 63 857 epochs nobody sees it"),
    _claim("Fig. 3, reaction at 1 s", "joint, to 90 % of 3.6 cm", "min", 0.0, "section 5.3: as fast as raw", "joint 90 at 1 s", _LAG),
    _claim("Reaction at 15 s", "joint, to 90 % of 3.6 cm", "min", 0.0, "section 5.3: as fast as raw", "joint 90 at 15 s", _LAG),
    _claim("Fig. 4, accuracy", "standard deviation of the step of the means, over the seeds", "cm", 0.03, "section 5.3: 0.3 mm", "spread joint",
           _LUCK),
    _claim("Fig. 4, gain by the method", "the same, raw minus joint", "cm", (0.03, inf), "section 5.3", "spread gained",
           "a mean of nine hours is as good of raw solutions: no filter removes what lasts for minutes and averages out anyway"),
    _claim("Table 3, accuracy against the truth", "RMSE of the joint length about the truth, step included", "cm", 1.02, "section 5.3",
           "step joint about truth"),
    _claim("The paper's criterion finds the best method", "RMSE of a moving average of 120 epochs minus that of joint", "cm", (0.0, inf), "section 4",
           "worse by 120", "a longer window always wins on (22): it costs nothing there to be late"),
    _claim("IGG3 is needed", "joint RMSE with it less than without by", "%", (10.0, inf), "sections 3, 6", "better by IGG3",
           "seven gross errors in 2256 epochs hardly matter to an RMSE, and the adjustment has halved them; what IGG3 saves is single epochs"),
    _claim("2 cm west and 3 cm south", "change of the length, baseline along the move", "cm", 3.6, "section 5.3", "length along"),
    _claim("2 cm west and 3 cm south", "change of the length, baseline across the move", "cm", 3.6, "section 5.3", "length across",
           "the length tells 3.6 cm only of a baseline that points south-west or north-east; the paper does not say where its own points"),
    _claim("21 h to 10 h at 15 s", "epochs", "", 2256.0, "section 5", "epochs of 13 h", "864 epochs of 3120 are missing, or the times are wrong"),
    _claim("2 h to 20 h at 1 s", "epochs", "", 63_857.0, "section 5", "epochs of 18 h"),
)  # fmt: skip

_ARITHMETIC = (
    *(_claim("Arithmetic of tables 1, 2", f"{NAMES[name]}: stated gain minus that of the stated RMSEs", "% points", (-0.05, 0.05),
             "tables 1, 2", f"arithmetic {name}", _ROUNDED if name == "joint" else "cut off instead of rounded") for name in STATED_GAIN),
    _claim("Arithmetic of table 2", "joint better than adjustment alone, from 1.40 and 1.00 cm", "%", 16.7, "section 5.2",
           "stated over adjustment", _POINTS),
    _claim("Arithmetic of table 2", "joint better than robust Kalman alone, from 1.52 and 1.00 cm", "%", 21.8, "section 5.2",
           "stated over Kalman", _POINTS),
    _calibrated("Arithmetic of table 3", "joint better than raw, from 2.30 and 1.02 cm", "%", 55.7, "stated table 3"),
)  # fmt: skip

_PRINTED = (
    _claim("Equations (11), (12)", "rank of A'PA, 6 x 6", "", 6.0, "equation (12)", "rank 11", _DATUM),
    _claim("The adjustment, equations (3) to (12)", "as condition adjustment minus as weighted mean, example", "um", 0.0, "section 2",
           "weighted mean"),
    _claim("Equation (17)", "printed minus right: gain of the first of two states", "", 0.0, "equation (17)", "formula 17",
           "a number cannot be the gain of two states measured as one: P H' (H P H' + R)^-1 is [0.762, 0.095], printed comes out 0.810"),
    _claim("Equation (17)", "gain of the second state, which the printed one has not", "", 0.0, "equation (17)", "missing 17",
           "as above; where H = I, as in the paper's own filter, both are the same"),
    _claim("Equations (20), (21)", "good Gaussian data for which lambda is infinite", "%", 0.0, "equation (20)", "good rejected",
           "lambda = 1 / eta with eta = 0 from k1 = 2 on: code must take weights, or leave the epoch out"),
    _claim("Equation (22)", "RMSE of a constant that is 1 m too long", "cm", 100.0, "section 4: agreement with the true value", "formula 22",
           _OWN_MEAN),
    _calibrated("IGG3 with k0 = 1, k1 = 2", "good Gaussian data weighed down", "%", 31.7, "good down-weighted"),
    _calibrated("IGG3 with k0 = 1, k1 = 2", "good Gaussian data rejected", "%", 4.6, "good rejected"),
)  # fmt: skip

_LAGS = (
    _calibrated("Joint, clean step of 3.6 cm", "to 50 %", "epochs", 10.0, "joint 50"),
    _calibrated("Joint, clean step of 3.6 cm", "to 90 %", "epochs", 51.0, "joint 90"),
    _calibrated("Joint, clean step of 3.6 cm", "to 99 %", "epochs", 107.0, "joint 99"),
    _calibrated("Robust Kalman, clean step of 3.6 cm", "to 50 %", "epochs", 3.0, "Kalman 50"),
    _calibrated("Robust Kalman, clean step of 3.6 cm", "to 90 %", "epochs", 10.0, "Kalman 90"),
    _calibrated("Adjustment, window of raw epochs", "to 90 % of a clean step", "epochs", 25.0, "raw window 90"),
    _calibrated("Adjustment, window of adjusted epochs", "to 90 % of a clean step", "epochs", 47.0, "adjusted window 90"),
    _calibrated("Adjustment, window's error / sqrt(30)", "to 90 % of a clean step", "epochs", 1084.0, "error of mean 90"),
    _calibrated("Lock-out of IGG3", "steps beyond this are rejected at first", "cm", 7.02, "lock-out"),
    _calibrated("Lock-out of IGG3", "P^- of the settled filter", "cm^2", 2.433, "steady variance"),
    _calibrated("Lock-out of IGG3", "gain of the settled filter", "", 0.197, "steady gain"),
    _calibrated("Lock-out of IGG3, 10 cm", "robust Kalman, rejected", "epochs", 27.0, "rejected 10"),
    _calibrated("Lock-out of IGG3, 10 cm", "robust Kalman, to 50 %", "epochs", 38.0, "Kalman 50 of 10"),
    _calibrated("Lock-out of IGG3, 15 cm", "robust Kalman, rejected", "epochs", 92.0, "rejected 15"),
    _calibrated("Lock-out of IGG3, 15 cm", "robust Kalman, to 50 %", "epochs", 103.0, "Kalman 50 of 15"),
    _calibrated("Lock-out of IGG3, 15 cm", "joint, to 50 %", "epochs", 100.0, "joint 50 of 15"),
)

_ALONE = dict(zip(WALKS, (1.02, 1.16, 1.31, 1.49, 1.61, 1.72, 1.84), strict=True))  # [cm], by q [cm^2] an epoch
_JOINT = dict(zip(WALKS, (0.81, 0.87, 0.92, 0.99, 1.03, 1.07, 1.12), strict=True))
_FEW = "the calibration's number is of eight seeds, and this filter's own mean wanders"
_CALIBRATION = (
    _calibrated("Raw, at rest", _RMSE, "cm", 2.34, "fixed raw"),
    _calibrated("Joint, at rest", _RMSE, "cm", 1.03, "fixed joint"),
    _calibrated("Adjustment alone, at rest", _RMSE, "cm", 1.37, "fixed adjustment"),
    _calibrated("Robust Kalman alone, at rest", _RMSE, "cm", 1.52, "fixed robust Kalman"),
    _calibrated("Moving average, at rest", _RMSE, "cm", 1.48, "fixed moving average"),
    _calibrated("Wavelet, at rest", _RMSE, "cm", 1.80, "fixed wavelet"),
    Item("EEMD-wavelet, at rest", _RMSE, "cm", (1.72, 1.78), _CALIBRATED, "fixed EEMD"),
    _calibrated("Raw, with the step", "RMSE of the length about its means before and after", "cm", 2.33, "step raw"),
    _calibrated("Adjustment, with the step", "RMSE of the length about its means before and after", "cm", 1.42, "step adjustment"),
    Item("Joint, with the step", "RMSE of the length about its means before and after", "cm", (0.98, 1.00), _CALIBRATED, "step joint"),
    _calibrated("Fig. 4, joint", "standard deviation of the step of the means, over the seeds", "cm", 0.11, "spread joint"),
    _calibrated("Moving average of 30 epochs", _RMSE, "cm", 1.19, "fixed average 30"),
    _calibrated("Moving average of 120 epochs", _RMSE, "cm", 0.65, "fixed average 120"),
    _calibrated("Adjustment, window's error / sqrt(30)", _RMSE, "cm", 0.26, "fixed error of mean", _FEW),
    _calibrated("Joint, window of raw epochs", _RMSE, "cm", 1.16, "fixed joint raw window"),
    _calibrated("Kalman without weights", _RMSE, "cm", 1.57, "fixed plain Kalman"),
    _calibrated("Robust Kalman, k0 = 2.5, k1 = 6", _RMSE, "cm", 1.56, "fixed IGG3 2.5 6"),
    *(_calibrated(f"Robust Kalman alone, q = {q:g} cm^2 an epoch", _RMSE, "cm", value, f"fixed Kalman q {q:g}") for q, value in _ALONE.items()),
    *(_calibrated(f"Joint, q = {q:g} cm^2 an epoch", _RMSE, "cm", value, f"fixed joint q {q:g}") for q, value in _JOINT.items()),
)

ITEMS = (*_STATED, *_CLAIMS, *_ARITHMETIC, *_PRINTED, *_LAGS, *_CALIBRATION)
