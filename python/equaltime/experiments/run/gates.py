"""Tests of peers (other renderers) before timing: a peer whose expected image differs gets its own reference."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from equaltime.experiments.model.experiment import ReferenceWish
from equaltime.experiments.run import reference as references
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.rendering.core_subject import Subject
from equaltime.scene import Scene

if TYPE_CHECKING:
    from equaltime.statistics.agreement import BlockMeans

__all__ = ["pass_gates"]


def pass_gates(
    peers: Sequence[Subject],
    name: str,
    scene: Scene,
    wish: ReferenceWish,
    folder: ExperimentFolder,
    threads: int,
    gates: int,
    report: Callable[[Subject, float], object] | None = None,
) -> None:
    """Test each peer once for the same expected image as equaltime's on a scene.

    For each peer that differs, a reference rendered by the peer is written to ``folder``. The outcomes go to the
    provenance file, under ``agreements``, scene and label. Peers with a recorded outcome are skipped.

    Parameters
    ----------
    name
        Name of the scene.
    gates
        Number of such tests on all scenes of the experiment; all tests share one false-alarm rate.
    """
    from equaltime.experiments.peers import agreement
    from equaltime.statistics.agreement import LEVEL, share

    known: Mapping[str, Any] = folder.read_provenance().get("agreements", {}).get(name, {})
    ours: dict[bool, BlockMeans] = {}
    for peer in peers:
        if peer.label in known:
            continue
        resizable = agreement.resizable(peer)
        told = None if report is None else partial(report, peer)
        gate = agreement.check(peer, scene, threads, share(LEVEL, gates), progress=told, ours=ours.get(resizable))
        ours[resizable] = gate.ours
        if not gate.agrees:
            own = agreement.own_reference(peer, scene, wish.error, wish.seconds, threads)
            references.write(folder.reference(name, peer.label), own)
        facts = {"agrees": gate.agrees, "p": gate.agreement.p, "level": gate.level, "seeds": gate.seeds}
        known = {**known, peer.label: {**facts, "note": gate.note, "size": list(gate.size)}}
        folder.note("agreements", name, known)
