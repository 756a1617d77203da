"""Peers are compared with equaltime before they are timed: one that means another image gets a reference of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from equaltime.cost import reference as references
from equaltime.cost.experiment import ReferenceWish
from equaltime.cost.folder import Folder
from equaltime.cost.subject import Subject
from equaltime.scene import Scene

__all__ = ["pass_gate"]


def pass_gate(
    peer: Subject,
    name: str,
    scene: Scene,
    wish: ReferenceWish,
    folder: Folder,
    threads: int,
    gates: int,
    report: Callable[[float], object] | None = None,
) -> None:
    """Compare a peer with equaltime on a scene, once, and leave its own reference in the folder if they differ.

    What came of it is in the provenance, under ``agreements``, scene and label.

    Parameters
    ----------
    name
        Of the scene.
    gates
        How many of these comparisons the experiment has: they share one false-alarm rate.
    """
    from equaltime.cost.agreement import LEVEL, share
    from equaltime.cost.peers import agreement

    known: Mapping[str, Any] = folder.read_provenance().get("agreements", {}).get(name, {})
    if peer.label in known:
        return
    gate = agreement.check(peer, scene, threads, share(LEVEL, gates), progress=report)
    if not gate.agrees:
        own = agreement.own_reference(peer, scene, wish.error, wish.seconds, threads)
        references.write(folder.reference(name, peer.label), own)
    facts = {"agrees": gate.agrees, "p": gate.agreement.p, "level": gate.level, "seeds": gate.seeds, "note": gate.note}
    folder.note("agreements", name, {**known, peer.label: {**facts, "size": list(gate.size)}})
