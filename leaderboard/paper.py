"""The figures that the FVSight paper reports, to print beside ours, with the interval that its trial counts imply.

Source: "A novel tactile sensor with multimodal vision and tactile units for multifunctional robot interaction",
tables II to IV. The paper gives no trial counts for tables II and III: at 9:1 (deep) and 11:1 (deep and shallow) one
run tests one press of each of 27 objects, and every figure is the mean of ten runs, hence 270 predictions. Only 90.00
and 98.89 are multiples of 1/270, so that count is our assumption, and it is printed with the intervals.
"""

from __future__ import annotations

from dataclasses import dataclass

from leaderboard.statistics import wilson

ASSUMED_N = 270
ASSUMPTION = (
    f"The paper's intervals are 95 % Wilson intervals at an assumed n = {ASSUMED_N} (ten runs, one press of each of 27 "
    "objects a run). The paper states no counts; only 90.00 and 98.89 are multiples of 1/270. "
    "Its ten runs share presses, so the true intervals are wider, if anything."
)
CITATION = (
    "FVSight: “A novel tactile sensor with multimodal vision and tactile units for multifunctional robot interaction”, "
    "tables II to IV"
)


@dataclass(frozen=True)
class PaperFigure:
    """One accuracy of tables II and III, in percent, under the ids that our records use."""

    table: str
    press: str
    task: str
    modality: str
    method: str
    percent: float
    note: str = ""

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson interval in percent at the assumed number of predictions."""
        low, high = wilson(self.percent / 100 * ASSUMED_N, ASSUMED_N)
        return 100 * low, 100 * high


@dataclass(frozen=True)
class SlipFigure:
    """One row of table IV: trials in which slip was found, of the trials in which there was slip."""

    shape: str
    found: int
    trials: int = 20

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson interval in percent; here the paper states the counts."""
        low, high = wilson(self.found, self.trials)
        return 100 * low, 100 * high


def _table(table: str, press: str, task: str, rows: dict[str, dict[str, float]]) -> tuple[PaperFigure, ...]:
    return tuple(
        PaperFigure(table, press, task, modality, method, percent, _NOTES.get((table, modality, method), ""))
        for modality, figures in rows.items()
        for method, percent in figures.items()
    )


_NOTES = {("II", "fused", "jksc"): "98.89 in the paper's table, 98.39 in its text"}

TABLE_II = _table(
    "II",
    "deep",
    "objects/deep",
    {
        "force": {"ksc": 88.39, "knn": 83.54, "svm": 90.00},
        "image": {"ksc": 95.31, "knn": 90.95, "svm": 92.00},
        "fused": {"jksc": 98.89, "knn": 91.35, "svm": 95.00},
    },
)
TABLE_III = _table(
    "III",
    "deep + shallow",
    "objects/interference",
    {
        "force": {"ksc": 72.67, "knn": 69.70, "svm": 78.00},
        "image": {"ksc": 76.63, "knn": 75.76, "svm": 84.00},
        "fused": {"jksc": 85.79, "knn": 76.09, "svm": 87.00},
    },
)
TABLE_IV = (SlipFigure("ball", 20), SlipFigure("cuboid", 20), SlipFigure("cylinder", 19))

FIGURES = TABLE_II + TABLE_III
