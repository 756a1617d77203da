"""Effects: what a scene calls for, what each costs, and rendering without it.

=========  ===========================================================================================================
`kinds`    the effects by name: what calls for each, and what stands for it where it is left out
`derive`   scene → effects, with the reason for each
`leaving`  the scene without some of them
`pairs`    a scene against itself without an effect, in turn, with the same random numbers
`parts`    which part of the light makes the noise
`extras`   what outputs beside the image take
`prices`   the price list, of all these
=========  ===========================================================================================================
"""

from __future__ import annotations

from equaltime.pricing.prices import Price, PriceList, effects
from equaltime.scene.effects.derive import Reason, derive
from equaltime.scene.effects.leaving import leave_out

__all__ = ["Price", "PriceList", "Reason", "derive", "effects", "leave_out"]
