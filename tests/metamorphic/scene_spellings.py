"""Other ways to write a number, and other blanks between words."""

from __future__ import annotations

from random import Random


def decimal(value: float, random: Random) -> str:
    """Write a number that has few decimal places."""
    plain = repr(float(value))
    mantissa, exponent = f"{value:.17e}".split("e")
    short = mantissa.rstrip("0")
    ways = [
        plain,
        f"{short}0e{exponent}",
        f"{value:.12f}",
        plain + "0" if "e" not in plain else plain,
        f"{short}0E{int(exponent):+d}",
    ]
    return random.choice([way for way in ways if float(way) == value])


def blanks(random: Random, ends: str = "\n", least: int = 0) -> str:
    """Return blanks, tabs and ends of lines."""
    count = random.choice([least, least, least + 1, least + 3])
    return "".join(random.choice([" ", " ", "\t", ends]) for _ in range(count))
