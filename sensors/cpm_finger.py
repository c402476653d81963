"""CPM-Finger: 16 capacitive taxels on a crowned fingertip that slides over a gripped fabric, read in counts.

Modelled: a crowned fingertip on independent taxels (Winkler), so that the middle carries more; the relief of a plain
weave and of uneven cloth passing under each taxel, averaged over its area; a grip that is regulated to a total force
and hunts a little; LuGre friction of each taxel; the capacitive chain. Not modelled: bending, stretching and twisting
of the strip, tilt of the finger under drag, heat, the two proximity channels. Only taxel count, period, noise and the
size of fluctuations follow public recordings; geometry, stiffness and fabrics are assumptions, and no class of real
fabric is meant by a name here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from sensors.electronics.capacitive import CapacitiveChain
from sensors.friction.lugre import LuGre
from sensors.objects.textures import noise
from sensors.touch import Touch

Array = NDArray[np.float64]

TAXELS_PER_SIDE = 4
FORCE_UNIT = "counts"
_CONTACT_RATE_HZ = 1000.0
_UNIT_ENTROPY = 0x43504D


@dataclass(frozen=True)
class Fabric:
    """A plain weave: pitch of warp and weft and height of the relief, unevenness (mm), coefficients of friction."""

    warp_mm: float
    weft_mm: float
    relief_mm: float
    unevenness_mm: float
    grain_mm: float = 15.0
    static: float = 0.5
    dynamic: float = 0.4
    seed: int = 0

    def __post_init__(self) -> None:
        pitches, heights = (self.warp_mm, self.weft_mm, self.grain_mm), (self.relief_mm, self.unevenness_mm)
        if not (all(0 < pitch < np.inf for pitch in pitches) and all(0 <= height < np.inf for height in heights)):
            raise ValueError("a fabric needs pitches and grain > 0 mm, relief and unevenness >= 0 mm")

    def relief(self, x_mm: Array, y_mm: Array, side_mm: float) -> Array:
        """Height (mm) averaged over squares of `side_mm` centred on the points."""
        averaged = np.sinc(side_mm / self.warp_mm) * np.sinc(side_mm / self.weft_mm)
        weave = np.cos(2 * np.pi * x_mm / self.warp_mm) * np.cos(2 * np.pi * y_mm / self.weft_mm)
        return 0.5 * self.relief_mm * averaged * weave + self.unevenness_mm * noise(
            x_mm, y_mm, self.grain_mm, self.seed
        )


FABRICS = {
    "coarse": Fabric(1.30, 1.45, 0.35, 0.020, static=0.65, dynamic=0.55, seed=1),
    "ribbed": Fabric(4.80, 60.0, 0.25, 0.008, static=0.55, dynamic=0.45, seed=2),
    "fine": Fabric(0.45, 0.50, 0.12, 0.006, static=0.45, dynamic=0.38, seed=3),
}


class CPMFingerParameters(BaseModel):
    """What can be set on a finger; every length and force carries its unit in its name."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    pitch_mm: float = Field(4.0, gt=0)
    taxel_mm: float = Field(3.2, gt=0, description="side of the square that a taxel averages over")
    radius_across_mm: float = Field(60.0, gt=0, description="crown of the fingertip, across the slide")
    radius_along_mm: float = Field(150.0, gt=0)
    stiffness_n_per_mm: float = Field(1.0, gt=0, description="of the elastomer over one taxel")
    bristle_n_per_mm: float = Field(5.0, gt=0, description="tangential stiffness of one taxel's contact")
    grip_ripple: float = Field(0.02, ge=0, le=0.5, description="hunting of the gripper, relative force")
    grip_ripple_hz: float = Field(2.0, gt=0)
    gain_spread: float = Field(0.2, ge=0, description="between taxels of a unit, relative counts, log-normal")


@dataclass(frozen=True)
class FingerSlide:
    """One slide: `force_series` (M, 16) counts at `rate_hz`, and at 1 kHz what was true.

    taxel_load (T, 16; N) and shear (T, 16, 2; N; along and across the slide) of each taxel, grip (T,; N).
    """

    force_series: NDArray[np.float32]
    rate_hz: float
    taxel_load: Array
    shear: Array
    grip_n: Array

    @property
    def force_time_s(self) -> Array:
        """Clock of `force_series`, seconds, (M,)."""
        return np.arange(len(self.force_series)) / self.rate_hz


class CPMFinger:
    """One finger; `unit` picks the gains of its taxels. Taxels go row by row, rows across the slide (along x)."""

    def __init__(
        self, parameters: CPMFingerParameters | None = None, unit: int = 0, chain: CapacitiveChain | None = None
    ) -> None:
        self.parameters = p = parameters or CPMFingerParameters()
        self.chain = chain or CapacitiveChain()
        traits = np.random.default_rng([_UNIT_ENTROPY, unit])
        self.gain = np.exp(p.gain_spread * traits.standard_normal(TAXELS_PER_SIDE**2))
        axis = (np.arange(TAXELS_PER_SIDE) - (TAXELS_PER_SIDE - 1) / 2) * p.pitch_mm
        x, y = np.meshgrid(axis, axis, indexing="ij")
        self.x_mm, self.y_mm = x.ravel(), y.ravel()
        self.sag_mm = self.x_mm**2 / (2 * p.radius_along_mm) + self.y_mm**2 / (2 * p.radius_across_mm)

    def slide(
        self,
        fabric: Fabric,
        *,
        grip_n: float,
        speed_mm_s: float,
        duration_s: float,
        rng: np.random.Generator | None = None,
    ) -> FingerSlide:
        """Slide along x at a signed speed under a regulated grip, gripped long before; speed 0 is a hold.

        `rng` draws the place on the cloth, the phase of the grip's hunting and the noise; None is none of them.
        Raises ValueError unless grip and duration are > 0 and finite.
        """
        if not (0 < grip_n < np.inf and 0 < duration_s < np.inf and np.isfinite(speed_mm_s)):
            raise ValueError(
                "a slide needs grip_n > 0, duration_s > 0 and a finite speed_mm_s, got "
                f"{grip_n}, {duration_s}, {speed_mm_s}"
            )
        p = self.parameters
        place = np.zeros(3) if rng is None else rng.uniform(0, 1, 3) * (200.0, 200.0, 1.0)
        time = np.arange(max(1, round(duration_s * _CONTACT_RATE_HZ))) / _CONTACT_RATE_HZ
        ripple = 0.0 if rng is None else p.grip_ripple
        grip = grip_n * (1 + ripple * np.sin(2 * np.pi * (p.grip_ripple_hz * time + place[2])))
        travel = place[0] + speed_mm_s * time
        height = fabric.relief(travel[:, None] + self.x_mm, place[1] + self.y_mm, p.taxel_mm) - self.sag_mm
        load = share_load(height, grip / p.stiffness_n_per_mm) * p.stiffness_n_per_mm
        velocity = np.zeros((*load.shape, 2))
        # the arm starts to move after the first sample
        velocity[1:, :, 0] = speed_mm_s * 1e-3
        law = LuGre(p.bristle_n_per_mm * 1e3, static=fabric.static, dynamic=fabric.dynamic)
        _, shear = law.follow(velocity, load, 1 / _CONTACT_RATE_HZ)
        _, counts = self.chain.read(load, _CONTACT_RATE_HZ, rng, self.gain, settled=True)
        return FingerSlide(counts, self.chain.rate_hz, load, shear, grip)


def share_load(height: Array, total: Array) -> Array:
    """Squeezes (T, n) max(0, d + height) whose sum over n springs of unit stiffness is `total` (T,) > 0; exact.

    `height` (T, n) is how far the surface stands out over each spring; d is what a rigid finger sinks.
    """
    highest = -np.sort(-height, axis=1)
    carrying = np.arange(1, height.shape[1] + 1)
    sunk = (total[:, None] - np.cumsum(highest, axis=1)) / carrying
    # the springs that carry are the highest m with sunk + height > 0; that holds for every smaller m too
    last = (highest + sunk > 0).sum(axis=1) - 1
    return np.maximum(0, np.take_along_axis(sunk, last[:, None], axis=1) + height)


def sample_touch(load_n: float, rng: np.random.Generator) -> Touch:
    """A hold on a fabric, for the contract of sensors (a fingertip that meets cloth, no ball)."""
    held = CPMFinger().slide(FABRICS["coarse"], grip_n=load_n, speed_mm_s=0.0, duration_s=0.5, rng=rng)
    carried = float((held.taxel_load.sum(axis=1) / held.grip_n).mean() * load_n)
    return Touch(carried, held.force_series, held.rate_hz, FORCE_UNIT)
