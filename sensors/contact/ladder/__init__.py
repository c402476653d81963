"""The contact ladder: rungs behind one interface, and the cheapest whose measured error meets a bound.

`python -m sensors.contact.ladder` measures every rung again and rewrites the committed table.
"""

from sensors.contact.ladder.choose import Choice, choose_rung
from sensors.contact.ladder.indenters import INDENTER_CLASSES, indenter
from sensors.contact.ladder.interface import OpenRung, Pad, Response, Rung
from sensors.contact.ladder.measure import measure_ladder
from sensors.contact.ladder.rungs import RUNGS, get_rung
from sensors.contact.ladder.table import LadderTable, Row, committed_table, read_table, write_table

__all__ = [
    "INDENTER_CLASSES",
    "RUNGS",
    "Choice",
    "LadderTable",
    "OpenRung",
    "Pad",
    "Response",
    "Row",
    "Rung",
    "choose_rung",
    "committed_table",
    "get_rung",
    "indenter",
    "measure_ladder",
    "read_table",
    "write_table",
]
