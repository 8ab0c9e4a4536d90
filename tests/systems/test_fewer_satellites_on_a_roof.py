"""A known length on real data with satellites taken away: one metre on a roof, GPS L1 only, nine satellites above 15 degrees.

A fixed epoch is wrong where it lies more than 5 cm (three axes) from the median of the solution with all systems and bands. The length
given is that median's; rates asked are counts of 301 epochs, so the tests name counts.
"""

from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from scipy.stats import beta

from gnsslab.gnss.points import solve_points
from gnsslab.gnss.relative import Status, solve_moving
from gnsslab.systems.dual_antenna import dual_antenna_attitude

CM = 1e-2  # [m]
WRONG = 5 * CM
NINE = 9


class Roof:
    """The campaign with some of its GPS satellites only."""

    def __init__(self, campaign):
        self.campaign = campaign("matrtklib-static")
        relative = solve_moving(self.campaign.base, self.campaign.rover, self.campaign.ephemerides)
        self.truth = np.median(relative.baseline_enu[relative.status == Status.FIXED], axis=0)
        self.length = float(np.linalg.norm(self.truth))
        points = solve_points(self.campaign.base, self.campaign.ephemerides, systems="G")
        elevation = np.nanmedian(np.where(points.used.any(axis=0), points.elevation, np.nan)[:, points.used.any(axis=0)], axis=0)
        numbers = np.array([int(name[1:]) for name in points.names])[points.used.any(axis=0)]
        above = np.degrees(elevation) > 15.0
        self.highest = numbers[above][np.argsort(-elevation[above])].tolist()

    def receivers(self, numbers):
        """Return master, rover and ephemerides with these satellites."""
        return *(_only(receiver, numbers) for receiver in (self.campaign.base, self.campaign.rover)), self.campaign.ephemerides

    def count(self, numbers, **options):
        """Return how many epochs are fixed, and how many of them wrong; none where satellites in one cone leave no single point.

        There the carriers with the right integers leave the baseline open by decimetres too: no position is the honest answer.
        """
        try:
            found = solve_moving(*self.receivers(numbers), systems="G", frequencies=1, **options)
        except ValueError as error:
            if "geometry too weak" not in str(error):
                raise
            return 0, 0
        fixed = found.status == Status.FIXED
        return int(fixed.sum()), int((fixed & (np.linalg.norm(found.baseline_enu - self.truth, axis=1) > WRONG)).sum())


def _only(observations, numbers):
    table = observations.tables["G"]
    rows = np.isin(table.number, numbers)
    kept = {name: getattr(table, name)[rows] for name in ("epoch", "number", "value", "lli", "ssi")}
    return replace(observations, tables={"G": replace(table, **kept)})


@pytest.fixture(scope="module")
def roof(campaign):
    return cache(Roof)(campaign)


def interval(count, trials):
    """Return the Clopper and Pearson bounds in which a share lies at 95 %."""
    low, high = beta.ppf(0.025, count, trials - count + 1), beta.ppf(0.975, count + 1, trials - count)
    return (0.0 if count == 0 else low), (1.0 if count == trials else high)


def in_words(name, count, trials):
    low, high = interval(count, trials)
    return f"{name} {count} of {trials}: {100 * count / trials:.2f} % ({100 * low:.2f} to {100 * high:.2f})"


def test_the_case_at_hand_is_the_one_asked_about(roof):
    assert len(roof.campaign.rover.time) == 301
    assert len(roof.highest) == NINE
    assert roof.length == pytest.approx(0.991, abs=1e-3)


def test_single_epochs_of_six_satellites_each(roof):
    """Every third of the 84 subsets of six: the length fixes at least twice as many, and at most 0.2 % of all trials wrongly."""
    subsets = list(combinations(roof.highest, 6))[::3]
    trials = 301 * len(subsets)
    assert trials == 28 * 301
    free, known = (np.sum([roof.count(list(s), single_epoch=True, length=length) for s in subsets], axis=0) for length in (None, roof.length))
    for name, (fixed, wrong) in (("without length", free), ("with length", known)):
        print(in_words(f"{name}, fixed", int(fixed), trials), in_words("wrong", int(wrong), trials), sep="; ")
    assert known[0] >= 2 * free[0] > 0
    assert interval(int(known[0]), trials)[0] > 2 * interval(int(free[0]), trials)[1]
    assert known[1] <= 0.002 * trials


@pytest.mark.parametrize(("satellites", "asked"), [(6, 0.89), (5, 0.75)])
def test_single_epochs_of_the_highest(roof, satellites, asked):
    fixed, wrong = roof.count(roof.highest[:satellites], single_epoch=True, length=roof.length)
    assert fixed >= asked * 301
    assert wrong == 0


@pytest.mark.parametrize("satellites", [6, 5])
def test_filter_with_the_length(roof, satellites):
    fixed, wrong = roof.count(roof.highest[:satellites], length=roof.length)
    assert fixed >= 0.99 * 301
    assert wrong == 0
    assert roof.count(roof.highest[:satellites])[0] < 0.75 * 301, "without the length it is harder"


@pytest.mark.parametrize("off", [-0.5 * CM, 0.5 * CM])
def test_five_millimetres_off(roof, off):
    fixed, wrong = roof.count(roof.highest[:6], single_epoch=True, length=roof.length + off)
    assert fixed >= 0.80 * 301
    assert wrong == 0


@pytest.mark.parametrize("off", [-10 * CM, 10 * CM])
@pytest.mark.parametrize("single_epoch", [True, False], ids=["single epochs", "filter"])
@pytest.mark.parametrize("satellites", [6, NINE])
def test_ten_centimetres_off_are_refused_or_not_accepted(roof, off, single_epoch, satellites):
    options = {"systems": "G", "frequencies": 1, "single_epoch": single_epoch, "length": roof.length + off}
    try:
        attitude = dual_antenna_attitude(*roof.receivers(roof.highest[:satellites]), **options)
    except ValueError as error:
        refusal = str(error)
    else:
        assert np.mean(attitude.status == Status.FIXED) <= 0.02
        refusal = " ".join(attitude.warnings)
    assert "0.98" in refusal or "0.99" in refusal, "the length that the measurements agree on is not told"
