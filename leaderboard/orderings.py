"""Which orderings of the FVSight paper hold here: its better method against its worse one, on the same samples."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from leaderboard.names import USUAL_BACKBONE
from leaderboard.paired import MARGIN
from leaderboard.paper import FIGURES
from leaderboard.record import Record
from leaderboard.tally import Tallies
from leaderboard.versus import Versus, compare_pairs, protocol_of, usable

READINGS = {
    "frames, equal weights: the paper's own": ("image", "fused-equal"),
    "frames, weights chosen": ("image", "fused"),
    "frames minus rest, weights chosen": ("image-change", "fused-change"),
    "frames minus rest, equal weights": ("image-change", "fused-change-equal"),
}
"""What stands for the paper's image and for its force + image."""
JOINT = ("jksc-independent", "jksc")
"""A code for each modality, as the paper writes it, and one support for both, as the source that it follows."""
Word = Literal["holds", "reversed", "equal here", "not shown"]
_WORDS: dict[str, Word] = {
    "first better": "holds",
    "second better": "reversed",
    "equivalent": "equal here",
    "undecided": "not shown",
}


@dataclass(frozen=True)
class Ordering:
    """One claim on one protocol: `result.first` is the better one in the source; its figures in percent, if printed.

    `reading` is one of `READINGS`, `backbone` what its frames went through, empty where no method saw any; verdicts are
    adjusted over its claims on one protocol.
    """

    reading: str
    backbone: str
    result: Versus
    paper: tuple[float, float] | None

    @property
    def word(self) -> Word:
        """`holds` or `reversed` after Holm's step-down, `equal here` within the margin, `not shown` otherwise."""
        return _WORDS[self.result.verdict.word]


def orderings(
    records: Iterable[Record], tallies: Tallies, near: Mapping[str, str], margin: float = MARGIN
) -> list[Ordering]:
    """Return what was found of each claim that two scored records of one protocol can judge, by backbone and reading.

    Frames of one backbone are compared with each other, and with force alone. A claim that two readings or backbones
    share, such as that of force alone, stands with the first. Arguments as those of `versus.compare_pairs`.
    """
    protocols: dict[tuple[str, ...], list[Record]] = {}
    for record in usable(records):
        protocols.setdefault(protocol_of(record), []).append(record)
    made = []
    for (task, *_), rows in protocols.items():
        seen: set[tuple[str, str]] = set()
        for backbone, there in _by_backbone(rows).items():
            for reading, feeds in READINGS.items():
                claims = [c for c in _claims(task, *feeds) if c[0] in there and c[1] in there]
                new = {c: (there[c[0]], there[c[1]]) for c in claims}
                new = {c: pair for c, pair in new.items() if (pair[0].key, pair[1].key) not in seen}
                seen |= {(first.key, second.key) for first, second in new.values()}
                results = compare_pairs(list(new.values()), (tallies, tallies), near, margin)
                made += [
                    Ordering(reading, backbone, result, _figures(task, *claim))
                    for claim, result in zip(new, results, strict=True)
                ]
    return made


def _by_backbone(records: Iterable[Record]) -> dict[str, dict[str, Record]]:
    """Return records by `method@modality` for each backbone, the usual one first; those without frames are in all."""
    rows = list(records)
    named = sorted({_backbone(r) for r in rows} - {""}, key=lambda name: (name != USUAL_BACKBONE, name)) or [""]
    return {
        name: {f"{r.identity.method}@{r.identity.modality}": r for r in rows if _backbone(r) in ("", name)}
        for name in named
    }


def _backbone(record: Record) -> str:
    return str(record.identity.params.get("backbone", ""))


def _claims(task: str, image: str, fused: str) -> Iterable[tuple[str, str]]:
    """Return (better, worse) by the paper's table of the task; by table II where it has none."""
    yield f"jksc@{fused}", f"jksc-independent@{fused}"
    for joint in JOINT:
        yield from (_sorted(task, f"{joint}@{fused}", f"{other}@{fused}") for other in ("knn", "svm"))
        yield from (_sorted(task, f"{joint}@{fused}", f"ksc@{alone}") for alone in ("force", image))
    for method in ("knn", "svm"):
        yield from (_sorted(task, f"{method}@{fused}", f"{method}@{alone}") for alone in ("force", image))
    for alone in ("force", image):
        yield from (_sorted(task, f"ksc@{alone}", f"{other}@{alone}") for other in ("knn", "svm"))


def _sorted(task: str, first: str, second: str) -> tuple[str, str]:
    figures = _figures(task, first, second) or _figures("objects/deep", first, second)
    return (second, first) if figures is not None and figures[0] < figures[1] else (first, second)


def _figures(task: str, first: str, second: str) -> tuple[float, float] | None:
    """Return the paper's two figures for a task, or None where it has none for one of the two."""
    printed = {(f.method, f.modality): f.percent for f in FIGURES if task.startswith(f.task)}
    found = [printed.get(_in_paper(name)) for name in (first, second)]
    if found[0] is None or found[1] is None or _in_paper(first) == _in_paper(second):
        return None
    return found[0], found[1]


def _in_paper(name: str) -> tuple[str, str]:
    """Return method and feed as the paper has them: it knows one JKSC, one image and one way to put both together."""
    method, _, feed = name.partition("@")
    for image, fused in READINGS.values():
        feed = "image" if feed == image else "fused" if feed == fused else feed
    return ("jksc" if method in JOINT else method), feed
