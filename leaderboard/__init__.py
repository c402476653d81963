"""Records in, tables that can be trusted out."""

from __future__ import annotations

import importlib
from typing import Any

_MODULES = {
    "board": ["BoardFiles", "build_board"],
    "console": ["format_console"],
    "baselines": ["read_baselines", "write_baselines"],
    "caution": ["coverage_warning"],
    "contents": ["BoardTables", "board_tables"],
    "paired": ["Comparison", "compare_groups", "holm"],
    "ranks": ["Entrant", "Rank", "Ranking", "rank"],
    "record": [
        "Identity",
        "Metric",
        "Provenance",
        "Record",
        "RecordWarning",
        "Status",
        "Timing",
        "Verdict",
        "read_predictions",
        "read_records",
        "record_key",
        "scan_records",
        "write_record",
    ],
    "tally": ["Tally", "read_tallies", "write_tally"],
    "statistics": ["Interval", "group_interval", "paired_group_difference", "wilson"],
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    """Load the module that holds a public name when the name is first used."""
    if name not in _HOME:
        raise AttributeError(f"module 'leaderboard' has no attribute '{name}'")
    return getattr(importlib.import_module(f"leaderboard.{_HOME[name]}"), name)
