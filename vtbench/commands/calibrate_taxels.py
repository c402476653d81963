"""`vtbench calibrate-taxels`: the static experiments of the taxel array, as a table and pictures."""

from __future__ import annotations

from argparse import Namespace, _SubParsersAction
from typing import Any

from vtbench.commands.output import print_json, print_table
from vtbench.commands.parser import Parser, add_command, add_json, add_out, one_of, whole_number

PRESETS = ("fvsight", "velostat")


def add(commands: _SubParsersAction[Parser]) -> None:
    """Declare the command."""
    parser = add_command(
        commands,
        "calibrate-taxels",
        run,
        help="repeat the calibration experiments of the taxel array and draw them",
        about="Loads a taxel from 0 to 50 N and back at 1 N/s, puts 20, 50, 100 and 200 g on each of the 16 taxels, "
        "presses and\nreleases the velostat sheet, and scans the array in four ways. Prints linearity, hysteresis, "
        "accuracy, resolution,\nspread, the sheet's transients beside those of public recordings, and the ghosts of "
        "each scan.",
        examples=(
            "vtbench calibrate-taxels -o out/calibration",
            "vtbench calibrate-taxels --preset velostat -o out/velostat --json",
        ),
    )
    parser.add_argument(
        "--preset", metavar="P", type=one_of("preset", PRESETS), default="fvsight",
        help="taxels: fvsight (default) or velostat",
    )  # fmt: skip
    parser.add_argument("--unit", metavar="U", type=whole_number(0), default=0, help="sensor unit (default 0)")
    parser.add_argument("--seed", metavar="S", type=whole_number(0), default=0, help="seed of noise and placings")
    add_out(parser, "DIR", "folder for the pictures")
    add_json(parser)


def run(args: Namespace) -> int:
    """Measure, draw, print."""
    import numpy as np

    from sensors import calibration, calibration_figures
    from sensors.electronics.piezoresistive import PRESETS as CHAINS
    from sensors.fvsight import FVSightParameters, FVSightUnit
    from vtbench.data.files import make_folder, write_whole

    chain, sheet = CHAINS[args.preset], CHAINS["velostat"]
    make_folder(args.out)
    gain = FVSightUnit(FVSightParameters(grid=16), args.unit).taxel_gain
    loop_rng, weight_rng, noise_rng, sheet_rng, scan_rng = np.random.default_rng([args.seed, args.unit]).spawn(5)
    loop = calibration.loading_loop(chain, loop_rng)
    readings = calibration.weigh(chain, gain, weight_rng)
    table = calibration.static_table(chain, loop, readings, noise_rng)
    measured = calibration.transient_measures(sheet, sheet_rng)
    scans = calibration.scan_errors(chain, scan_rng)
    pictures = {
        "loading-loop.png": lambda png: calibration_figures.draw_loop(loop, args.preset, png),
        "weights.png": lambda png: calibration_figures.draw_weights(readings, args.preset, png),
        "velostat.png": lambda png: calibration_figures.draw_transients(sheet, measured, png),
        "scanning.png": lambda png: calibration_figures.draw_ghosts(chain, scans, png),
    }
    for name, draw in pictures.items():
        write_whole(args.out / name, draw)
    transients = [
        {"velostat sheet": name, "ours": value, "from": low, "to": high, "inside": low <= value <= high}
        for (name, value), (low, high) in zip(measured.items(), calibration.VELOSTAT_RANGES.values(), strict=True)
    ]
    paths = [args.out / name for name in pictures]
    if args.json:
        weights = {
            "grams": calibration.WEIGHTS_G,
            "mean_n": readings.mean(axis=2),
            "std_n": readings.std(axis=2, ddof=1),
        }
        print_json(
            {"preset": args.preset, "unit": args.unit, "seed": args.seed, "static": table, "weights": weights,
             "velostat": transients, "scans": scans, "pictures": paths}
        )  # fmt: skip
        return 0
    _print([{**row, "value": f"{row['value']:.3g}"} for row in table])
    _print([{**row, "ours": f"{row['ours']:.3g}", "inside": "yes" if row["inside"] else "NO"} for row in transients])
    _print([{"scan": row["scan"], "RMS N": f"{row['rms_n']:.2g}", "worst N": f"{row['worst_n']:.2g}"} for row in scans])
    print(*paths, sep="\n")
    return 0


def _print(rows: list[dict[str, Any]]) -> None:
    print_table([name.replace("_", " ") for name in rows[0]], [list(row.values()) for row in rows])
    print()
