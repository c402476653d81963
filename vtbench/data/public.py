"""Public recordings: where they come from, and where they are on this machine."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path

from vtbench.data.manifest import read_manifest
from vtbench.paths import cache_dir
from vtbench.registry import Registry


@dataclass(frozen=True)
class PublicSet:
    """A set of recordings that is fetched from its public source, pinned and checked.

    Attributes:
        name: its id, and the name of its folder.
        title: what it is, in one line.
        licence: SPDX id.
        citation: whom to cite.
        homepage: page of the source.
        base_url: address under which each file of the manifest lies, at the pinned version.
        megabytes: size of the download.
        manifest: file of `<sha256>  <path>` lines.
        unpack: for a set that is kept in another form than it is published: turns the folder of the downloaded files
            into a new folder, the set.
    """

    name: str
    title: str
    licence: str
    citation: str
    homepage: str
    base_url: str
    megabytes: int
    manifest: Path
    unpack: Callable[[Path, Path], None] | None = None

    @cached_property
    def files(self) -> dict[str, str]:
        """Relative path -> SHA-256 of every file."""
        return read_manifest(self.manifest)


MANIFESTS = Path(__file__).resolve().parent / "manifests"

# A new set is one module with a `SOURCE: PublicSet` and a loader, registered here.
PUBLIC: Registry[str] = Registry("public recordings")
PUBLIC.register("fabricslide16")("vtbench.data.fabricslide16")
PUBLIC.register("biotacsp_stability_v2")("vtbench.data.biotacsp_stability_v2")
PUBLIC.register("gelsight_ball_presses")("vtbench.data.gelsight_ball_presses")


def public_set(name: str) -> PublicSet:
    """The set with this name; ValueError with the closest ones when there is none."""
    source = import_module(PUBLIC.get(name)).SOURCE
    assert isinstance(source, PublicSet)
    return source


def cached_root(name: str) -> Path:
    """Folder in the cache where `vtbench fetch` puts the set."""
    return cache_dir() / "recordings" / name


def data_root(name: str) -> Path:
    """Folder of the set `name`: `$VTBENCH_DATA/<name>`, else what `vtbench fetch` brought.

    Raises:
        ValueError: unknown name, or in neither place; the message names the command that brings it.
    """
    source = public_set(name)
    places = [cached_root(name)]
    if chosen := os.environ.get("VTBENCH_DATA"):
        places.insert(0, Path(chosen).expanduser() / name)
    for place in places:
        if place.is_dir():
            return place
    raise ValueError(
        f"recordings {name} are not on this machine (looked in {', '.join(map(str, places))}): "
        f"`vtbench fetch {name}` brings them ({source.megabytes} MB, {source.licence}), or set VTBENCH_DATA to "
        f"the folder that holds {name}/"
    )
