"""Splits ``twosided`` into the BSDFs of the front and the back, each seen from its own side."""

from __future__ import annotations

from equaltime.scene.model import BlendBsdf, Bsdf, BumpMap, Diffuse, Mask, NormalMap, TwoSided

__all__ = ["sides", "turns"]

BLACK = Diffuse(reflectance=(0.0, 0.0, 0.0))


def sides(bsdf: Bsdf) -> tuple[Bsdf | None, Bsdf | None]:
    """Return the BSDFs of the front and the back, without ``twosided``; None for a side that absorbs all light.

    A transmitting BSDF is returned for both sides, since it distinguishes the sides itself. A wrapper is put around
    each side of the BSDF that it wraps. A hole is therefore a hole on both sides, even where the rest of the back
    absorbs light.
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
    """Tell whether a bent normal on the back of `bsdf` is the negative of the front's bent normal.

    If False, ``twosided`` wraps the map that bends the normal: the back then shows a mirror image of the front.
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
