"""A monitoring filter that is robust to gross errors and still follows a real step.

Paper B's robust Kalman filter (Li et al. 2021) rejects what is far off, so it rejects a large step as well: above 7 cm for tens of epochs, when
it matters most. This one learns the noise of the series from the series, its correlation in time included (`core.coloured_noise`), clips what is
far off, and decides a few epochs later whether it was an outlier or a step (`core.step_test`). What it gives out is the calmest mean of the
latest solutions that is as quick as the paper's method (`core.recent_mean`); the steady level of its whole memory stands beside.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from gnsslab.core import step_test
from gnsslab.core.coloured_noise import learn_noise
from gnsslab.core.jit import kernel_input, matrix, vector
from gnsslab.core.level_filter import P_RR, P_UU, P_XX, STATE_SIZE
from gnsslab.core.recent_mean import covariance, quick_weights, variances_of_mean
from gnsslab.gnss.relative import Status
from gnsslab.gnss.times import iso_text, usual_step

LEARNT_FROM = 16_384  # latest epochs that the noise is learnt from
LONGEST_BLOCK = 4096  # epochs filtered with the same noise
FEWEST_SOLUTIONS = 16  # the noise is learnt from
SURE = 5.0  # [sigma] of a displacement of the steady level, for an alarm
SURE_OF_RECENT = 4.5  # [sigma] of the recent level, whose errors do not last
FIRST_SIGMA = 2.0  # of the first solution, in sigmas of the noise
# Settings that `step_test.follow` asks for, in its order.
RULES = ("clip", "outlier", "lost", "width", "threshold", "pretest", "story", "sure_story", "settling", "fewest")
PER_METRE = 100.0  # inside, lengths are in centimetres, so that squares are of ordinary size


class Flag(IntEnum):
    """What became of an epoch."""

    OK = step_test.OK
    OUTLIER = step_test.OUTLIER  # far off, or not trusted: it has little or no weight
    STEP = step_test.STEP  # a step was found at this epoch; it began a few epochs before
    GAP = step_test.GAP  # no solution


@dataclass(frozen=True)
class MonitorSettings:
    """Settings of the monitoring filter; epochs are of the series' usual interval. What is above `alarm` was chosen on simulated series."""

    memory: float = 600.0  # [epochs] over which level and rate are fitted
    threshold: float = 12.0  # gain in log likelihood by which a step must explain the last epochs better
    window: int = 64  # [epochs] a step is found within so many, or taken for a slow change
    fewest: int = 3  # epochs with a solution, the first one of the step included, before a step is believed
    clip: float = 3.0  # [sigma] longer innovations are cut to this
    outlier: float = 4.5  # [sigma] longer ones are flagged
    lost: float = 12.0  # log likelihood that a gross error costs
    width: float = 4.0  # [sigma of the noise] of steps that are expected; larger ones are found as well
    story: float = 3.0  # log likelihood by which it must still be better when gross errors are allowed for
    pretest: float = 8.0  # a gain of this much is enough
    sure_story: float = 9.0  # where the step is better by so much even then: a large one
    settling: int = 60  # epochs before any step is believed: the noise is learnt from them
    doubtful: float = 0.1  # solutions whose ratio is below this part of the usual one are not used
    alarm: float = 0.02  # [m] level displacement that the alarm is for

    def __post_init__(self):
        for name, value in vars(self).items():
            if isinstance(value, bool) or not np.isfinite(value) or value < 0 or (value == 0 and name != "doubtful"):
                raise ValueError(f"monitor setting {name} must be a number above zero; it is {value}")
        if self.window < self.fewest:
            raise ValueError(f"the window of {self.window} epochs must hold the {self.fewest} epochs that a step needs: make it longer")


@dataclass(frozen=True, eq=False)
class FoundStep:
    """A step of the ground, as known at the epoch at which it was found."""

    time: np.datetime64  # its first epoch, GPS time
    first: int  # the same, as an index
    found: int  # index of the epoch at which it was found
    size: np.ndarray  # (3,) [m] east, north, up
    sigma: np.ndarray  # (3,) [m]

    def __repr__(self):
        size, sigma = (" ".join(f"{value * 100:.1f}" for value in each) for each in (self.size, self.sigma))
        return f"FoundStep: {iso_text(self.time)}, {size} +- {sigma} cm east north up, found {self.found - self.first} epochs later"


@dataclass(frozen=True, eq=False)
class Monitored:
    """A series of T epochs filtered as it came: each epoch's level knows nothing of later ones."""

    time: np.ndarray  # (T,) datetime64[ns], GPS time
    enu: np.ndarray  # (T, 3) [m] solutions, NaN where there is none
    level: np.ndarray  # (T, 3) [m] where the point is, by the latest 100 solutions at most; NaN before the first one
    sigma: np.ndarray  # (T, 3) [m] of the level
    steady: np.ndarray  # (T, 3) [m] the same by the filter's whole memory: calmer, and later where a step is too small to be found
    sigma_steady: np.ndarray  # (T, 3) [m]
    rate: np.ndarray  # (T, 3) [m/s] how fast it moves
    sigma_rate: np.ndarray  # (T, 3) [m/s]
    flag: np.ndarray  # (T,) int8 of Flag
    alarm: np.ndarray  # (T,) bool
    steps: tuple[FoundStep, ...]

    def __repr__(self):
        outliers, gaps = (int((self.flag == flag).sum()) for flag in (Flag.OUTLIER, Flag.GAP))
        return f"Monitored: {len(self.time)} epochs, {outliers} outliers, {gaps} gaps, {len(self.steps)} steps, {self.alarms} alarms"

    @property
    def alarms(self):
        """How often the alarm went off."""
        return int(np.sum(np.diff(self.alarm.astype(int), prepend=0) == 1))


def monitor(series, settings=None, progress=None):
    """Return the `Monitored` of a `gnss.series.Series`: level, its sigma, flags, steps and alarms, each from the epochs up to it.

    Only fixed solutions are used where there are any, and of these only those whose ratio is not below a tenth of the usual one. The first 60
    epochs are filtered with the noise that they show themselves. The alarm is on from when a step of at least `settings.alarm` on the level is
    found until the point is halfway back, for 600 epochs at most; and from when the point has surely gone that far from where it settled in its
    first 600 epochs (five sigma of the steady level, 4.5 of the recent one), until it is halfway back.
    `progress(done, total)` is called now and then. A series with fewer than 16 solutions raises ValueError.

    >>> from gnsslab.simulate import Shift, find_series_preset, simulate_series, with_shifts
    >>> preset = with_shifts(find_series_preset("b-fixed"), Shift(1000, 1000, (0.1, 0.0, 0.0)))
    >>> found = monitor(simulate_series(preset, np.random.default_rng(1)).series)
    >>> [(step.first, step.found) for step in found.steps], found.alarms
    ([(1000, 1002)], 1)
    """
    settings = settings or MonitorSettings()
    is_used = usable(series, settings.doubtful)
    if is_used.sum() < FEWEST_SOLUTIONS:
        raise ValueError(f"monitoring needs {FEWEST_SOLUTIONS} solutions or more to learn their noise from; the series has {int(is_used.sum())}")
    steady, sigma_steady, rate, sigma_rate, level, sigma, flag, start = _filter(series, is_used, settings, progress)
    flag[series.is_solved & ~is_used] = Flag.OUTLIER
    steps = tuple(_found_step(series.time, steady, sigma_steady, start, found) for found in np.flatnonzero(start >= 0))
    alarm = _alarm_of_steps(steady, steps, settings) | _alarm_of_creep(steady, sigma_steady, is_used, SURE, settings)
    alarm |= _alarm_of_creep(level, sigma, is_used, SURE_OF_RECENT, settings)
    return Monitored(series.time, series.enu, level, sigma, steady, sigma_steady, rate, sigma_rate, flag.astype(np.int8), alarm, steps)


def usable(series, doubtful):
    """Return which epochs (T,) are used: fixed ones where there are any, less those whose ratio is below `doubtful` times the usual one."""
    is_used = series.status == (Status.FIXED if (series.status == Status.FIXED).any() else Status.FLOAT)
    usual = np.nanmedian(series.ratio[is_used]) if np.isfinite(series.ratio[is_used]).any() else np.nan
    return is_used & ~(series.ratio < doubtful * usual)


def _filter(series, is_used, settings, progress):
    """Return steady level and sigma (T, 3) [m], rate and sigma (T, 3) [m/s], level and sigma (T, 3) [m], flag and start of steps (T,)."""
    T, first = len(series), int(np.argmax(is_used))
    origin = series.enu[first]
    z = np.where(is_used[:, None], (series.enu - origin) * PER_METRE, np.nan)
    z_input, dt = kernel_input(z), kernel_input(epochs_since_last(series.time))
    rules = tuple(float(getattr(settings, name)) for name in RULES)
    memory = _empty_memory(settings.window, T)
    out = *(matrix(T, 3) for _ in range(6)), vector(T), vector(T)
    for begin, end in _blocks(is_used, settings.settling):
        past = z[max(first, begin - LEARNT_FROM) : begin] if begin > first else z[first:end]
        noise = _noise_rows(past, settings.memory)
        if begin == first:
            _start(memory[0], noise, settings.memory)
        weights, variances = _recent_weights(noise)
        step_test.follow(z_input, dt, kernel_input(noise), kernel_input(weights), kernel_input(variances), rules, memory, begin, end, out)
        if progress:
            progress(end, T)
    *moments, flag, start = (np.asarray(each) for each in out)
    steady, sigma_steady, rate, sigma_rate, level, sigma = (each / PER_METRE for each in moments)
    second = usual_step(series.time) if T > 1 else 1.0
    found = steady + origin, sigma_steady, rate / second, sigma_rate / second, level + origin, sigma
    for each in found:
        each[:first] = np.nan
    flag[:first], start[:first] = Flag.GAP, step_test.NO_STEP
    return *found, flag, start.astype(int)


def epochs_since_last(time):
    """Return how many usual intervals (T,) lie between each epoch and the one before; 1 for the first.

    >>> epochs_since_last(np.array(["2024-01-01", "2024-01-02", "2024-01-03", "2024-01-05"], "M8[ns]")).tolist()
    [1.0, 1.0, 1.0, 2.0]
    """
    if len(time) < 2:
        return np.ones(len(time))
    seconds = np.diff(time).astype("timedelta64[ns]").astype(float) / 1e9
    return np.concatenate([[1.0], seconds / usual_step(time)])


def _blocks(is_used, settling):
    """Yield begin and end of the stretches that are filtered with the same noise: they get longer as more of the noise is known."""
    used = np.flatnonzero(is_used)
    begin, count = int(used[0]), settling
    while count < len(used):
        yield begin, int(used[count])
        begin, count = int(used[count]), count + min(count, LONGEST_BLOCK)
    yield begin, len(is_used)


def _noise_rows(z, memory):
    """Return the noise (3, 4) of positions z (T, 3) as `level_filter` wants it; the rate changes as fast as it takes to forget in `memory` epochs."""
    learnt = [learn_noise(axis) for axis in z.T]
    return np.array([[*noise, noise.long_run / memory**4] for noise in learnt])


def _recent_weights(noise):
    """Return weights and variances (3, 100) of the quick mean on each axis."""
    Q = [covariance(*row[:3]) for row in noise]
    weights = [quick_weights(each) for each in Q]
    return np.array(weights), np.array([variances_of_mean(h, each) for h, each in zip(weights, Q, strict=True)])


def _empty_memory(window, T):
    starts = vector(window)
    for c in range(window):
        starts[c] = float(step_test.NO_STEP)
    axes = step_test.AXES
    return (
        matrix(axes, STATE_SIZE),
        matrix(window, step_test.EFFECT_SIZE * axes),
        matrix(window, STATE_SIZE * axes),
        starts,
        matrix(T, axes),
        vector(T),
        vector(2),
    )


def _start(state, noise, memory):
    """Let the level be that of the first solution, as good as the noise is, and the rate what it may become within the memory."""
    for axis, (white, coloured, _, walk) in enumerate(noise):
        state[axis][P_XX], state[axis][P_UU] = FIRST_SIGMA**2 * (white + coloured), coloured
        state[axis][P_RR] = walk * memory


def _found_step(time, level, sigma, start, found):
    first = int(start[found])
    return FoundStep(time[first], first, int(found), level[found] - level[first - 1], np.hypot(sigma[found], sigma[first - 1]))


def _alarm_of_steps(level, steps, settings):
    """Return where (T,) the point is displaced by a step that was large enough: until it is halfway back, or the memory's length."""
    alarm = np.zeros(len(level), dtype=bool)
    for step in steps:
        if np.hypot(*step.size[:2]) >= settings.alarm:
            offset = level[step.found :] - level[step.first - 1]
            is_back = np.hypot(offset[:, 0], offset[:, 1]) < settings.alarm / 2
            is_back[int(settings.memory) :] = True  # by now this is where the point is
            alarm[step.found : step.found + (int(np.argmax(is_back)) if is_back.any() else len(is_back))] = True
    return alarm


def _alarm_of_creep(level, sigma, is_used, sure, settings):
    """Return where (T,) the level has gone farther than the alarm's threshold from where it settled, and surely so: until it is halfway back."""
    used = np.flatnonzero(is_used)
    settled = int(used[min(int(settings.memory), len(used) - 1)])
    offset, spread = level[:, :2] - level[settled, :2], np.hypot(sigma[:, :2], sigma[settled, :2])
    distance = np.where(np.arange(len(level)) > settled, np.hypot(offset[:, 0], offset[:, 1]), 0.0)
    goes_off = (distance > settings.alarm) & (distance > sure * np.sqrt(np.mean(spread**2, axis=1)))
    return held(goes_off, distance < settings.alarm / 2)


def held(goes_on, goes_off):
    """Return what is on (T,) from each True of `goes_on` to the next of `goes_off`.

    >>> held(np.array([0, 1, 0, 0, 0], bool), np.array([0, 0, 0, 1, 0], bool)).tolist()
    [False, True, True, False, False]
    """
    switched = np.where(goes_on, 1, np.where(goes_off, 0, -1))
    last = np.maximum.accumulate(np.where(switched >= 0, np.arange(len(switched)), -1))
    return (last >= 0) & (switched[last] == 1)
