"""No pad is pressed deeper than it is thick: the linear models do not know their base, so that somebody must."""

from __future__ import annotations

import math

from sensors.contact.solver import ContactSolution


def refuse_depth(depth_m: float, thickness_m: float) -> None:
    """ValueError for a depth that is not finite or reaches the base."""
    if not (math.isfinite(depth_m) and depth_m < thickness_m):
        raise ValueError(f"depth must be finite and less than the pad's thickness {thickness_m} m, got {depth_m} m")


def refuse_through(contact: ContactSolution, thickness_m: float) -> None:
    """ValueError where a load has pressed a pad of this thickness through."""
    if not contact.indentation_m < thickness_m:
        raise ValueError(
            f"a press of {contact.force_n:.3g} N sinks {contact.indentation_m * 1e3:.3g} mm; depth must be less than "
            f"the pad's thickness {thickness_m * 1e3:g} mm: lower the load or take a thicker or stiffer pad"
        )
