"""The rungs of the ladder by name."""

from __future__ import annotations

import numpy as np

from sensors.contact.ladder.flat import LayerRung, WinklerRung
from sensors.contact.ladder.interface import Rung
from sensors.contact.ladder.reduced import NeoHookeanReducedRung
from sensors.contact.ladder.solid import NeoHookeanRung

RUNGS: dict[str, Rung] = {
    rung.name: rung
    for rung in (
        WinklerRung("winkler", 64),
        LayerRung("layer-64", 64, np.float32),
        LayerRung("layer-128", 128, np.float32),
        LayerRung("layer-fine", 256, np.float64),
        NeoHookeanReducedRung("neohookean-reduced", 16, 7),
        NeoHookeanRung("neohookean", 16, 7),
    )
}
"""Every rung, from the simplest model to the fullest; the numbers are cells of a side (see each class)."""


def get_rung(name: str) -> Rung:
    """The rung of that name; ValueError lists the known ones."""
    if name not in RUNGS:
        raise ValueError(f"unknown contact rung {name!r}; known: {', '.join(RUNGS)}")
    return RUNGS[name]
