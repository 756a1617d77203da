"""Loss maps: where in the image a strategy's squared error arises.

The first map of a strategy marks the fewest square blocks of pixels that make half of its squared error. The second
map compares the error with the baseline's, block by block.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.experiments.report.looks import Style
from equaltime.experiments.report.pictures import Bar, Pictures, colour_bar, coloured, data_uri
from equaltime.experiments.report.words import percent
from equaltime.images.preview import reduced, srgb_bytes
from equaltime.statistics.intervals import sound

__all__ = ["INTRODUCTION", "LEVEL", "LossView", "Losses", "losing", "losses", "ratio_sentence"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Bytes = NDArray[np.uint8]

LEVEL = 0.001
"""Significance level at which a strategy's error in a block of pixels is called worse or better than the baseline's."""
_DIFFERENT = 1.1
"""Smallest ratio of errors over the whole picture that a sentence sets against what the blocks show."""
_LEAST_SHOWN = 0.5
"""Smallest share of a larger error over the whole picture in significant blocks with which these explain it."""
_SHOWN = 1.005
"""Smallest ratio that three digits tell from 1."""
_BLOCKS = 28
_FEWEST = 3

_RATIOS = "PuOr_r"
_MARK = np.array([232.0, 165.0, 0.0])

INTRODUCTION = (
    "Left, in amber: the fewest blocks of pixels that make half of a strategy's squared error. Right, in colour: where "
    "the strategy's error at equal time differs from the baseline's. Grey: no difference beyond chance "
    f"(Welch's t-test over repeats, level {LEVEL:g} for each block: of 1000 blocks, chance colours about "
    f"{1000 * LEVEL:g}). A difference beyond chance may be small. Where rare bright samples make an error, the test "
    "finds few losses, and finds gains where no such sample came. The error is noise, and for a biased strategy bias "
    "too."
)


@dataclass(frozen=True)
class LossView:
    """Two loss maps of one strategy for a page, which show where its squared error arises, each with a sentence.

    The first map (``half``) marks the blocks of pixels that make half of the strategy's squared error. The second map
    (``ratio``) shows the strategy's error divided by the baseline's. ``ratio_uri`` and ``ratio_alt`` are empty without
    a second map.
    """

    label: str
    look: Style
    half_uri: str
    half_alt: str
    ratio_uri: str
    ratio_alt: str
    sentences: tuple[str, ...]


def losing(
    scene: SceneResult, pictures: Pictures, looks: Mapping[str, Style], longest: int
) -> tuple[tuple[LossView, ...], Bar | None]:
    """Return two maps for each strategy of a scene, which show where its error arises, and the second maps' colour bar.

    The first map shows the blocks of pixels that make half of the strategy's squared error. The second map compares the
    error with the baseline's. The bar is None if no strategy can be compared with the baseline. Maps are drawn over the
    reference in grey; each side has at most ``longest`` pixels. ``pictures`` are the images of the scene. ``looks``
    gives colour, marker and line style by label of a strategy.
    """
    factors = {strategy.label: _to_equal_time(strategy) for strategy in scene.strategies}
    equal = {label: own * factors[label] for label, own in pictures.squares.items()}
    baseline = equal.get(scene.baseline)
    apart = {scene.baseline} | {one.label for one in scene.strategies if _is_of_another_picture(one)}
    if _is_of_another_picture(next(one for one in scene.strategies if one.label == scene.baseline)):
        baseline = None
    found = {label: losses(own, None if label in apart else baseline) for label, own in equal.items()}
    most = _most(found)
    grey = _grey(pictures)
    views = tuple(
        _view(scene.baseline, one, looks[one.label], found[one.label], grey, most, longest)
        for one in scene.strategies
        if one.label in found
    )
    ticks = (f"1/{most:g} of the baseline's error or less", "equal", f"{most:g} times or more")
    return views, Bar(colour_bar(_RATIOS), ticks) if any(view.ratio_uri for view in views) else None


def _most(found: Mapping[str, Losses]) -> float:
    """Return the ratio at which the colours end: the power of 2 (2 to 64) that covers 90 % of significant ratios."""
    sure = [
        np.abs(np.log2(np.maximum(one.ratio[one.worse | one.better], 1e-9)))
        for one in found.values()
        if one.ratio is not None and one.worse is not None and one.better is not None
    ]
    logs = np.concatenate([np.zeros(1), *sure])
    return float(2.0 ** np.clip(np.ceil(np.percentile(logs[np.isfinite(logs)], 90.0)), 1.0, 6.0))


def _is_of_another_picture(strategy: StrategyResult) -> bool:
    """Tell whether a strategy gets no error at its end because its picture is another one: it cannot be compared."""
    errors = strategy.curve.error
    return strategy.disagrees and bool(errors) and not errors[-1].known


def _to_equal_time(strategy: StrategyResult) -> float:
    """Return the factor from squared errors at a run's end to squared errors at equal time."""
    if not strategy.curve.error:
        return 1.0
    ended, wanted = strategy.curve.error[-1].value, strategy.error_at_budget.value
    factor = (wanted / ended) ** 2 if ended > 0.0 and wanted > 0.0 else 1.0
    return factor if math.isfinite(factor) else 1.0


def _view(
    baseline: str, strategy: StrategyResult, look: Style, found: Losses, grey: Floats, most: float, longest: int
) -> LossView:
    label = strategy.label
    half = found.spread(found.half, grey.shape)[..., None]
    painted = np.where(half, 0.35 * grey + 0.65 * _MARK, grey)
    sentences = [_half_sentence(found)]
    half_alt = f"Map of where half of the squared error of {label} comes from: {sentences[0]}"
    ratio_uri = ratio_alt = ""
    if found.ratio is not None:
        sentences.append(ratio_sentence(found, baseline))
        if (ratios := _ratio_map(found, grey, most)) is not None:
            ratio_uri = data_uri(_bytes(ratios, longest))
            ratio_alt = f"Map of the error of {label} over that of {baseline}: {sentences[-1]}"
            sentences += [_bias_sentence(strategy, baseline)] * bool(strategy.remark)
    return LossView(label, look, data_uri(_bytes(painted, longest)), half_alt, ratio_uri, ratio_alt, tuple(sentences))


def _bias_sentence(strategy: StrategyResult, baseline: str) -> str:
    """Return what the second map shows of the bias of a biased strategy."""
    bias = strategy.bias
    size = f" of {percent(float(f'{bias.value:.2g}'))}" if bias is not None and sound(bias) else ""
    return f"Its error contains its bias{size}: a block shows the bias only where the noise of {baseline} is smaller."


def _half_sentence(found: Losses) -> str:
    if not found.half.any():
        return "It has no error that the reference can show."
    part = "less than 1 %" if found.half_area < 0.01 else percent(round(found.half_area, 2))
    return f"Half of its squared error comes from {part} of the picture{_place(found.half, found.half_area)}."


def ratio_sentence(found: Losses, baseline: str) -> str:
    """Return in words where the errors of a strategy and of ``baseline`` differ beyond chance, and by how much.

    A second sentence follows if these blocks do not explain the error over the whole picture. ``found`` is a result of
    `losses` with a ratio.
    """
    if found.ratio is None or found.worse is None or found.better is None:
        return f"Fewer than three repeats cannot show where it is worse than {baseline}."
    worse, better = float(found.worse.mean()), float(found.better.mean())
    if not found.worse.any():
        rest = f", better in {_part(better)} of the picture" if found.better.any() else ", nor better"
        return f"Nowhere worse than {baseline} beyond chance{rest}.{_elsewhere(found, baseline)}"
    rest = f"better in {_part(better)}" if found.better.any() else "nowhere better"
    return (
        f"Beyond chance, worse than {baseline} in {_part(worse)} of the picture{_place(found.worse, worse)}, with "
        f"{_factor(float(np.median(found.ratio[found.worse])))} in the median; {rest}.{_elsewhere(found, baseline)}"
    )


def _elsewhere(found: Losses, baseline: str) -> str:
    """Return a sentence if the blocks do not explain a larger error, or contradict a smaller one; else empty."""
    larger = _DIFFERENT <= found.whole < math.inf and found.shown < _LEAST_SHOWN
    smaller = found.whole <= 1.0 / _DIFFERENT and found.shown < 0.0
    if not (larger or smaller):
        return ""
    return (
        f" Over the whole picture its measured error is {_times(found.whole)} that of {baseline}. Most of the "
        "difference lies in blocks where it may be chance, as where rare bright samples fell."
    )


def _factor(ratio: float) -> str:
    """Return an error that is larger than the baseline's in words, such as 2.5 times its error."""
    if not math.isfinite(ratio):
        return "error where that has none"
    return f"{_times(ratio)} its error" if ratio >= _SHOWN else "hardly more than its error"


def _times(factor: float) -> str:
    """Return a factor with two digits, or three within 10 % of 1, where two would read 1."""
    digits = 3 if 1.0 <= factor < 1.1 else 2
    text = f"{float(f'{factor:.2g}'):,.0f}" if factor >= 100.0 else f"{factor:.{digits}g}"
    return f"{text}\N{MULTIPLICATION SIGN}"


def _part(part: float) -> str:
    return "less than 1 %" if 0.0 < part < 0.005 else percent(round(part, 2))


def _place(flags: NDArray[np.bool_], part: float) -> str:
    """Return the position of marked blocks in words; empty if they are spread out."""
    rows, columns = np.nonzero(flags)
    if part > 0.5 or rows.size == 0:
        return ""
    y, x = (rows + 0.5) / flags.shape[0], (columns + 0.5) / flags.shape[1]
    if y.std() > 0.2 or x.std() > 0.2:
        return ""
    height = ("upper", "middle", "lower")[min(2, int(3.0 * y.mean()))]
    side = ("left", "centre", "right")[min(2, int(3.0 * x.mean()))]
    return ", in its " + ("centre" if (height, side) == ("middle", "centre") else f"{height} {side}")


def _ratio_map(found: Losses, grey: Floats, most: float) -> Floats | None:
    """Colour the blocks with a significant ratio; None with too few repeats for a test."""
    if found.ratio is None or found.worse is None or found.better is None:
        return None
    ratio = np.where(np.isnan(found.ratio), 1.0, found.ratio)
    colours = coloured(np.asarray(found.spread(ratio, grey.shape)), 1.0 / most, most, _RATIOS)
    sure = found.spread(found.worse | found.better, grey.shape)[..., None]
    return np.asarray(np.where(sure, 0.25 * grey + 0.75 * colours, grey))


def _grey(pictures: Pictures) -> Floats:
    """Return the reference in grey with reduced contrast (H, W, 3), so that marks stand out."""
    shown = srgb_bytes(pictures.reference.mean, pictures.stops).astype(np.float64).mean(axis=2, keepdims=True)
    return np.repeat(60.0 + 0.5 * shown, 3, axis=2)


def _bytes(values: Floats, longest: int) -> Bytes:
    return np.asarray(np.round(np.clip(reduced(values, longest), 0.0, 255.0)), np.uint8)


@dataclass(frozen=True, eq=False)
class Losses:
    """Distribution of a strategy's error over square blocks of pixels, for maps of where it loses.

    Each array has one value per block: (rows of blocks, columns of blocks).
    """

    block: int
    """Side of a block in pixels; the last block of a row or column may be smaller."""
    half: Flags
    """True in the fewest blocks that make up half of the squared error."""
    half_area: float
    """Share of the image that the blocks of ``half`` cover, in [0, 1]."""
    ratio: Floats | None
    """Strategy's error divided by the baseline's error at equal time; None for the baseline itself."""
    worse: Flags | None
    """True in blocks whose error is significantly larger than the baseline's; None with fewer than three repeats."""
    better: Flags | None
    """True in blocks whose error is significantly smaller than the baseline's; None with fewer than three repeats."""
    whole: float = math.nan
    """Strategy's error over the whole picture divided by the baseline's, at equal time; NaN for the baseline itself."""
    shown: float = math.nan
    """Share of the difference of squared errors over the whole picture in the blocks of ``worse`` and ``better``.

    It is negative if these blocks differ the other way, and NaN with fewer than three repeats."""

    def spread(self, flags: NDArray[np.generic], shape: tuple[int, ...]) -> NDArray[np.generic]:
        """Return an image (H, W) in which each pixel has the value of its block in ``flags``.

        ``flags`` has one value per block, (rows of blocks, columns of blocks), and ``shape`` is (H, W).
        """
        return flags.repeat(self.block, axis=0).repeat(self.block, axis=1)[: shape[0], : shape[1]]


def losses(own: Floats, baseline: Floats | None) -> Losses:
    """Return the blocks of pixels that make half of a strategy's squared error, and a comparison with the baseline.

    Parameters
    ----------
    own
        Squared errors of the strategy's pixels in K repeats, (K, H, W), scaled to equal render time.
    baseline
        Squared errors of the baseline's pixels in K repeats, (K, H, W), scaled to equal render time; None if the
        strategy is the baseline.
    """
    block = max(1, math.ceil(max(own.shape[1:]) / _BLOCKS))
    mine = _block_sums(own, block)
    total = np.maximum(mine.mean(axis=0), 0.0)
    half = _fewest_that_make_half(total)
    area = _block_sums(np.ones((1, *own.shape[1:])), block)[0]
    half_area = float(area[half].sum() / area.sum())
    if baseline is None:
        return Losses(block, half, half_area, None, None, None)
    theirs = _block_sums(baseline, block)
    reference = np.maximum(theirs.mean(axis=0), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.sqrt(total / reference)
        whole = float(np.sqrt(max(own.mean(), 0.0) / np.float64(max(baseline.mean(), 0.0))))
    sure = _significant(mine, theirs)
    if sure is None:
        return Losses(block, half, half_area, ratio, None, None, whole)
    worse, better = sure
    difference = mine.mean(axis=0) - theirs.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        shown = float(difference[worse | better].sum() / difference.sum())
    return Losses(block, half, half_area, ratio, worse, better, whole, shown)


def _block_sums(pixels: Floats, block: int) -> Floats:
    rows = np.add.reduceat(pixels, np.arange(0, pixels.shape[1], block), axis=1)
    return np.asarray(np.add.reduceat(rows, np.arange(0, pixels.shape[2], block), axis=2))


def _fewest_that_make_half(total: Floats) -> Flags:
    order = np.argsort(total, axis=None)[::-1]
    running = np.cumsum(total.ravel()[order])
    chosen = np.zeros(total.size, np.bool_)
    chosen[order[: int(np.searchsorted(running, 0.5 * running[-1])) + 1]] = running[-1] > 0.0
    return chosen.reshape(total.shape)


def _significant(mine: Floats, theirs: Floats) -> tuple[Flags, Flags] | None:
    """Compare blocks by Welch's t-test over repeats; return the blocks where the first is worse, and better."""
    if min(len(mine), len(theirs)) < _FEWEST:
        return None
    difference = mine.mean(axis=0) - theirs.mean(axis=0)
    own, other = mine.var(axis=0, ddof=1) / len(mine), theirs.var(axis=0, ddof=1) / len(theirs)
    from scipy import stats  # late: slow to import

    spread = own + other
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = spread**2 / (own**2 / (len(mine) - 1) + other**2 / (len(theirs) - 1))
        chance = 2.0 * stats.t.sf(np.abs(difference) / np.sqrt(spread), freedom)
    sure = np.nan_to_num(chance, nan=1.0) < LEVEL
    return sure & (difference > 0.0), sure & (difference < 0.0)
