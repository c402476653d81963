"""The numbered rules of a submission, and how a breach of one is told: expected, found, how to fix."""

from __future__ import annotations

from dataclasses import dataclass

RULES = {
    "S001": "the folder holds a readable submission.yaml",
    "S002": "submission.yaml has the keys it needs, and no others",
    "S003": "text is one line of plain text: no markup, no control characters",
    "S004": "the link is a web address",
    "S005": "task, variant and split exist",
    "S006": "the artifact is a file inside the folder",
    "S007": "the artifact is not too large",
    "S008": "the model keeps the ONNX contract",
    "S009": "the predictions can be read, are finite and name each sample once a fold",
    "S010": "no other submission has this id, or this artifact under another id",
    "S011": "no two entries are for the same task, variant, split and fold",
}


@dataclass(frozen=True)
class Problem:
    """A breach of one rule. `entry` counts from 0; None is the submission as a whole."""

    rule: str
    found: str
    fix: str
    entry: int | None = None

    def __str__(self) -> str:
        where = "" if self.entry is None else f"entry {self.entry + 1}: "
        return f"{self.rule} {where}{self.found}; {self.fix} (rule: {RULES[self.rule]})"
