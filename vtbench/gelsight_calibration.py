"""Make and score the GelSight's committed calibration: `python -m vtbench.gelsight_calibration fit|score|figure`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sensors.gelsight import CALIBRATION
from sensors.optics.gel import GelCalibration
from vtbench.data.gelsight_ball_presses import SOURCE, load_gelsight_ball_presses

COMMAND = "python -m vtbench.gelsight_calibration fit"


def make_calibration(out: Path, progress: bool = True) -> GelCalibration:
    """Choose the orders by leaving one fitted press out at a time, fit on all of them, write `out`."""
    from sensors.gelsight_fit import candidates, choose, fit

    data = load_gelsight_ball_presses()
    best, table = choose(data, [one for one in candidates() if one.surface == "layer"], progress)
    _, cap = choose(data, [one for one in candidates() if one.surface == "cap"], progress)
    made = {
        "command": COMMAND,
        "recordings": SOURCE.name,
        "recordings_sha256": dict(SOURCE.files),
        "left_out_press_by_press": [_short(row) for row in table + cap],
    }
    calibration = fit(data, best, made)
    calibration.save(out)
    return calibration


def _short(row: dict[str, Any]) -> dict[str, Any]:
    recipe = row.pop("recipe")
    return {**row, **{name: value for name, value in recipe.items() if name != "reach_px"}}


def score_table(calibration: GelCalibration) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Held-out presses one by one, and their means with intervals."""
    from sensors.gelsight_score import evaluate, summarise

    rows = evaluate(load_gelsight_ball_presses(), calibration)
    return rows, summarise(rows)


def print_scores(calibration: GelCalibration) -> None:
    """Both tables on standard output."""
    rows, summary = score_table(calibration)
    print("contact crop, presses left out of the fit     rendered              rest frame alone")
    print(f"{'press':>5}  {'L1':>6} {'SSIM':>7} {'PSNR dB':>8}    {'L1':>6} {'SSIM':>7} {'PSNR dB':>8}")
    for row in rows:
        ours = f"{row['l1']:6.2f} {row['ssim']:7.4f} {row['psnr_db']:8.2f}"
        alone = f"{row['rest_l1']:6.2f} {row['rest_ssim']:7.4f} {row['rest_psnr_db']:8.2f}"
        print(f"{row['press']:>5}  {ours}    {alone}")
    for row in summary:
        ours = f"{row['mean']:.4g} ({row['low']:.4g} .. {row['high']:.4g})"
        alone = f"{row['rest_mean']:.4g} ({row['rest_low']:.4g} .. {row['rest_high']:.4g})"
        print(f"{row['metric']:>8}: {ours}; rest frame alone {alone}; {row['interval']}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one of the three; 2 and one line on standard error for what is missing or wrong."""
    parser = argparse.ArgumentParser(prog="python -m vtbench.gelsight_calibration", description=__doc__)
    parser.add_argument("verb", choices=("fit", "score", "figure"))
    parser.add_argument("-o", "--out", type=Path, help="file to write (fit: default the committed calibration)")
    parser.add_argument("--calibration", type=Path, default=CALIBRATION, help="calibration to score or draw")
    args = parser.parse_args(arguments)
    if args.verb == "figure" and args.out is None:
        parser.error("figure needs -o FILE.png")
    try:
        if args.verb == "fit":
            make_calibration(args.out or CALIBRATION)
        elif args.verb == "score":
            print_scores(GelCalibration.load(args.calibration))
        else:
            from sensors.gelsight_figure import draw_held_out

            draw_held_out(load_gelsight_ball_presses(), GelCalibration.load(args.calibration), args.out)
    except (ValueError, OSError) as error:
        print(f"{parser.prog}: error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
