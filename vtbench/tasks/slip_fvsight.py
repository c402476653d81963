"""When does the object begin to slip? The FVSight paper's protocol.

Data: 5 N, rest - lateral motion at a fixed speed - rest; ball, cuboid and cylinder, 20 trials each; taxel forces.
Target: the onset of gross slip. A trial counts as found when an alarm is raised within its slip, or up to 0.25 s before
it, while the contact slips in part; one that has been on since earlier is a false alarm.
Thresholds: `prior`, the score that 90 % of an earlier slip's samples attain, the median over the training slips taken
as the earlier one in turn; `cfar`, 0.001 false alarms a sample, before hold-on, on noise like that of training rests.
Splits: three random parts over the trials of all objects (the paper's: an earlier slip of the same objects), and each
object held out.
Metrics: slips found, by object as in the paper's table IV; trials with a false alarm; onset delay at 0.1, 1 and 10
false alarms a minute, beside the energy baseline, paired over trials. Intervals: over trials, Wilson for shares.
Probe: the energy of the total force alone.
"""

from vtbench.tasks.base import Variant
from vtbench.tasks.slides import PROBES, RULES, SlipTask, held_out_object, load_one, random_folds

TASK = SlipTask(
    id="slip/fvsight/v1",
    about="raise an alarm when the object begins to slip, the paper's protocol",
    reads="slides",
    load=load_one,
    variants={
        "paper": Variant(
            "5 N, one direction, one speed; ball, cuboid and cylinder, 20 trials each",
            {"random": random_folds(3), "held-out-object": held_out_object},
        )
    },
    modalities=RULES,
    probes=PROBES,
)
