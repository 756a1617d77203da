"""Costs of the effects (such as lens, media or textures) that a scene uses, and rendering without some effects.

=================================  ===================================================================================
`equaltime.scene.effects.kinds`    the effects by name: objects that use each, and its replacement if it is left out;
                                   ``derive`` finds the effects that a scene uses, with reasons
`equaltime.scene.effects.leaving`  the scene without some of them
`equaltime.quoting.pairs`          a scene against itself without an effect, in turn, with the same random numbers
`equaltime.quoting.left_out`       effects that a render leaves out, and the resulting bias
`equaltime.quoting.light_parts`    which part of the light makes the noise
`output_costs`                     the time of outputs beside the image
`prices`                           the price list, of all these
=================================  ===================================================================================
"""

from __future__ import annotations

from equaltime.pricing.prices import Price, PriceList, effects
from equaltime.scene.effects.kinds import Reason, derive
from equaltime.scene.effects.leaving import leave_out

__all__ = ["Price", "PriceList", "Reason", "derive", "effects", "leave_out"]
