"""Checks for hazards of surfaces: triangles without area, coincident triangles, wrong orientation, gaps, rounding.

Vertices are coarsely rounded in shapes too far from the camera, and in meshes written too far from their own origin.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from equaltime.scene.geometry import SphereSurface
from equaltime.scene.lint.facts import UNCERTAIN, Finding, MeshFacts, border, facts, first_places, surrounds, within
from equaltime.scene.lint.parts import LintScene, Part
from equaltime.scene.model import MeshFile

__all__ = ["check_surfaces"]

MUCH = 1e-2
"""Fraction of a mesh's area in slivers above which the finding is a warning and not a note."""
STEPS: Final = 1000.0
"""Width of a shape below which its rounding is visible, in single-precision rounding steps of its vertices."""


def check_surfaces(world: LintScene) -> Iterator[Finding]:
    """Yield findings for the surfaces of the scene `world`.

    The findings report triangles without area, slivers, shading normals that face backwards, and coincident triangles.
    They also report shapes turned inside out, one-sided shapes around the camera, refracting shapes with gaps, and
    vertices that are too coarse for the size of their shape.
    """
    known = {part: facts(part) for part in world.meshes}
    yield from _degenerate(known)
    yield from _slivers(known)
    yield from _backwards(known)
    yield from _coincident(known)
    if not world.skipped:  # a skipped mesh may be inside another, or close it
        yield from _inverted(world, known)
        yield from _around_camera(world)
        yield from _open(world, known)
    yield from _coarse(world)


def _degenerate(known: dict[Part, MeshFacts]) -> Iterator[Finding]:
    found = {part: fact.degenerate for part, fact in known.items() if fact.degenerate}
    if not found:
        return
    gone = [part for part in found if known[part].degenerate == len(known[part].faces)]
    more = f"; shapes that have no other triangles: {len(gone)}" if gone else ""
    yield Finding(
        "degenerate-triangles",
        "warning" if gone else "note",
        f"triangles without area once their vertices are rounded: {sum(found.values()):,}{more}",
        first_places(part.name for part in gone or found),
        sum(found.values()),
        "leaves them out: no ray can meet them, and they are in no light's area",
        "ignore this unless a shape is missing; then write the vertices with more digits",
    )


def _slivers(known: dict[Part, MeshFacts]) -> Iterator[Finding]:
    found = {part: fact for part, fact in known.items() if fact.slivers}
    if not found:
        return
    count, worst = sum(fact.slivers for fact in found.values()), max(fact.tilt for fact in found.values())
    much = [part for part, fact in found.items() if fact.sliver_area > MUCH]
    share = max(fact.sliver_area for fact in found.values())
    yield Finding(
        "sliver-triangles",
        "warning" if much else "note",
        f"triangles so thin or small that rounding may tilt them by more than {UNCERTAIN:g} radians: {count:,}; "
        f"by up to {worst:.2g}, in up to {share:.2g} of a shape's area",
        first_places(part.name for part in much or found),
        count,
        "takes normals from the rounded vertices in double precision, starts rays clear of the error, and drops hits "
        "of the thinnest that rays pass by",
        "mesh the shape anew, or bring it nearer to the camera or to the size of the scene",
    )


def _backwards(known: dict[Part, MeshFacts]) -> Iterator[Finding]:
    found = {part: fact for part, fact in known.items() if fact.backwards}
    if not found:
        return
    count = sum(fact.backwards for fact in found.values())
    most = [part for part, fact in found.items() if 2 * fact.backwards > len(fact.faces)]
    yield Finding(
        "normals-against-faces",
        "warning" if most else "note",
        f"triangles whose three shading normals all point to the back side, as their vertex order has it: {count:,}"
        + (f"; shapes of which most triangles do so: {len(most)}" if most else ""),
        first_places(part.name for part in most or found),
        count,
        "renders such triangles black or nearly so, where both kinds of normals disagree",
        "face_normals = true shades them flat; or turn the faces round where the mesh was made",
    )


def _coincident(known: dict[Part, MeshFacts]) -> Iterator[Finding]:
    parts = [part for part in known if not part.grouped]
    if not parts:
        return
    hashes = np.concatenate([known[part].faces for part in parts])
    unique, counts = np.unique(hashes, return_counts=True)
    twice = unique[counts > 1]
    if not len(twice):
        return
    shared = {part: int(np.isin(known[part].faces, twice).sum()) for part in parts}
    owners = [part for part, count in shared.items() if count]
    unlike = {part.surface.sides.front for part in owners}, {part.surface.sides.radiance for part in owners}
    matters = any(part.refracts or part.surface.sides.radiance is not None for part in owners)
    serious = matters or any(len(kinds) > 1 for kinds in unlike)
    copies = int((counts[counts > 1] - 1).sum())
    kind = "of another material, or refracting, or emitting" if serious else "of the same material"
    yield Finding(
        "coincident-faces",
        "warning" if serious else "note",
        f"triangles that lie exactly on others, {kind}: {copies:,}",
        first_places(part.name for part in owners),
        copies,
        "a ray meets one of them, the same one in every render, and an emitter first; a ray that "
        "goes on may meet the other one next",
        "remove the copies, or move the layers apart",
    )


def _inverted(world: LintScene, known: dict[Part, MeshFacts]) -> Iterator[Finding]:
    """Find closed shapes whose front is inside while the camera is outside."""
    found = []
    for part in world.parts:
        if part.grouped or not (part.one_sided or part.refracts):
            continue
        if isinstance(part.surface, SphereSurface):
            turned = part.surface.flip_normals
            outside = float(np.linalg.norm(world.camera - part.surface.center)) > part.surface.radius
        elif part in known:
            turned = known[part].closed and known[part].volume < 0.0
            outside = turned and not surrounds(part, world.camera)
        else:
            continue
        if turned and outside and not _encloses(part, world):
            found.append(part)
    if found:
        yield Finding(
            "inverted-shapes",
            "warning",
            f"closed shapes with their front inside, while the camera is outside: {len(found)}",
            first_places(part.name for part in found),
            len(found),
            "renders them as the file says: from outside they are black, or glass turned inside out",
            "flip_normals = true, or twosided around the BSDF",
        )


def _around_camera(world: LintScene) -> Iterator[Finding]:
    """Find closed one-sided shapes around the camera whose front is outside."""
    found = [part for part in world.parts if part.one_sided and _faces_out(part) and within(world.camera, part)]
    if found:
        yield Finding(
            "camera-enclosed",
            "warning",
            f"closed one-sided shapes that the camera is inside of, with their front outside: {len(found)}",
            first_places(part.name for part in found),
            len(found),
            "renders the backs as the file says: they absorb everything",
            "move the camera out, turn the shape round with flip_normals = true, or put twosided around the BSDF",
        )


def _faces_out(part: Part) -> bool:
    if isinstance(part.surface, SphereSurface):
        return not part.surface.flip_normals
    return part.mesh is not None and facts(part).volume > 0.0


def _encloses(part: Part, world: LintScene) -> bool:
    """Tell whether other shapes are inside `part`, as in a room or a sky, where an inward front is intended."""
    low, high = part.bounds
    return any(
        other is not part and not other.grouped and ((low <= other.bounds) & (other.bounds <= high)).all()
        for other in world.parts
    )


def _open(world: LintScene, known: dict[Part, MeshFacts]) -> Iterator[Finding]:
    """Find refracting meshes with gaps, all taken together, because liquids in glasses close each other."""
    clear = [part for part in world.parts if part.refracts and not part.grouped]
    meshes = [part for part in clear if part in known]
    if not sum(known[part].balance for part in meshes) % (1 << 64):
        meshes = []
    gaps = dict(zip(meshes, border(meshes), strict=True)) if meshes else {}
    sheets = [part for part in clear if part not in known and not isinstance(part.surface, SphereSurface)]
    found = [*(part for part in meshes if gaps[part]), *sheets]
    if found:
        yield Finding(
            "open-dielectrics",
            "warning",
            f"refracting shapes with gaps: {len(found)}; edges with only one triangle: {sum(gaps.values()):,}",
            first_places(part.name for part in found),
            sum(gaps.values()) + len(sheets),
            "refracts at each surface by itself: light that passes the gap goes on as if it had never left, or entered",
            "close the mesh; for a single pane use thindielectric",
        )


def _coarse(world: LintScene) -> Iterator[Finding]:
    """Find shapes whose vertices are coarse.

    Vertices are coarse if rounding to single precision, in the core or in the mesh's file, leaves few distinct
    positions.
    """
    found = {part: steps for part in world.meshes if (steps := _steps(part)) < STEPS}
    if found:
        yield Finding(
            "coarse-shapes",
            "warning",
            f"shapes so small, for their distance from the camera, that rounding of their vertices shows: "
            f"{len(found)}; rounding steps across the coarsest: {min(found.values()):.3g}",
            first_places(part.name for part in sorted(found, key=found.__getitem__)),
            len(found),
            "rounds vertices to single precision around the camera: there it is finest, and coarse far away",
            "leave out what is too far to be seen, or move the camera nearer",
        )
    written = [part for part in world.parts if isinstance(part.shape, MeshFile) and _was_rounded(part, world)]
    if written:
        yield Finding(
            "coarse-files",
            "warning",
            f"meshes in single precision so far from their origin that rounding of vertices shows: {len(written)}",
            first_places(part.name for part in written),
            len(written),
            "uses the vertices as the file has them, without more digits",
            "write the mesh around its own middle, with to_world to move it, or in double precision",
        )


def _steps(part: Part) -> float:
    """Return the width of a shape in rounding steps of its vertices."""
    assert part.origin is not None
    farthest = float(np.abs(part.bounds - part.origin).max())
    return part.extent / float(np.spacing(np.float32(farthest))) if 0.0 < farthest < 3e38 else np.inf


def _was_rounded(part: Part, world: LintScene) -> bool:
    """Tell whether all vertices of the file are single-precision numbers, and coarse for the mesh's size."""
    assert isinstance(part.shape, MeshFile)
    vertices = world.scene.assets.mesh(part.shape).vertices
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    farthest = float(np.abs([low, high]).max())
    if not 0.0 < farthest < 3e38 or float((high - low).max()) / float(np.spacing(np.float32(farthest))) >= STEPS:
        return False
    return bool((vertices == vertices.astype(np.float32)).all())
