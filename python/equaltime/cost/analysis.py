"""From records to what they say: `summarise` reads rows and the images they name, and nothing else."""

from __future__ import annotations

from equaltime.cost.summary import Curve, SceneResult, StrategyResult, Summary

__all__ = ["Curve", "SceneResult", "StrategyResult", "Summary"]
