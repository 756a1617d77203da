"""Lines on the vertices of a replayed path, with every factor of its radiance, and the legend above them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from equaltime.rendering.replay import Replay
from equaltime.strategy import Strategy

__all__ = ["PathInLines", "numbers"]

_FIRST, _LAST = 10, 5
"""Vertices that are shown of a long path without ``-v``."""
_EVERY_DIGIT: Final = 9
"""Significant digits that tell a float32 from all others."""
_DIGITS: Final = 5
"""Significant digits of numbers without ``-v``: enough to check a product by hand."""
_SAMPLED: Final = ("light", "mis")
"""Techniques that take a light sample at every vertex; others take one of point lights only."""
_NOT_AIMING: Final = ("uniform", "bsdf")
"""Techniques that find lights with a surface or a sky by scattered rays only."""
_SINGLE: Final = ("point", "spot", "directional")
"""Lights that reach a point from one direction only: their pdf is the probability of the pick."""
_DISCRETE: Final = ("conductor", "dielectric", "thindielectric")
"""BSDFs that scatter into discrete directions only."""


_FROM: Final = {"BSDF pdf": "from the BSDF", "uniform pdf": "uniformly"}
"""Densities of scattered rays by their names in the lines, and how such a ray is drawn."""
_WEIGHTS: Final = {
    "power": "light pdf² / (light pdf² + BSDF pdf²)",
    "balance": "light pdf / (light pdf + BSDF pdf)",
}
"""MIS weights of a picked light, by heuristic."""
_BY_THROUGHPUT: Final = (
    "the largest component of throughput · BSDF weight, at most 1; a split or a refraction counts as if it had not "
    "changed the throughput"
)
_SURVIVAL: Final = {
    "none": "1",
    "constant": "{survival:g}",
    "albedo": "the largest component of the albedo, at most 1",
}
"""Survival probability of the rules of roulette that do not take `_BY_THROUGHPUT`."""
_LONG_PATH: Final = 1024
"""Depth from which on the core ends paths without a limit at random, whatever the rule: ``kLongPathDepth``."""


def numbers(values: Iterable[float], digits: int = _EVERY_DIGIT) -> str:
    """Return numbers with this many significant digits, separated by blanks."""
    return " ".join(f"{value + 0.0:.{digits}g}" for value in values)  # -0 is 0


@dataclass(frozen=True)
class PathInLines:
    """A replayed path as lines of text: a few lines for each vertex, and a legend of what these lines hold."""

    path: Replay
    strategy: Strategy
    verbose: bool
    """Whether every vertex is shown, with every digit."""

    def legend(self) -> Iterator[str]:
        """Yield lines that explain the numbers of the vertices; numbers that do not occur have no line."""
        vertices = self.path.vertices
        drawn = f"{self._drawn}: of a direction drawn {_FROM[self._drawn]}"
        if any(self._takes_light(vertex) for vertex in vertices):
            yield "a picked light adds throughput · radiance · BSDF·cos · MIS weight · visible / light pdf"
            yield f"light pdf: of light sampling, with the probability of the pick; {drawn}; both per steradian"
            if (heuristic := self.strategy.heuristic) is not None:
                yield (
                    f"MIS weight ({heuristic} heuristic): {_WEIGHTS[heuristic]} of a picked light, and 1 minus that of "
                    "a light that a scattered ray meets"
                )
        elif any(vertex["scattering"] is not None for vertex in vertices):
            yield f"{drawn}, per steradian"
        if any(vertex["scattering"] is not None for vertex in vertices):
            yield "albedo: the share of the light that is scattered, for each colour"
        if any(vertex["scattering"] is not None and vertex["scattering"]["sampled"] for vertex in vertices):
            yield "BSDF weight: BSDF·cos / pdf of the direction that is drawn; it multiplies the throughput"
        if any(_plays_roulette(vertex["scattering"]) for vertex in vertices):
            yield (
                "Russian roulette: the path survives with the survival probability, and its throughput is then divided "
                "by that number, which keeps the mean right; else it ends"
            )
            yield f"survival probability: {self._survival()}"
        yield (
            "the camera's ray begins between camera and scene, where no surface is nearer to the camera; other rays "
            "begin just off the surface that they leave, clear of its rounding error"
        )
        if any(vertex["surface"] is not None for vertex in vertices):
            yield (
                "primitive: the number of the triangle in its shape, from 0 (a rectangle has two); u v: the texture "
                "coordinates"
            )
        if not self.verbose:
            yield f"numbers have {_DIGITS} digits here, and all of theirs with -v"

    def lines(self) -> Iterator[str]:
        """Yield the lines of all vertices; of a long path the first and the last alone, unless ``verbose``."""
        rays = Counter(vertex["from"] for vertex in self.path.vertices)
        count = len(self.path.vertices)
        hidden = range(0) if self.verbose or count <= _FIRST + _LAST + 1 else range(_FIRST, count - _LAST)
        for number, vertex in enumerate(self.path.vertices):
            if number in hidden:
                if number == hidden.start:
                    yield ""
                    yield f"... {len(hidden)} more (-v shows all)"
                continue
            yield ""
            whose = "the camera's ray, " if vertex["from"] is None else ""
            yield f"{number + 1}. {whose}from {self.all(vertex['origin'])} along {self.all(vertex['direction'])}"
            if vertex["from"] not in (None, number - 1):
                yield f"   another copy of the path, split off at vertex {vertex['from'] + 1}"
            yield f"   throughput {self.all(vertex['throughput'])}"
            yield from (f"   {line}" for line in self._vertex(vertex, rays[number]))
            if number < count - 1 and not rays[number]:
                yield "   this copy of the path ends here"

    def all(self, values: Iterable[float]) -> str:
        """Return numbers with the digits of this output, separated by blanks."""
        return numbers(values, _EVERY_DIGIT if self.verbose else _DIGITS)

    @property
    def _drawn(self) -> str:
        """Name of the density of scattered rays."""
        return "uniform pdf" if self.strategy.technique == "uniform" else "BSDF pdf"

    def _survival(self) -> str:
        """Return the formula of the survival probability in words."""
        rule = self.strategy.roulette
        said = _SURVIVAL.get(rule, _BY_THROUGHPUT).format(survival=self.strategy.survival)
        if len(self.path.vertices) < _LONG_PATH:
            return f"{said} (roulette={rule})"
        return f"{said} (roulette={rule}); from depth n = {_LONG_PATH} on times (n / (n + 1))² if paths have no limit"

    def _takes_light(self, vertex: Mapping[str, Any]) -> bool:
        light = vertex["light"]
        return light is not None and (light["sampled"] or self.strategy.technique in _SAMPLED)

    def _could_aim(self, scattering: Mapping[str, Any] | None) -> bool:
        """Tell whether the strategy aims at lights from a vertex with this scattering."""
        if scattering is None or self.strategy.technique not in _SAMPLED:
            return False
        return scattering["bsdf"] not in _DISCRETE and any(scattering["albedo"])

    def _vertex(self, vertex: Mapping[str, Any], rays: int) -> Iterator[str]:
        """Yield the lines of a vertex from which this number of rays go on; more than 1 if the path is split."""
        surface, emitter, scattering = (vertex[name] for name in ("surface", "emitter", "scattering"))
        if vertex["left"] != vertex["throughput"]:
            yield f"comes through a medium, which leaves {self.all(vertex['left'])}"
        if vertex["particle"] is not None:
            yield f"is scattered by it at {self.all(vertex['particle'])}"
        elif surface is None:
            yield "meets nothing"
        else:
            yield from self._surface(surface)
        if vertex["faults"]:
            yield f"raises a floating-point fault: {vertex['faults']}"
        if emitter is not None:
            weight = f"MIS weight {self._one(emitter['mis_weight'])} ({self._why_this_weight(vertex)})"
            yield f"sees {emitter['light']['name']}: radiance {self.all(emitter['radiance'])}, {weight}"
            yield f"  adds {self.all(emitter['gathered'])}"
        if self._takes_light(vertex):
            yield from self._light(vertex)
        elif surface is not None and vertex["light"] is None and self._could_aim(scattering):
            yield "picks no light: none can shine on this side"
        if scattering is not None:
            yield from self._scattering(scattering, goes_on=rays > 0)
        elif surface is not None and rays:
            yield "passes straight on"
        if rays > 1:
            yield f"splits into {rays} copies, which share the throughput"

    def _surface(self, surface: Mapping[str, Any]) -> Iterator[str]:
        side = "front" if surface["front"] else "back"
        uv = "" if surface["uv"] is None else f", u v {self.all(surface['uv'])}"
        yield f"meets the {side} of {surface['name']}, primitive {surface['primitive']}{uv}"
        normals = f"normal {self.all(surface['normal'])}"
        if surface["shading_normal"] != surface["normal"]:
            normals += f", shading normal {self.all(surface['shading_normal'])}"
        yield f"  at {self.all(surface['point'])}, {normals}; the next rays begin {surface['offset']:.3g} off it"

    def _why_this_weight(self, vertex: Mapping[str, Any]) -> str:
        """Return the density of light sampling for the ray to an emitter, or why no light sample can be this ray."""
        if self.strategy.technique in _NOT_AIMING:
            return "this strategy does not aim at this light"
        if vertex["emitter"]["mis_weight"] == 1.0:
            left = vertex["from"]
            while left is not None and self.path.vertices[left]["scattering"] is None:  # passed straight on there
                left = self.path.vertices[left]["from"]
            if left is None:
                return "the camera's ray: no light is aimed at from the camera"
            if self.path.vertices[left]["scattering"]["bsdf"] in _DISCRETE:
                return "the ray's direction is discrete: no light sample has it"
        return f"light pdf {self._one(vertex['emitter']['light_pdf'])}"

    def _light(self, vertex: Mapping[str, Any]) -> Iterator[str]:
        light = vertex["light"]
        yield f"picks {light['light']['name']} with probability {self._one(light['pmf'])}"
        if not light["sampled"]:
            yield "  which gives no direction from here, for example since it faces away: adds nothing"
            return
        away = "" if light["distance"] is None else f", {self._one(light['distance'])} away"
        single = light["light"]["kind"] in _SINGLE
        discrete = " (a discrete direction: the probability of the pick)" if single else ""
        yield f"  towards {self.all(light['direction'])}{away}, light pdf {self._one(light['pdf'])}{discrete}"
        yield f"  radiance {self.all(light['radiance'])}"
        if not any(light["bsdf"]):
            yield f"  BSDF 0, {_why_black(vertex)}: adds nothing"
            return
        blocked = "" if light["blocker"] is None else f", behind {light['blocker']['name']}"
        pdf, weight = self._one(light["bsdf_pdf"]), self._one(light["mis_weight"])
        alone = " (only aiming finds this light)" if single or self.strategy.technique == "light" else ""
        yield f"  BSDF·cos {self.all(light['bsdf'])}, BSDF pdf {pdf}, MIS weight {weight}{alone}"
        yield f"  visible {self._one(light['visible'])}{blocked}: adds {self.all(light['gathered'])}"

    def _scattering(self, scattering: Mapping[str, Any], *, goes_on: bool) -> Iterator[str]:
        yield f"scatters by {scattering['bsdf']}, albedo {self.all(scattering['albedo'])}"
        if not scattering["sampled"]:
            return
        pdf = "a discrete direction" if scattering["pdf"] is None else f"{self._drawn} {self._one(scattering['pdf'])}"
        yield f"  towards {self.all(scattering['direction'])}, {pdf}, BSDF weight {self.all(scattering['weight'])}"
        if _plays_roulette(scattering):
            outcome = "the path survives" if goes_on else "the path ends"
            yield f"  Russian roulette: survival probability {self._one(scattering['survival'])}, {outcome}"

    def _one(self, value: float) -> str:
        return self.all((value,))


def _plays_roulette(scattering: Mapping[str, Any] | None) -> bool:
    """Tell whether Russian roulette may end the path at a vertex with this scattering."""
    return scattering is not None and scattering["survival"] is not None and scattering["survival"] < 1.0


def _why_black(vertex: Mapping[str, Any]) -> str:
    """Return why the BSDF is 0 between the ray to a vertex and its light sample."""
    surface, scattering = vertex["surface"], vertex["scattering"]
    if surface is None:
        return "as the medium scatters nothing into this direction"
    if scattering is not None and scattering["bsdf"] in _DISCRETE:
        return "as it scatters into discrete directions only"
    if scattering is not None and not any(scattering["albedo"]):
        return "as the surface absorbs everything"
    if _is_across(surface["normal"], vertex):
        return "as the light is behind the surface"
    shading = surface["shading_normal"] if scattering is None else scattering["shading_normal"]
    if _is_across(shading, vertex):
        return "as the light is behind the surface by its shading normal"
    return "as the surface scatters nothing into this direction"


def _is_across(normal: Sequence[float], vertex: Mapping[str, Any]) -> bool:
    """Tell whether the plane of a normal parts the vertex's light from the side that the ray came from."""
    came, goes = (
        sum(a * b for a, b in zip(normal, direction, strict=True))
        for direction in (vertex["direction"], vertex["light"]["direction"])
    )
    return bool(came * goes >= 0.0)
