"""How many presses of an object does a method need?

Data: deep presses; the variant's number is how many presses of each object are learnt from.
Splits: `random`, ten draws on each sensor alone, one press of each object tested on the same sensor; and each sensor
unit held out whole, with the presses drawn from all other sensors, ten draws. Test presses are the same for every
number, and fewer presses are always among the more.
With one press an object nothing can be held back to choose on: the first of every list of choices stands. Nearest
neighbours are never more than the training presses.
Target, metrics, intervals: as `objects/deep/v1`.
"""

from functools import partial

from vtbench.tasks.base import Feed, Task, Variant
from vtbench.tasks.presses import CHANGE, FORCE, PROBES, load_presses
from vtbench.tasks.study_splits import few_of_other_units, few_within

PRESSES = (1, 2, 5, 9)

TASK = Task(
    id="few-shot/v1",
    about="name the pressed object after learning from 1, 2, 5 or 9 presses of each",
    reads="presses",
    load=partial(load_presses, press="deep"),
    variants={
        f"presses-{n}": Variant(
            f"{n} press{'es' if n > 1 else ''} of each object to learn from",
            {"random": few_within(n, max(PRESSES)), "held-out-unit": few_of_other_units(n, max(PRESSES))},
        )
        for n in PRESSES
    },
    modalities={
        "force": Feed((FORCE,)),
        "image-change": Feed((CHANGE,)),
        "fused-change": Feed((CHANGE, FORCE), weights="chosen"),
        "fused-change-equal": Feed((CHANGE, FORCE)),
    },
    probes=PROBES,
)
