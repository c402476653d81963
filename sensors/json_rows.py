"""Tables of measured rows as JSON that a diff can be read in: a line for each entry of the head and for each row."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any


def json_rows(head: Mapping[str, Any], tables: Mapping[str, Sequence[Any]]) -> str:
    """JSON of `head`, then of each table of dataclass instances."""
    lines = [f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in head.items()]
    for name, rows in tables.items():
        body = ",\n".join("    " + json.dumps(asdict(row)) for row in rows)
        lines.append(f"  {json.dumps(name)}: [\n{body}\n  ]")
    return "{\n" + ",\n".join(lines) + "\n}\n"
