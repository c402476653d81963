"""Which of the household objects is pressed, when some presses are shallow?

Data: as `objects/deep/v1` with the shallow presses (2 of 12) in training and test parts alike.
Splits: ten stratified draws at 11:1, as in the FVSight paper, and each sensor unit held out.
Target, metrics, intervals, probes and upper line: as `objects/deep/v1`.
"""

from functools import partial

from vtbench.tasks.base import Task
from vtbench.tasks.presses import MODALITIES, PROBES, UPPER_LINES, load_presses, variants

TASK = Task(
    id="objects/interference/v1",
    about="name the pressed object from one press, deep or shallow",
    reads="presses",
    load=partial(load_presses, press="any"),
    variants=variants(test_fraction=1 / 12),
    modalities=MODALITIES,
    probes=PROBES,
    upper_lines=UPPER_LINES,
)
