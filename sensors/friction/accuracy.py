"""LuGre in prescribed motion against a tight reference: `python -m sensors.friction.accuracy [--json]`.

A start, a reversal and a turn in the plane at up to 20 mm/s under 2 N, for bristles from soft to stiff. Errors are the
largest over half a second, relative to the friction limit mu_s f_n. Explicit Euler stands beside for comparison: it is
unstable for dt > 2 g / (sigma0 |v|).
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from sensors.friction.lugre import Array, LuGre

STIFFNESSES = (1e3, 1e4, 1e5, 1e6)
RATES_HZ = (1000.0, 4000.0)
LOAD_N = 2.0
DURATION_S = 0.5


def nominal_law(stiffness: float) -> LuGre:
    """The law of the table at a bristle stiffness (N/m)."""
    return LuGre(stiffness, damping=0.3, viscosity=0.4)


def motion(time: Array) -> Array:
    """Velocity (..., 2; m/s) at times (...; s)."""
    return 0.02 * np.stack((np.sin(2 * np.pi * 2 * time), 0.5 * (1 - np.cos(2 * np.pi * 1.5 * time))), axis=-1)


def reference(law: LuGre, time: Array) -> Array:
    """Force (T, 2; N) by an adaptive solver at a tolerance of 1e-10."""
    from scipy.integrate import solve_ivp

    load = np.array([LOAD_N])

    def bristle_rate(t: float, z: Array) -> Array:
        v = motion(np.asarray(t))
        return v - law.rate(v[None], load)[0] * z

    solved = solve_ivp(bristle_rate, (0, time[-1]), np.zeros(2), "LSODA", time, rtol=1e-10, atol=1e-15, max_step=1e-3)
    return law.force(solved.y.T, motion(time), np.full(len(time), LOAD_N))


def stepped(law: LuGre, time: Array) -> Array:
    """Force (T, 2; N) by the project's step at the spacing of `time`."""
    _, force = law.follow(motion(time)[:, None], np.full((len(time), 1), LOAD_N), float(time[1] - time[0]))
    return force[:, 0]


def euler(law: LuGre, time: Array) -> Array:
    """Force (T, 2; N) by explicit Euler at the spacing of `time`; infinite from where it overflows."""
    dt, velocity = float(time[1] - time[0]), motion(time)
    rate = law.rate(velocity, np.full(len(time), LOAD_N))
    bristle, bristles = np.zeros(2), [np.zeros(2)]
    for v, a in zip(velocity[:-1], rate[:-1], strict=True):
        bristle = np.clip(bristle + dt * (v - a * bristle), -1e100, 1e100)
        bristles.append(bristle)
    return law.force(np.array(bristles), velocity, np.full(len(time), LOAD_N))


def table() -> list[dict[str, Any]]:
    """Rows of stiffness (N/m), rate_hz, and largest errors in % of mu_s f_n; Euler's is inf beyond 1e6 %."""
    rows = []
    for stiffness in STIFFNESSES:
        law = nominal_law(stiffness)
        for rate in RATES_HZ:
            time = np.arange(0, DURATION_S, 1 / rate)
            truth = reference(law, time)
            errors = [
                100 * float(np.abs(step(law, time) - truth).max()) / (law.static * LOAD_N) for step in (stepped, euler)
            ]
            rows.append(
                {
                    "stiffness_n_per_m": stiffness,
                    "rate_hz": rate,
                    "error_percent": errors[0],
                    "euler_percent": errors[1] if errors[1] < 1e6 else float("inf"),
                }
            )
    return rows


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m sensors.friction.accuracy", description=__doc__)
    parser.add_argument("--json", action="store_true", help="print the rows as JSON")
    args = parser.parse_args(arguments)
    rows = table()
    if args.json:
        finite = [{key: value if np.isfinite(value) else None for key, value in row.items()} for row in rows]
        json.dump(finite, sys.stdout, indent=2)
        print()
        return 0
    print(f"{'sigma0 N/m':>10}  {'rate Hz':>7}  {'error, % of mu_s f_n':>20}  {'explicit Euler, %':>17}")
    for row in rows:
        other = f"{row['euler_percent']:.3g}" if np.isfinite(row["euler_percent"]) else "diverges"
        print(f"{row['stiffness_n_per_m']:>10.0e}  {row['rate_hz']:>7.0f}  {row['error_percent']:>20.4f}  {other:>17}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
