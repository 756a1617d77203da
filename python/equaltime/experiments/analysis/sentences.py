"""Parts of sentences that verdicts share: where a number holds, and ratios in words."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from equaltime.statistics.in_words import about, figure, span
from equaltime.statistics.intervals import Interval

__all__ = [
    "LONGEST",
    "WHAT_TO_DO",
    "Answer",
    "across",
    "compared",
    "equal_samples",
    "joined",
    "less_time",
    "listed",
    "times",
    "where",
]

LONGEST: Final = 320
"""Characters that a verdict may have: two lines of 160."""
WHAT_TO_DO: Final = "What to do"
"""Beginning of the note that tells the runs which would answer better."""
_ROOM: Final = 220
"""Characters that the items of an enumeration in a verdict may have; the rest is for the words around them."""


@dataclass(frozen=True)
class Answer:
    """Answer to an experiment's question in a line or two, and sentences on what limits the answer."""

    text: str
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, sentences: Sequence[str], notes: Iterable[str]) -> Answer:
        """Return the answer in as many of its sentences as `LONGEST` allows, at least one; the rest becomes notes."""
        told = list(sentences[:1])
        for sentence in sentences[1:]:
            if len(" ".join((*told, sentence))) > LONGEST:
                break
            told.append(sentence)
        return cls(" ".join(told), (*sentences[len(told) :], *filter(None, notes)))

    @classmethod
    def listing(cls, beginning: str, items: Sequence[str], joined: Callable[[Sequence[str]], str]) -> Answer:
        """Return one sentence that lists ``items``, whose words begin with ``beginning``.

        ``joined`` joins the items. Those that would make the sentence too long are only counted, and a note has all.
        """
        kept = list(items[:1])
        for item in items[1:]:
            if len(", ".join((*kept, item))) > _ROOM:
                break
            kept.append(item)
        if len(kept) == len(items):
            return cls(f"{beginning}{joined(items)}.")
        return cls(f"{beginning}{', '.join(kept)}, and {len(items) - len(kept)} more.", (f"In full: {joined(items)}.",))

    def then(self, sentence: str) -> Answer:
        """Return a copy with one more sentence, which may be empty: in the answer if `LONGEST` allows, else a note."""
        return Answer.of((self.text, sentence), self.notes) if sentence else self

    def noted(self, notes: Iterable[str]) -> Answer:
        """Return a copy with more notes; empty ones are left out."""
        return Answer(self.text, (*self.notes, *filter(None, notes)))


def where(names: Sequence[str], count: int) -> str:
    """Return the beginning of a sentence on numbers that hold on the scenes ``names``, such as ``On box``.

    ``count`` is the number of scenes of the experiment; several scenes are called a geometric mean.
    """
    if count == 1:
        return f"On {names[0]}"
    if len(names) == 1:
        return f"On {names[0]} (1 of {count} scenes)"
    return f"On average over {f'{len(names)} of ' if len(names) < count else ''}{count} scenes (geometric mean)"


def compared(label: str, ratio: Interval, baseline: str) -> str:
    """Return a clause such as ``best is about 31 times faster than naive (27 to 35)``.

    ``label`` and ``baseline`` are the labels of two strategies. ``ratio`` is the baseline's time divided by the
    strategy's.
    """
    if not ratio.trusted:
        faster = "as fast as" if ratio.low < 1.0 else "faster than"
        return f"{label} is at least {figure(ratio.low)} times {faster} {baseline}"
    if ratio.low <= 1.0 <= ratio.high:
        return f"{label} is about {about(ratio)} times as fast as {baseline} {span(ratio)}, no clear difference"
    return f"{label} is about {times(ratio, f'faster than {baseline}', f'slower than {baseline}')}"


def less_time(ratio: Interval) -> str:
    """Return a phrase such as ``about 31 times less time (27 to 35)``.

    ``ratio`` is the time that another strategy needs, divided by the strategy's time.
    """
    if ratio.low <= 1.0 <= ratio.high:
        inverse = ratio.map(lambda value: 1.0 / value)
        return f"{about(inverse)} times the time {span(inverse)}"
    return f"about {times(ratio, 'less time', 'more time')}"


def times(ratio: Interval, above: str, below: str) -> str:
    """Return a ratio with its interval in words, such as ``31 times faster (27 to 35)`` for ``above`` ``faster``.

    A ratio below 1 is inverted, and the word is ``below``.
    """
    found = ratio if ratio.value >= 1.0 else ratio.map(lambda value: 1.0 / value)
    return f"{about(found)} times {above if ratio.value >= 1.0 else below} {span(found)}"


def across(found: Sequence[tuple[str, Interval]], text: Callable[[Interval], object]) -> str:
    """Return the time of the only scene, or the shortest and the longest time of several, each with its scene.

    Times of unlike scenes have no mean that means anything: only ratios are averaged. ``found`` has names of scenes and
    times in seconds, and ``text`` words a time.
    """
    ordered = sorted(found, key=lambda one: one[1].value)
    if len(ordered) == 1:
        return str(text(ordered[0][1]))
    return " to ".join(f"{text(time)} on {name}" for name, time in (ordered[0], ordered[-1]))


def equal_samples(counts: Iterable[int | None]) -> str:
    """Return a sentence on the samples per pixel at which strategies are compared; empty if no count is known."""
    known = sorted({count for count in counts if count is not None})
    if not known:
        return ""
    told = f"{known[0]:,}" if len(known) == 1 else f"{known[0]:,} to {known[-1]:,}"
    return f"Equal samples: at {told} a pixel, the largest count that both have{' on a scene' * (len(known) > 1)}."


def joined(labels: Iterable[str]) -> str:
    """Return labels of strategies in one text, such as ``best or mis``; equal labels are named once."""
    return " or ".join(dict.fromkeys(labels))


def listed(texts: Sequence[str]) -> str:
    """Return texts as an enumeration: ``a, b and c``."""
    return " and ".join([", ".join(texts[:-1]), texts[-1]] if len(texts) > 1 else texts)
