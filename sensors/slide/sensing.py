"""From true taxel loads and a moving skin to what the trial records: read-back forces and frames."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from sensors.fvsight import FORCE_RATE_HZ, FVSightUnit, Session
from sensors.slide.membrane import InPlaneSkin, field_modes
from sensors.slide.partial_slip import Sheared
from sensors.slide.scene import Film
from sensors.slide.script import Script
from sensors.slide.track import Track

Array = NDArray[np.float64]

FRAME_RATE_HZ = 30.0
_PREAMBLE = 32
"""Samples of loading before the recording starts; the electronics do not depend on their rate."""


def late_film(load: Array, film: Film) -> Array:
    """Loads (t, 16) that reach the taxels: a share of every change arrives late; long at rest before the first."""
    keep = np.exp(-1 / (film.late_s * FORCE_RATE_HZ))
    late, _ = lfilter([1 - keep], [1, -keep], load, axis=0, zi=keep * load[:1])
    return np.asarray(load + film.late_share * (late - load))


def read_taxels(
    unit: FVSightUnit, session: Session, film: Film | None, taxels: Array, gain: Array | None, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Read-back forces (t, 16) for true loads (t, 16): late film, warming, electronics.

    The array was loaded to the first sample before the recording starts.
    """
    load = np.maximum(taxels, 0)
    if film is not None:
        load = late_film(load, film)
    if gain is not None:
        load = load * gain
    before = load[0] * (np.arange(_PREAMBLE) / _PREAMBLE)[:, None]
    return unit.read(np.concatenate((before, load)), session, rng)[_PREAMBLE:]


Weave = Callable[[int], NDArray[np.floating] | None]
"""What the drag at a sample does to the brightness of each pixel; None where nothing has moved."""


def patch_weave(unit: FVSightUnit, skin: InPlaneSkin, shift: Array) -> Weave:
    """The weave where a patch is dragged along by `shift` (t, 2; m)."""
    drawn = unit.camera.shift_shape(skin.modes * skin.stiffness)
    return lambda sample: unit.camera.dragged_weave(drawn, (float(shift[sample, 0]), float(shift[sample, 1])))


def sheared_weave(unit: FVSightUnit, sheared: Sheared, at: NDArray[np.intp]) -> Weave:
    """The weave where each point goes its own way; `at` (t,) are the samples in the sheared motion."""

    def weave(sample: int) -> NDArray[np.floating]:
        face = sheared.face_at(int(at[sample]))
        return unit.camera.sheared_weave(np.stack([unit.camera.shift_shape(field_modes(part)) for part in face]))

    return weave


def take_frames(
    unit: FVSightUnit, session: Session, track: Track, script: Script, weave: Weave, rng: np.random.Generator
) -> tuple[Array, NDArray[np.uint8]]:
    """Times (f,; s) and frames (f, h, w, 3): the deflected surface with its `weave` dragged along."""
    last_s = (len(script.load) - 1) / FORCE_RATE_HZ
    times = np.arange(int(np.floor(last_s * FRAME_RATE_HZ + 1e-9)) + 1) / FRAME_RATE_HZ
    pictures = []
    for time in times:
        sample = round(time * FORCE_RATE_HZ)
        modes = track.modes(float(script.travel[sample]), float(script.load[sample]))
        pictures.append(unit.frame(modes, session, rng, weave(sample)))
    return times, np.stack(pictures)
