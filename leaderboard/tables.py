"""Long table of records -> the tables that people read: a row a method, its splits side by side, the paper beside."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import pandas as pd

from leaderboard.frame import OWN, Row, latest, records_of
from leaderboard.labels import labels
from leaderboard.names import METHODS, MODALITIES, ROLES, SPLITS, order
from leaderboard.paper import FIGURES, PaperFigure

BLOCK = ["task", "protocol_version", "variant", "kind", "dataset", "dataset_hash"]
RESULT = ("low", "high", "interval", "coverage", "probe", "rank_best", "rank_worst", "letters", "ranked", "n", "groups")
STATE = ("state", "reason", "key")
COST = ("predict_us", "predict_low_us", "feature_us", "fingerprint")
PAPER_SPLITS = ("random", "held-out-unit")


@dataclass(frozen=True, eq=False)
class ResultTable:
    """The methods of one task, variant and dataset: only what was measured on the same terms shares a table.

    `frame` has a row for each modality and method: role, modality, method; for each split `S` of `splits` the value
    `S` and `S_low`, `S_high`, `S_interval`, `S_n`, `S_groups`, `S_state`, `S_reason`, `S_key`; then predict_us,
    predict_low_us, feature_us and fingerprint of the first split that was timed. Where `paper_table` is set ("II",
    "III") it also has paper, paper_low, paper_high (percent) and paper_note.
    `S_rank_best`, `S_rank_worst` and `S_letters` say which ranks a score may hold among those of the table, `S_probe`
    and `S_coverage` what must be said of it. `apart` is "self-reported" or "flagged" where it holds such submissions.
    `superseded` counts records left out because a later one differs only in parameters, seed or machine. `label` names
    the dataset where another table is of the same protocol.
    """

    task: str
    protocol_version: int
    variant: str
    kind: str
    dataset: str
    dataset_hash: str
    metric: str
    unit: str
    splits: tuple[str, ...]
    frame: pd.DataFrame
    superseded: int = 0
    paper_table: str = ""
    press: str = ""
    apart: str = ""
    label: str = ""

    @property
    def fingerprints(self) -> tuple[str, ...]:
        """The machines that the speeds of this table were taken on."""
        return tuple(sorted(set(self.frame["fingerprint"].dropna())))


def task_tables(cells: pd.DataFrame) -> list[ResultTable]:
    """Return a table for each task, variant and dataset, in the board's order; methods and upper lines, no probes."""
    return _labelled([_result_table(list(block), rows, ()) for block, rows in _blocks(cells) if not _figures(block)])


def paper_tables(cells: pd.DataFrame) -> list[ResultTable]:
    """Return the paper's tables II and III with our two columns, once for each dataset that was scored.

    Every figure of the paper has its row, also where we have no record of it; methods that the paper lacks follow
    within their modality. The paper concatenates without weights: its fused figures stand beside both our fused rows.
    """
    return _labelled(
        [_result_table(list(block), rows, figures) for block, rows in _blocks(cells) if (figures := _figures(block))]
    )


def _labelled(tables: list[ResultTable]) -> list[ResultTable]:
    protocols = [(t.task, t.protocol_version, t.variant, t.kind, t.apart) for t in tables]
    named = labels(protocols, [t.dataset for t in tables], [t.dataset_hash for t in tables])
    return [replace(table, label=label) for table, label in zip(tables, named, strict=True)]


def _blocks(cells: pd.DataFrame) -> Iterable[tuple[tuple[Any, ...], pd.DataFrame]]:
    shown = cells[cells["role"].isin(["method", "upper-line"])]
    apart = shown["standing"].where(~shown["standing"].isin(OWN), "")
    for block, rows in shown.assign(apart=apart).groupby([*BLOCK, "apart"], sort=False):
        assert isinstance(block, tuple)
        yield block, rows


def _figures(block: Sequence[Any]) -> tuple[PaperFigure, ...]:
    task, _, variant, *_, apart = block
    return tuple(f for f in FIGURES if variant == "paper" and not apart and task.startswith(f.task + "/"))


def _result_table(block: list[Any], rows: pd.DataFrame, figures: tuple[PaperFigure, ...]) -> ResultTable:
    task, protocol_version, variant, kind, dataset, dataset_hash, apart = block
    kept = latest(rows)
    splits = tuple(sorted(set(kept["split"]), key=lambda name: order(SPLITS, name)))
    if figures:
        splits = tuple(dict.fromkeys((*PAPER_SPLITS, *splits)))
    lines: dict[tuple[str, str, str], Row] = {}
    for row in records_of(kept):
        line = lines.setdefault((row["role"], row["modality"], row["method"]), {})
        line[row["split"]] = row["value"]
        line |= {f"{row['split']}_{name}": row[name] for name in (*RESULT, *STATE)}
        line |= {name: row[name] for name in ("standing", "submission")}
        if line.get("predict_us") is None:
            line |= {name: row[name] for name in COST}
    _set_paper(lines, figures)
    ordered = sorted(lines.items(), key=lambda item: _row_order(*item[0]))
    names = [f"{split}{suffix}" for split in splits for suffix in ("", *(f"_{name}" for name in (*RESULT, *STATE)))]
    columns = ["role", "modality", "method", "standing", "submission"]
    columns += ["paper", "paper_low", "paper_high", "paper_note"] if figures else []
    columns += [*names, *COST]
    frame = pd.DataFrame(
        [{"role": key[0], "modality": key[1], "method": key[2], **line} for key, line in ordered], columns=columns
    )
    measured = kept.dropna(subset=["value"])
    return ResultTable(
        task=str(task),
        protocol_version=int(protocol_version),
        variant=str(variant),
        kind=str(kind),
        dataset=str(dataset),
        dataset_hash=str(dataset_hash),
        metric=str(measured["metric"].iloc[0]) if len(measured) else "accuracy",
        unit=str(measured["unit"].iloc[0]) if len(measured) else "%",
        splits=splits,
        frame=frame,
        superseded=len(rows) - len(kept),
        paper_table=figures[0].table if figures else "",
        press=figures[0].press if figures else "",
        apart=str(apart),
    )


def _set_paper(lines: dict[tuple[str, str, str], Row], figures: tuple[PaperFigure, ...]) -> None:
    """Lay the paper's figures beside ours; a figure without a record of ours makes a row of its own."""
    for figure in figures:
        wanted = [("method", figure.modality, figure.method)]
        equal = ("method", f"{figure.modality}-equal", figure.method)
        if equal in lines:
            wanted = [key for key in (*wanted, equal) if key in lines]
        low, high = figure.interval
        for key in wanted:
            lines.setdefault(key, {}).update(
                paper=figure.percent, paper_low=low, paper_high=high, paper_note=figure.note
            )


def _row_order(role: str, modality: str, method: str) -> tuple[object, ...]:
    return ROLES.index(role), order(MODALITIES, modality), order(METHODS, method)
