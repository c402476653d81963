"""The static experiments of a taxel array: a slow loading loop, standard weights, transients, ghosts of a scan.

Loop and weights repeat what the FVSight paper reports in words (0 to 50 N and back at 1 N/s; 20, 50, 100 and 200 g on
each of 16 taxels); transients are measured as in public recordings of Velostat.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensors.electronics.piezoresistive import PiezoresistiveChain
from sensors.electronics.scanning import Scanning

Array = NDArray[np.float64]

TAXELS = 16
TOP_N = 50.0
RATE_N_PER_S = 1.0
WEIGHTS_G = (20, 50, 100, 200)
GRAVITY = 9.81
PLACINGS = 5
"""How often each weight is put on each taxel; the paper does not say."""

VELOSTAT_RANGES: dict[str, tuple[float, float]] = {
    "exponent k of G ~ F^k": (0.78, 1.12),
    "fall of R in the first second of a hold (%)": (12.0, 25.0),
    "time constant of that fall (s)": (0.26, 0.46),
    "R / R0 at release": (1.2, 1.4),
    "R above R0 1 s after release (%)": (4.0, 13.0),
    "spread from press to press (%)": (10.0, 50.0),
}
"""What public recordings of bare Velostat sheets show; the last, "tens of percent", as an interval."""


@dataclass(frozen=True)
class Loop:
    """One taxel loaded to `TOP_N` and unloaded, (T,): time (s), load (N), voltage (V), read-back force (N)."""

    time_s: Array
    load_n: Array
    voltage_v: Array
    force_n: Array

    @property
    def branches(self) -> tuple[Array, Array, Array]:
        """Loads (n,) every 0.25 N and the mean read-back force around each, loading and unloading."""
        turn = int(self.load_n.argmax())
        centres = np.arange(0.25, TOP_N, 0.25)
        edges = np.append(centres - 0.125, centres[-1] + 0.125)
        both = []
        for part in (slice(0, turn), slice(turn, None)):
            place = np.digitize(self.load_n[part], edges) - 1
            inside = (place >= 0) & (place < len(centres))
            total = np.bincount(place[inside], self.force_n[part][inside], len(centres))
            both.append(total / np.bincount(place[inside], minlength=len(centres)))
        return centres, both[0], both[1]


def loading_loop(chain: PiezoresistiveChain, rng: np.random.Generator | None = None, gain: float = 1.0) -> Loop:
    """Load a taxel from 0 to `TOP_N` and back at `RATE_N_PER_S`, sampled at the chain's rate."""
    steps = round(TOP_N / RATE_N_PER_S * chain.rate_hz)
    up = np.arange(steps + 1) / steps * TOP_N
    load = np.concatenate((up, up[-2::-1]))
    voltage = chain.voltage(chain.respond(load[:, None]), gain)
    if rng is not None:
        voltage = voltage + rng.normal(0, chain.noise_v, voltage.shape)
    voltage = chain.convert(voltage)
    return Loop(np.arange(len(load)) / chain.rate_hz, load, voltage[:, 0], chain.calibrated_force(voltage)[:, 0])


def weigh(chain: PiezoresistiveChain, gain: Array, rng: np.random.Generator) -> Array:
    """Readings (weights, taxels, placings; N): each weight put `PLACINGS` times on each taxel, mean of its 2nd second.

    A placing loads one taxel alone for two seconds after a short touch-down; `gain` (taxels,) is each one's own.
    """
    touch_down = np.minimum(np.arange(round(2 * chain.rate_hz)) / (0.1 * chain.rate_hz), 1)
    readings = np.empty((len(WEIGHTS_G), len(gain), PLACINGS))
    for number, grams in enumerate(WEIGHTS_G):
        for taxel, own in enumerate(gain):
            # PLACINGS independent placings at once: columns of one read
            load = np.repeat(grams * 1e-3 * GRAVITY * touch_down[:, None], PLACINGS, axis=1)
            read = replace(chain, scanning="isolated").read(load, rng, own)
            readings[number, taxel] = read[len(read) // 2 :].mean(axis=0)
    return readings


def hold_and_release(chain: PiezoresistiveChain, force_n: float, hold_s: float, after_s: float) -> tuple[Array, Array]:
    """Time (T,; s; a sudden press at 0, release at `hold_s`) and resistance over rest R / R0 (T,), without noise."""
    before, held, after = (round(seconds * chain.rate_hz) for seconds in (0.2, hold_s, after_s))
    load = np.concatenate((np.zeros(before), np.full(held, force_n), np.zeros(after)))[:, None]
    conductance = chain.conductance(chain.respond(load))[:, 0]
    return (np.arange(len(load)) - before) / chain.rate_hz, conductance[0] / conductance


def transient_measures(chain: PiezoresistiveChain, rng: np.random.Generator, force_n: float = 5.0) -> dict[str, float]:
    """What `VELOSTAT_RANGES` names, measured on the chain at `force_n`."""
    from scipy.optimize import curve_fit

    time, ratio = hold_and_release(chain, force_n, 4.0, 1.5)
    second = round(chain.rate_hz)
    press, release = int(np.searchsorted(time, -1e-9)), int(np.searchsorted(time, 4.0 - 1e-9))
    first = ratio[press : press + second]
    start = (first[-1], first[0] - first[-1], 0.3)
    if np.ptp(first) > 1e-9:
        fitted, _ = curve_fit(
            lambda t, rest, drop, tau: rest + drop * np.exp(-t / tau), np.arange(second) / chain.rate_hz, first, start
        )
    else:
        fitted = np.array([first[0], 0.0, np.nan])
    loads = np.geomspace(2.0, TOP_N, 16)
    added = [1 / hold_and_release(chain, float(load), 1.0, 0.0)[1][-1] - 1 for load in loads]
    presses = chain.read(np.full((second, 400), force_n), rng)[second // 2 :].mean(axis=0)
    values = (
        float(np.polyfit(np.log(loads), np.log(added), 1)[0]),
        100 * float(1 - ratio[press + second] / ratio[press]),
        float(fitted[2]),
        float(ratio[release]),
        100 * float(ratio[release + second] - 1),
        100 * float(presses.std() / presses.mean()),
    )
    return dict(zip(VELOSTAT_RANGES, values, strict=True))


def ghosts(chain: PiezoresistiveChain, scanning: Scanning, correct: bool, load: Array) -> Array:
    """Read-back forces (T, taxels; N) of one scan of nominal taxels without noise and hysteresis."""
    quiet = replace(chain, scanning=scanning, correct_crosstalk=correct, hysteresis=None, creep=None)
    return quiet.read(load)


SCANS: tuple[tuple[str, Scanning, bool], ...] = (
    ("isolated", "isolated", False),
    ("rows grounded, corrected", "grounded_rows", True),
    ("rows grounded, as read", "grounded_rows", False),
    ("rows floating", "floating", False),
)


def scan_errors(chain: PiezoresistiveChain, rng: np.random.Generator, presses: int = 200) -> list[dict[str, Any]]:
    """Root-mean-square and largest error (N) of each scan over random presses of a third of the taxels, up to 10 N."""
    load = np.where(rng.random((presses, TAXELS)) < 1 / 3, rng.uniform(0, 10, (presses, TAXELS)), 0.0)
    rows = []
    for name, scanning, correct in SCANS:
        error = ghosts(chain, scanning, correct, load) - load
        rows.append({"scan": name, "rms_n": float(np.sqrt((error**2).mean())), "worst_n": float(np.abs(error).max())})
    return rows


def static_table(
    chain: PiezoresistiveChain, loop: Loop, readings: Array, rng: np.random.Generator
) -> list[dict[str, Any]]:
    """Linearity, hysteresis, accuracy, resolution and spread: rows of quantity, value, unit and how it is defined."""
    load, up, down = loop.branches
    line = np.polyval(np.polyfit(load, up, 1), load)
    true = np.array(WEIGHTS_G)[:, None] * 1e-3 * GRAVITY
    taxels = readings.mean(axis=2)
    rows: list[tuple[str, float, str, str]] = [
        ("linearity", 100 * float(np.abs(up - line).max()) / TOP_N, "% of 50 N", "loading branch to its best line"),
        ("hysteresis", 100 * float(np.abs(down - up).max()) / TOP_N, "% of 50 N", "largest gap between the branches"),
        ("accuracy", float(np.abs(np.concatenate((up, down)) - np.tile(load, 2)).max()), "N", "largest error, loop"),
    ]
    for at in (1.0, 5.0, 20.0, TOP_N):
        held = replace(chain, press_spread=0.0).read(np.full((4000, 1), at), rng)[2000:, 0]
        noise = float(np.diff(held).std() / np.sqrt(2))
        rows.append((f"resolution at {at:g} N", 3 * noise, "N", "3 standard deviations of one sample"))
    for grams, seen, exact in zip(WEIGHTS_G, taxels, true[:, 0], strict=True):
        spread = 100 * float(seen.std(ddof=1) / seen.mean())
        rows.append(
            (f"spread at {grams} g", spread, "% of the mean", f"16 taxels, mean {seen.mean():.3f} of {exact:.3f} N")
        )
    placing = 100 * float((readings.std(axis=2, ddof=1) / taxels).mean())
    rows.append(("repeatability", placing, "% of the mean", f"{PLACINGS} placings on the same taxel"))
    return [dict(zip(("quantity", "value", "unit", "defined_as"), row, strict=True)) for row in rows]
