"""Every rung behind one interface: open it for a pad, then press surfaces along warm-started paths."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sensors.contact.grid import Grid
from sensors.contact.layer import LayerMaterial
from sensors.contact.neohookean.surface import Surface

Floats = NDArray[np.floating]


@dataclass(frozen=True)
class Pad:
    """A square pad of `side_m`, bonded to a rigid base."""

    material: LayerMaterial
    side_m: float

    def __post_init__(self) -> None:
        if not 0 < self.side_m < np.inf:
            raise ValueError(f"a pad needs a finite positive side_m, got {self.side_m}")

    @property
    def side_ratio(self) -> float:
        """Side over thickness."""
        return self.side_m / self.material.thickness_m


@dataclass(frozen=True)
class Response:
    """A press on `grid`: `displacement` (n, n) of the top into the pad (m), `pressure` (n, n) in Pa, load, depth."""

    grid: Grid
    displacement: Floats
    pressure: Floats
    force_n: float
    indentation_m: float


class OpenRung(Protocol):
    """A rung with its operators for one pad."""

    def press_depths(self, surface: Surface, depths_m: Iterable[float]) -> Iterator[Response]:
        """Responses at the depths (m) in turn, each started from the one before.

        ValueError for a depth that is not finite or not less than the pad's thickness.
        """
        ...

    def press_loads(self, surface: Surface, loads_n: Iterable[float]) -> Iterator[Response]:
        """Responses under the loads (N) in turn, each started from the one before; refused as `press_depths` does."""
        ...


class Rung(Protocol):
    """A contact model on the ladder."""

    @property
    def name(self) -> str:
        """Its name in tables and scenes."""
        ...

    @property
    def replays(self) -> bool:
        """Whether it answers for the representative of its class on the pad's axis alone, and refuses the rest."""
        ...

    @property
    def fitted(self) -> bool:
        """Whether its stiffness is fitted to the representative of its class: its errors hold for that alone."""
        ...

    def open(self, pad: Pad, indenter_class: str) -> OpenRung:
        """Prepare for `pad`; `indenter_class` says what will press it."""
        ...
