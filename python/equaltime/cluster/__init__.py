"""Renders on several machines, to the bits of one: units of the film go to other processes (README.md).

`open_cluster` finds the processes, and `render_unit` is what each of them runs. `open_machines` finds the machines that
can take whole runs of an experiment.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from equaltime.cluster.pool import Pool
from equaltime.cluster.team import CONNECT_SECONDS
from equaltime.cluster.units import render_unit
from equaltime.extras import optional
from equaltime.rendering.team import Cluster

if TYPE_CHECKING:
    from equaltime.cluster.machines import Machines

__all__ = ["CONNECT_SECONDS", "check_address", "check_machines", "open_cluster", "open_machines", "render_unit"]

_LOCAL = re.compile(r"local:([1-9]\d{0,3})")
_ADDRESS = re.compile(r"[a-z][a-z+]*://\S+|[\w.-]+:\d+")


@contextmanager
def open_cluster(where: Any, output: str | os.PathLike[str] | None = None) -> Iterator[Cluster | None]:
    """Yield the cluster at the place ``where``, as a context for renders.

    At the end of the block, processes that were started for it end, and a connection to a scheduler is closed.

    Parameters
    ----------
    where
        ``local:N`` for N processes on this machine, the address of a scheduler of Dask such as ``tcp://node1:8786``, a
        ``distributed.Client``, a cluster of Dask such as ``SLURMCluster``, or a ``concurrent.futures.Executor`` whose
        processes have equaltime. A cluster that `open_cluster` yielded is yielded again. It stays open, as do clients,
        clusters of Dask and executors. None stands for no cluster, and yields None.
    output
        OUT.exr of the render. Finished units (windows of the film with some samples) are kept in the folder
        OUT.exr.units until OUT.exr contains their samples.

    Raises
    ------
    ValueError
        If ``where`` is of another kind.
    EqualtimeError
        If Dask is needed and not installed.
    RenderError
        If no scheduler answers.

    Examples
    --------
    >>> with et.open_cluster(None) as cluster:  # "local:4" for four processes here
    ...     et.render("scene.toml", spp=4, cluster=cluster).spp
    4.0
    """
    keep = None if output is None else Path(output).with_name(f"{Path(output).name}.units")
    if where is None or hasattr(where, "team"):
        yield where
        return
    if isinstance(where, Executor):
        yield Pool(where, keep=keep)
        return
    if isinstance(where, str):
        check_address(where)
    optional("distributed", "cluster")
    from equaltime.cluster.dask_cluster import DaskCluster  # here, as not everyone has Dask

    with DaskCluster.of(where, keep) as made:
        yield made


def check_address(where: str) -> str:
    """Return ``where``; raise ValueError if it is neither ``local:N`` nor looks like an address."""
    if (_LOCAL if where.startswith("local:") else _ADDRESS).fullmatch(where):
        return where
    raise ValueError(f"a cluster is local:N, for N processes, or an address such as tcp://node1:8786; found {where}")


@contextmanager
def open_machines(where: Any) -> Iterator[Machines | None]:
    """Yield the machines of a cluster, which can take runs whose times are compared; None if ``where`` is None.

    Parameters
    ----------
    where
        Place of the cluster, as for `open_cluster`, if `check_machines` accepts it.

    Raises
    ------
    ValueError
        If ``where`` is not the place of a cluster, or if `check_machines` refuses it.
    EqualtimeError
        If Dask is not installed.
    RenderError
        If no scheduler answers, or no worker is like this process.
    """
    with open_cluster(check_machines(where)) as cluster:
        if cluster is None:
            yield None
            return
        from equaltime.cluster.dask_cluster import DaskCluster  # here, as not everyone has Dask

        assert isinstance(cluster, DaskCluster), "check_machines refuses others"
        machines = cluster.machines()
        try:
            yield machines
        finally:
            machines.clear()


def check_machines(where: Any) -> Any:
    """Return ``where``, the place of a cluster; raise ValueError if times of runs there cannot be compared.

    Several processes on this machine are refused, because they would disturb each other's times. So are executors,
    because they do not tell on which machines their processes run. Raises EqualtimeError with the line that installs
    Dask if it is missing.
    """
    if isinstance(where, str):
        if check_address(where).startswith("local:") and where != "local:1":
            raise ValueError(
                f"{where}: processes of one machine would disturb each other's times; use local:1, or the address of a "
                "scheduler with workers on several machines"
            )
        optional("distributed", "cluster")
    elif isinstance(where, Executor) or (hasattr(where, "team") and not hasattr(where, "machines")):
        raise ValueError(
            "an Executor does not tell on which machines its processes are; use the address or a Client of Dask's "
            "scheduler"
        )
    return where
