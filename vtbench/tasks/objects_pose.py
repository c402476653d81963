"""How fast does accuracy fall when the object's pose is unknown?

Data: deep presses, one dataset a variant; the variant's name is the largest unknown shift in millimetres on each axis
(uniform). The angle is unknown in proportion, up to a full turn at 8 mm, so that the curve runs from the poses of
`default` to those of `hard`.
Splits: ten stratified draws at 9:1 over all units, and each sensor unit held out.
Target, metrics, intervals, probes and upper line: as `objects/deep/v1`.
"""

from functools import partial

from vtbench.tasks.base import Task, Variant
from vtbench.tasks.presses import MODALITIES, PROBES, UPPER_LINES, load_presses
from vtbench.tasks.splits import held_out, random_draws

JITTER_MM = (0, 1, 2, 4, 8)

TASK = Task(
    id="objects/pose/v1",
    about="name the pressed object while its pose varies more and more",
    reads="presses",
    load=partial(load_presses, press="deep"),
    variants={
        f"jitter-{mm}mm": Variant(
            f"unknown shift up to {mm} mm on each axis",
            {
                "random": random_draws(test_fraction=1 / 10, strata=("unit",)),
                "held-out-unit": held_out("unit"),
            },
        )
        for mm in JITTER_MM
    },
    modalities=MODALITIES,
    probes=PROBES,
    upper_lines=UPPER_LINES,
)
