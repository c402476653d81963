"""When does the object begin to slip, and what else raises an alarm?

Data: slides at five speeds, three loads and eight directions, rotation, incipient slip that recovers, and trials
without any slip: load changes, tapping, vibration of the arm, drift, recovery after a release; three sensor units. A
second dataset of long trials without slip adds the minutes that a low rate of false alarms needs.
Target, thresholds and metrics: as `slip/fvsight/v1`, with the area of the ROC by trial (trials of the first dataset:
alike in length), and by speed, load, direction and kind. An alarm in incipient slip that recovers is shown apart: it is
neither a detection nor a false alarm.
Split: each object held out. A rate is supported where 30 false alarms are expected: 300 minutes for 0.1 a minute.
Probe: the energy of the total force alone.
"""

from vtbench.tasks.base import Variant
from vtbench.tasks.slides import PROBES, RULES, SlipTask, held_out_object, load_one

TASK = SlipTask(
    id="slip/hard/v1",
    about="raise an alarm when the object begins to slip, and at nothing that resembles it",
    reads="slides",
    load=load_one,
    variants={
        "hard": Variant(
            "speeds, loads, directions, rotation; every kind of trial without slip",
            {"held-out-object": held_out_object},
        )
    },
    modalities=RULES,
    probes=PROBES,
)
