"""Baseline records that come with the package: a run's records and tallies in one small file, without predictions.

`python -m leaderboard.baselines RUN_DIR...` takes whole runs into `records/<run>.json`, tallies as `vtbench board`
leaves them in the run. What many records share, their place, is written once.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from leaderboard._files import write_atomic
from leaderboard.board import slug
from leaderboard.record import Record, scan_records
from leaderboard.tally import Tallies, Tally, plain, read_tallies

FOLDER = Path(__file__).parent / "records"
_TIMES = ("started", "finished")


def read_baselines(folder: Path = FOLDER) -> tuple[list[Record], dict[str, Tally]]:
    """Return the committed records and their tallies by key; ValueError naming a file that cannot be read."""
    records: list[Record] = []
    tallies: dict[str, Tally] = {}
    for path in sorted(folder.glob("*.json")):
        try:
            file = json.loads(path.read_bytes())
            for row in file["records"]:
                where = file["places"][row.pop("place")]
                times = {name: row.pop(name) for name in _TIMES}
                tally = row.pop("tally", None)
                records.append(Record.model_validate({**row, "provenance": {**where, **times}}))
                if tally is not None:
                    tallies[records[-1].key] = Tally.model_validate(tally)
        except (ValueError, KeyError, TypeError, IndexError) as error:
            raise ValueError(f"{path}: expected baseline records, got another file ({error})") from error
    return records, tallies


def write_baselines(path: Path, records: Iterable[Record], tallies: Tallies) -> None:
    """Write records, by their place in the board, and their tallies as one file, a record a line."""
    places: list[dict[str, Any]] = []
    rows = []
    for record in records:
        row = record.model_dump(mode="json", exclude_none=True)
        where = row.pop("provenance")
        row |= {name: where.pop(name) for name in _TIMES}
        if where not in places:
            places.append(where)
        row["place"] = places.index(where)
        if record.key in tallies:
            row["tally"] = plain(tallies[record.key])
        rows.append(json.dumps(row, ensure_ascii=False, separators=(",", ":"), allow_nan=False))
    head = json.dumps(places, ensure_ascii=False, separators=(",", ":"))
    lines = ",\n".join(rows)
    write_atomic(path, f'{{"places":{head},\n"records":[\n{lines}\n]}}\n'.encode())


def main(runs: list[str]) -> int:
    """Take the records of each run folder; returns an exit code."""
    if not runs or runs[0].startswith("-"):
        print("usage: python -m leaderboard.baselines RUN_DIR [RUN_DIR...]", file=sys.stderr)
        return 2
    for run in map(Path, runs):
        if not run.is_dir():
            print(f"{run}: expected the folder of a run, found none", file=sys.stderr)
            return 2
        records, problems = scan_records(run)
        if problems or not records:
            print(f"{run}: {problems[0] if problems else 'no records'}", file=sys.stderr)
            return 2
        tallies = read_tallies(run)
        path = FOLDER / f"{slug(run.resolve().name)}.json"
        write_baselines(path, records, tallies)
        print(f"{path}: {len(records)} records, {len(tallies)} with a tally, {path.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
