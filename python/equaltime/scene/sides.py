"""Splits the BSDF of a surface into a BSDF for the front and a BSDF for the back, without ``twosided``."""

from __future__ import annotations

from equaltime.scene.model import BlendBsdf, Bsdf, BumpMap, Diffuse, Mask, NormalMap, TwoSided

__all__ = ["sides", "turns"]

BLACK = Diffuse(reflectance=(0.0, 0.0, 0.0))


def sides(bsdf: Bsdf) -> tuple[Bsdf | None, Bsdf | None]:
    """Return the BSDF of the front and the BSDF of the back, without ``twosided``.

    None stands for a side that absorbs all light. A transmitting BSDF is returned for both sides, because it
    distinguishes the sides itself. If a mask or a map wraps a BSDF, it wraps the BSDF of each side in the result. A
    hole in the front is therefore a hole in the back, even if the rest of the back absorbs light.
    """
    if isinstance(bsdf, TwoSided):
        return sides(bsdf.bsdf[0])[0], sides(bsdf.bsdf[-1])[0]
    if isinstance(bsdf, Mask):
        front, back = sides(bsdf.bsdf)
        return _around(bsdf, front or BLACK), _around(bsdf, back or BLACK)
    if isinstance(bsdf, BumpMap | NormalMap):
        front, back = sides(bsdf.bsdf)
        return front and _around(bsdf, front), back and _around(bsdf, back)
    if isinstance(bsdf, BlendBsdf):
        (front, back), (other_front, other_back) = map(sides, bsdf.bsdf)
        return _blend(bsdf, front, other_front), _blend(bsdf, back, other_back)
    if isinstance(bsdf, Diffuse) and bsdf.reflectance == BLACK.reflectance:
        return None, None
    return bsdf, bsdf if bsdf.transmits else None


def turns(bsdf: Bsdf) -> bool:
    """Tell whether the bent normal on the back of a surface is the negative of the bent normal on the front.

    Return True if `bsdf` has a bump or normal map that no ``twosided`` wraps. Return False if ``twosided`` wraps the
    map: the back then shows a mirror image of the front. Return False too without a map.
    """
    if isinstance(bsdf, BlendBsdf):
        return any(map(turns, bsdf.bsdf))
    return isinstance(bsdf, BumpMap | NormalMap) or (isinstance(bsdf, Mask) and turns(bsdf.bsdf))


def _around(wrapper: Mask | BumpMap | NormalMap, inner: Bsdf) -> Bsdf:
    return wrapper if inner is wrapper.bsdf else wrapper.replace(bsdf=inner)


def _blend(blend: BlendBsdf, first: Bsdf | None, second: Bsdf | None) -> Bsdf | None:
    if first is None and second is None:
        return None
    both = (first or BLACK, second or BLACK)
    return blend if both == blend.bsdf else blend.replace(bsdf=both)
