"""Which of the household objects is pressed? Deep presses only.

Data: presses of 27 objects, taxel forces averaged over the hold and the frame at the hold.
Target: the object. Splits: ten stratified draws at 9:1, as in the FVSight paper, and each sensor unit held out.
Metrics: accuracy, balanced accuracy. Intervals: over presses for random draws, over units when held out.
Probes: load centroid, total force, rest frame, shuffled labels. Upper line: the true displacement field.
On `hard`, shallow presses stay out here: `objects/interference/v1` has them.
"""

from functools import partial

from vtbench.tasks.base import Task
from vtbench.tasks.presses import MODALITIES, PROBES, UPPER_LINES, load_presses, variants

TASK = Task(
    id="objects/deep/v1",
    about="name the pressed object from one deep press",
    reads="presses",
    load=partial(load_presses, press="deep"),
    variants=variants(test_fraction=1 / 10),
    modalities=MODALITIES,
    probes=PROBES,
    upper_lines=UPPER_LINES,
)
