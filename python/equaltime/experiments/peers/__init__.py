"""Peers, other renderers that take part in an experiment: Mitsuba 3, and any command that writes an image."""

from __future__ import annotations

from pathlib import Path

from equaltime.experiments.model.experiment import Peer
from equaltime.experiments.peers.command import CommandPeer
from equaltime.experiments.peers.common import with_box_filter
from equaltime.experiments.peers.mitsuba import MitsubaPeer
from equaltime.experiments.peers.process import time_limit

__all__ = ["CommandPeer", "MitsubaPeer", "peer_subject", "with_box_filter"]


def peer_subject(
    label: str, peer: Peer, folder: Path = Path(), budget: float | None = None, reference: float = 0.0
) -> MitsubaPeer | CommandPeer:
    """Return the renderer that an experiment's ``peer`` entry describes; a command runs in ``folder``.

    If the entry has no time limit, `time_limit` computes the limit. It uses the ``budget`` of a run and the longest
    time of a ``reference``, both in seconds. Raises PeerError for an invalid command.
    """
    limit = time_limit(budget, reference) if peer.limit is None else peer.limit
    if peer.command is not None:
        return CommandPeer(label, peer.command, folder, limit)
    default = MitsubaPeer(label)
    return MitsubaPeer(
        label,
        variant=peer.variant or default.variant,
        integrator=peer.integrator or default.integrator,
        sampler=peer.sampler or default.sampler,
        limit=limit,
    )
