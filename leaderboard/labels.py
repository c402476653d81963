"""What tells apart tables of one protocol that were scored on several datasets: the dataset's name, where it must."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

_LONGEST = 60
"""Characters of a dataset's name in a title."""


def labels(protocols: Sequence[Hashable], datasets: Sequence[str], hashes: Sequence[str]) -> list[str]:
    """Return for each table what to add to its title; the three are (tables,).

    Nothing where a protocol stands once, else the dataset, with the beginning of its hash where the name stands twice.
    """
    found = []
    for protocol, dataset, digest in zip(protocols, datasets, hashes, strict=True):
        rivals = [name for name, other in zip(datasets, protocols, strict=True) if other == protocol]
        named = f"dataset {dataset[:_LONGEST]}" + (f" {digest[:8]}" if rivals.count(dataset) > 1 else "")
        found.append(named if len(rivals) > 1 else "")
    return found


def beside(text: str, label: str) -> str:
    """Return a title with its label, where it has one."""
    return f"{text}, {label}" if label else text
