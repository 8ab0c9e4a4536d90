"""Pictures of trust in a fix: the success rate promised and counted, what a test looks at, and what tests make of all epochs."""

from typing import NamedTuple

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Patch
from matplotlib.ticker import FixedFormatter, FixedLocator, NullFormatter, NullLocator

from gnsslab.figures.kept import Scene, new_figure, styled
from gnsslab.figures.shares import percent

RIGHT, WRONG, DARK, BOUNDS, FAINT = "#0072B2", "#D55E00", "#111111", "#009E73", "#777777"
RIGHT_REJECTED, WRONG_REJECTED, SHADE = "#B5D6EA", "#F6CFB4", "#E9E9E9"
HATCH = "////"
RATES = {0.01: "1", 0.1: "10", 0.5: "50", 0.9: "90", 0.99: "99", 0.999: "99.9", 0.9999: "99.99"}
LOWEST_RATE, HIGHEST_RATE = 0.004, 0.99997  # what is beyond stands at the edge, and its number beside it
LEAST_SHARE = 0.005  # [%], foot of the histogram: half of one epoch in 10 000
BELOW = LEAST_SHARE / 2  # where nothing stands: out of sight
ROWS_OF_BARS = 5
ROWS = ("counted", "bootstrapping", "ADOP", "variances\nand ADOP", "pull-in\nregion", "eigenvalues")


def plot_trust(result, figure=None):
    """Draw both pictures of a TrustResult side by side; return the Figure."""
    with styled():
        figure = figure if figure is not None else new_figure(860, 480)
        tests, promised = figure.subfigures(1, 2, width_ratios=(460, 400))
        for build, part in ((build_tests, tests), (build_promised, promised)):
            build(part).show(result)
    return figure


def build_tests(figure):
    """Lay out the histogram of what the test looks at and, below, a bar for each test; show(result) fills them in."""
    seen, bars = _Seen(figure.add_axes((0.125, 0.565, 0.845, 0.335))), _Bars(figure.add_axes((0.265, 0.02, 0.44, 0.42)))
    figure.legend(
        handles=[
            Patch(facecolor=RIGHT, label="fixed, right"),
            Patch(facecolor=WRONG, edgecolor="white", hatch=HATCH, linewidth=0, label="fixed, wrong"),
            Patch(facecolor=RIGHT_REJECTED, label="rejected, right"),
            Patch(facecolor=WRONG_REJECTED, label="rejected, wrong"),
        ],
        loc="upper center", ncols=2, bbox_to_anchor=(0.52, 1.005), fontsize=9, handlelength=1.6, columnspacing=2.0, labelspacing=0.25,
    )  # fmt: skip

    def show(result):
        bars.show(result)
        return seen.show(result)

    return Scene((*seen.moving, *bars.moving), show)


def build_promised(figure):
    """Lay out one row for the count and one for each claim; show(result) fills them in."""
    rates = _Rates(figure.add_axes((0.245, 0.12, 0.55, 0.76)))
    return Scene(rates.moving, rates.show)


class _Rates:
    """Success rates on an axis that spreads out what lies near 0 and near 1: the logarithm of the odds."""

    def __init__(self, axes):
        self.rows = dict(zip(ROWS, range(len(ROWS) - 1, -1, -1), strict=True))
        axes.set(xlim=_odds([LOWEST_RATE, HIGHEST_RATE]), ylim=(-0.6, len(ROWS) - 0.4), autoscale_on=False)
        axes.xaxis.set_major_locator(FixedLocator(_odds(list(RATES))))
        axes.xaxis.set_major_formatter(FixedFormatter(list(RATES.values())))
        axes.yaxis.set_major_locator(FixedLocator(list(self.rows.values())))
        axes.yaxis.set_major_formatter(FixedFormatter(list(self.rows)))
        axes.tick_params(axis="y", length=0, labelsize=9.5)
        axes.tick_params(axis="x", labelsize=8)
        axes.set_xlabel("fixes that are right [%]")
        axes.set_title("promised by the model, and counted", fontsize=10)
        axes.axhline(len(ROWS) - 1.5, color=FAINT, linewidth=0.8)
        (self.line,) = axes.plot([], [], "--", color=DARK, linewidth=1.0)
        (self.bar,) = axes.plot([], [], color=DARK, linewidth=2.2, solid_capstyle="butt")
        (self.count,) = axes.plot([], [], "o", color=DARK, markersize=8, clip_on=False)
        (self.unbiased,) = axes.plot([], [], "o", color=DARK, markersize=8, fillstyle="none", clip_on=False)
        (self.bootstrapped,) = axes.plot([], [], ">", color=RIGHT, markersize=9, clip_on=False)
        (self.adop,) = axes.plot([], [], "D", color=WRONG, markersize=7, clip_on=False)
        self.bounds = [axes.plot([], [], "|-", color=BOUNDS, linewidth=3, markersize=11, markeredgewidth=2)[0] for _ in ROWS[3:]]
        self.texts = [axes.text(1.03, row, "", transform=axes.get_yaxis_transform(), va="center", fontsize=9.5) for row in self.rows.values()]

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.line, *self.bounds, self.bootstrapped, self.adop, self.bar, self.unbiased, self.count, *self.texts)

    def show(self, result):
        """Fill in the count with its interval, and the claims; the frame never changes."""
        counted, top = result.counted, len(ROWS) - 1
        (x,) = _odds([counted.rate])
        self.line.set_data([x, x], [-0.6, top])
        self.bar.set_data(_odds(counted.interval), [top, top])
        self.count.set_data([x], [top])
        is_moved = result.unbiased != counted
        self.unbiased.set_data(*(_odds([result.unbiased.rate]), [top]) if is_moved else ((), ()))
        for artist, claim in zip((self.bootstrapped, self.adop, *self.bounds), result.model.claims, strict=True):
            ends = [claim.low] if claim.low == claim.high else [claim.low, claim.high]
            artist.set_data(_odds(ends), [self.rows[_row_of(claim)]] * len(ends))
        for text, words in zip(self.texts, (f"{percent(counted.rate)} %", *map(_claimed, result.model.claims)), strict=True):
            text.set_text(words)
        return None


class _Seen:
    """How often the test sees which value, with right and with wrong integers; the side that is fixed is shaded."""

    def __init__(self, axes):
        self.axes, self.look = axes, None
        axes.set(yscale="log", ylim=(LEAST_SHARE, 100))
        axes.yaxis.set_major_locator(FixedLocator([0.01, 0.1, 1, 10, 100]))
        axes.yaxis.set_major_formatter(FixedFormatter(["0.01", "0.1", "1", "10", "100"]))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.set_ylabel("epochs [%]", labelpad=1)
        self.shade = axes.add_collection(PolyCollection([], facecolor=SHADE, linewidths=0))
        colors = ((RIGHT_REJECTED, None), (RIGHT, None), (WRONG_REJECTED, None), (WRONG, HATCH))
        self.parts = [
            axes.add_collection(PolyCollection([], facecolor=color, edgecolor="white", hatch=hatch, linewidths=0)) for color, hatch in colors
        ]
        (self.outline,) = axes.plot([], [], color=RIGHT, linewidth=1.4)
        (self.threshold,) = axes.plot([], [], "--", color=DARK, linewidth=1.4)
        self.word = axes.text(0, 45, "fixed", ha="center", va="center", fontsize=9, color="#333333")

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (self.shade, *self.parts, self.outline, self.threshold, self.word)

    def show(self, result):
        """Fill in the shares; return the axis' label, which tells one frame from another."""
        look = LOOKS[result.settings["test"]]
        self._lay_out(look)
        left, right = np.clip(result.accepted_range, look.edges[0], look.edges[-1])
        self.shade.set_verts([[(left, LEAST_SHARE), (left, 100), (right, 100), (right, LEAST_SHARE)]])
        shares = [_shares(result, chosen, look.edges) for chosen in (result.is_right, ~result.is_right)]
        for k, heights in enumerate(shares):
            self.parts[2 * k].set_verts([_steps(look.edges, heights, look.edges[0], look.edges[-1])])
            self.parts[2 * k + 1].set_verts([_steps(look.edges, heights, left, right)])
        self.outline.set_data(*_steps(look.edges, shares[0], look.edges[0], look.edges[-1]).T)
        ends = [end for end in result.accepted_range if look.edges[0] < end < look.edges[-1]]
        self.threshold.set_data(np.repeat(ends, 2), [LEAST_SHARE, 100] * len(ends))
        self.word.set_x(np.sqrt(left * right) if look.log else (left + right) / 2)
        self.word.set_visible(look.wide(left, right))
        return look.label

    def _lay_out(self, look):
        """Give the axis to another test."""
        if look is self.look:
            return
        self.look = look
        self.axes.set_xscale("log" if look.log else "linear")
        self.axes.set_xlim(look.edges[0], look.edges[-1])
        self.axes.xaxis.set_major_locator(FixedLocator(look.ticks))
        self.axes.xaxis.set_major_formatter(FixedFormatter([f"{tick:g}" for tick in look.ticks]))
        self.axes.xaxis.set_minor_locator(NullLocator())
        self.axes.xaxis.set_minor_formatter(NullFormatter())
        self.axes.set_xlabel(look.label, labelpad=1)


class _Look(NamedTuple):
    """How the values that one test looks at are put on an axis; what is beyond stands in the last bin."""

    label: str
    edges: np.ndarray
    ticks: tuple
    log: bool

    def wide(self, left, right):
        """Return whether a word fits between two values."""
        span = np.log(right / left) / np.log(self.edges[-1] / self.edges[0]) if self.log else (right - left) / self.edges[-1]
        return bool(span > 0.15)


_OF_RATIO = _Look("ratio: second best over best", np.geomspace(1, 100, 41), (1, 2, 3, 5, 10, 20, 50, 100), log=True)
LOOKS = {
    "ratio": _OF_RATIO,
    "tolerated": _OF_RATIO,
    "difference": _Look("difference: second best minus best", np.geomspace(0.1, 200, 41), (0.1, 1, 10, 100), log=True),
    "projector": _Look("projector: towards the second best [sigmas]", np.linspace(0, 8, 41), tuple(range(9)), log=False),
}


class _Bars:
    """One bar a test: what became of all epochs, and beside it how many are believed and how many of those are wrong."""

    def __init__(self, axes):
        axes.set(xlim=(0, 100), ylim=(0.45, ROWS_OF_BARS + 0.9), autoscale_on=False)
        axes.axis("off")
        for x, words, side in ((0, "share of all epochs", "left"), (126, "fixed %", "right"), (160, "wrong %", "right")):
            axes.text(x, ROWS_OF_BARS + 0.7, words, ha=side, va="center", fontsize=9)
        colors = ((RIGHT, None), (WRONG, HATCH), (WRONG_REJECTED, None), (RIGHT_REJECTED, None))
        self.parts = [
            axes.add_collection(PolyCollection([], facecolor=color, edgecolor="white", hatch=hatch, linewidths=0)) for color, hatch in colors
        ]
        self.texts = [_row_of_texts(axes, ROWS_OF_BARS - row, {} if row else {"fontweight": "bold"}) for row in range(ROWS_OF_BARS)]
        axes.axhline(ROWS_OF_BARS - 0.5, color=FAINT, linewidth=0.8, xmin=-0.57, xmax=1.6, clip_on=False)

    @property
    def moving(self):
        """The artists that change with every result, lowest first."""
        return (*self.parts, *(text for row in self.texts for text in row))

    def show(self, result):
        """Fill in the bars, the chosen test on top."""
        ends = 100 * np.cumsum([(0.0, *judged.shares) for judged in result.judged], axis=1)  # (rows, 5)
        for k, part in enumerate(self.parts):
            part.set_verts([_bar(row[k], row[k + 1], ROWS_OF_BARS - place) for place, row in enumerate(ends)])
        for judged, texts in zip(result.judged, self.texts, strict=True):
            words = (words_of_test(judged, result.settings), percent(judged.shares.fixed), percent(judged.shares.fixed_wrong))
            for text, word in zip(texts, words, strict=True):
                text.set_text(word)


def _row_of_texts(axes, y, style):
    """Return the texts beside one bar: name, share that is fixed, share that is fixed wrong."""
    return [axes.text(x, y, "", ha="right", va="center", fontsize=9, **style) for x in (-3, 126, 160)]


def words_of_test(judged, settings):
    """Return what stands beside a bar: the test and its threshold."""
    c = f"{judged.threshold:.3g}"
    names = {"none": "no test", "constant": f"ratio {c}", "of n": f"1 + 16/n: {c}", "tolerated": f"{settings['tolerance']:g} % fail: {c}"}
    if judged.name in names:
        return names[judged.name]
    written = {"upside-down": "upside down", "mixed": f"ratio 1/{c}"}
    if settings["test"] in ("ratio", "tolerated"):
        return written.get(settings["written"], f"ratio {c}")
    return f"{settings['test']} {c}"


def describe_trust(result):
    """Return the pictures in words, for those who cannot see them."""
    model, counted, claims = result.model, result.counted, result.model.claims
    low, high = counted.interval
    bounds = "; ".join(f"{claim.name} {percent(claim.low)} to {percent(claim.high)} %" for claim in claims[2:])
    bars = "; ".join(
        f"{words_of_test(judged, result.settings)}: {percent(judged.shares.fixed)} % fixed, {percent(judged.shares.fixed_wrong)} % fixed wrong, "
        f"{percent(judged.shares.rejected_right)} % right but rejected"
        for judged in result.judged
    )
    return (
        f"A model with {len(model.Q)} ambiguities. Promised: bootstrapping {percent(claims[0].low)} %, ADOP about {percent(claims[1].low)} %; "
        f"bounds: {bounds}. "
        f"Counted in {counted.samples} epochs: {percent(counted.rate)} % right, between {percent(low)} and {percent(high)} %. "
        f"A histogram of what the test looks at, right and wrong fixes apart, the side that is fixed shaded. Bars: {bars}."
    )


def _shares(result, chosen, edges):
    """Return the share [%] of all epochs in each bin, of the chosen ones (N,) bool."""
    values = np.clip(result.statistic[chosen], edges[0], edges[-1])
    return 100 * np.histogram(values, edges)[0] / len(chosen)


def _steps(edges, heights, left, right):
    """Return the outline (k, 2) of a histogram between two values, from the foot of the axis."""
    x = np.clip(np.repeat(edges, 2), left, right)
    y = np.maximum(np.concatenate([[0.0], np.repeat(heights, 2), [0.0]]), BELOW)
    return np.column_stack([x, y])


def _bar(left, right, y):
    """Return the corners of one part of a bar."""
    return [(left, y - 0.36), (left, y + 0.36), (right, y + 0.36), (right, y - 0.36)]


def _claimed(claim):
    """Return a claim's numbers as they stand beside it."""
    return f"{percent(claim.low)} %" if claim.low == claim.high else f"{percent(claim.low)} to\n{percent(claim.high)} %"


def _odds(rates):
    """Return the logarithm of the odds of rates, those beyond the axis put at its edge."""
    p = np.clip(np.asarray(rates, dtype=float), LOWEST_RATE, HIGHEST_RATE)
    return np.log(p / (1 - p))


def _row_of(claim):
    """Return the label of a claim's row."""
    return next(row for row in ROWS if row.replace("\n", " ") == claim.name)
