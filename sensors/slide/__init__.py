"""Slip scenes: FVSight pressed on an object that moves sideways, or is disturbed without slipping.

The model, stage by stage; every figure is a parameter with its unit, fixed before any detector was scored.

Normal contact. One pressure field per place along the path, from the same skin contact as a press; in between, the
shares of taxels and friction cells are interpolated. Load control: the load is given, with the arm's ripple.

Friction. The contact is cut into cells of 1 mm that are fixed to the object. Each is a LuGre element: its bristle is
the shear of film and weave (in series), its limit follows the cell's own normal force, so cells slip one by one, from
the rim inwards where the pressure is low. All cells pull on the skin, which moves as one patch on its in-plane spring
with its own mass and damping. Stick-slip needs a skin softer than (mu_s - mu_d) F_n over the bristle's length, 3 kN/m
at 5 N; the default skin has 10 to 20, so it slides steadily but for what the crowns do. A cell counts as slipping
while it is loaded past the breaking distance of a Coulomb element of the same stiffness and really slides.
Partial slip is 5 % of the load slipping, gross slip 90 %; the onset of a trial is its first sample of gross slip.

A film on a plate (`sensor.support: plate`) is dragged through its own shear instead: as one patch in the same way, or
with `effects.partial_slip` cell by cell (see `partial_slip`). Its base, and the taxels on it, stay where they are.

What the taxels get. They feel normal force only, so slip reaches them by three ways: (a) the pressure pattern moves
over them, by the object's travel less the skin's; (b) thread crowns exchange load as the object rides over the weave, a
function of the distance slid, which keeps the sum of the load; (c) shear through the thickness of the film tips load
towards the side of the drag: the centre of load moves by film thickness times F_t / F_n, at most 0.9 mm. Then a late
share of the film, and the electronics.

What the camera gets. The deflected skin as in a press, its weave dragged along in the plane.

Left out: the skin's in-plane twist (0.01 rad at 5 N), the wrap of the skin in the direction of friction, new bristles
at the leading edge (presliding distance over contact length, some percent), motion blur (0.1 mm at 10 mm/s and 10 ms).
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sensors.slide.figure import draw_slide
    from sensors.slide.recording import GROSS, PARTIAL, STICK, SlideRecording
    from sensors.slide.scene import KINDS, SLIPPING, SlidePlan, SlipScene
    from sensors.slide.simulate import SLIDE_TRUTH, simulate_slide

__all__ = [
    "GROSS",
    "KINDS",
    "PARTIAL",
    "SLIDE_TRUTH",
    "SLIPPING",
    "STICK",
    "SlidePlan",
    "SlideRecording",
    "SlipScene",
    "draw_slide",
    "simulate_slide",
]

_HOME = {
    "GROSS": "recording",
    "KINDS": "scene",
    "PARTIAL": "recording",
    "SLIDE_TRUTH": "simulate",
    "SLIPPING": "scene",
    "STICK": "recording",
    "SlidePlan": "scene",
    "SlideRecording": "recording",
    "SlipScene": "scene",
    "draw_slide": "figure",
    "simulate_slide": "simulate",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
