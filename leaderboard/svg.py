"""A few marks, scales and ticks as inline SVG. Colours come from the page's style sheet, so dark mode is its affair."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, floor, log10

from markupsafe import Markup


@dataclass(frozen=True)
class Scale:
    """Data -> pixels, linear or logarithmic."""

    low: float
    high: float
    start: float
    stop: float
    log: bool = False

    def __call__(self, value: float) -> float:
        """Return the pixel of a value."""
        low, high = (log10(self.low), log10(self.high)) if self.log else (self.low, self.high)
        at = log10(value) if self.log else value
        return self.start + (at - low) / (high - low) * (self.stop - self.start)

    def ticks(self) -> list[float]:
        """Round values inside the scale: decades when logarithmic, else three to six steps of 1, 2 or 5."""
        if self.log:
            return [10.0**e for e in range(ceil(log10(self.low) - 1e-9), floor(log10(self.high) + 1e-9) + 1)]
        step = nice_step((self.high - self.low) / 6)
        first = ceil(self.low / step - 1e-9)
        return [k * step for k in range(first, floor(self.high / step + 1e-9) + 1)]


def nice_top(value: float) -> float:
    """Return the end of an axis from zero that holds `value` and falls on a tick."""
    step = nice_step(value / 6)
    return ceil(value / step - 1e-9) * step


def nice_step(least: float) -> float:
    """Return the smallest of 1, 2, 5 times a power of ten that is not below `least`."""
    power = 10.0 ** floor(log10(least))
    return next(m * power for m in (1, 2, 5, 10) if m * power >= least * (1 - 1e-9))


def decades(values: Sequence[float]) -> tuple[float, float]:
    """Return the powers of ten that enclose positive values, at least one decade apart."""
    low, high = floor(log10(min(values)) + 1e-9), ceil(log10(max(values)) - 1e-9)
    return 10.0**low, 10.0 ** max(high, low + 1)


def line(x1: float, y1: float, x2: float, y2: float, css: str) -> Markup:
    """Return a straight line."""
    return Markup('<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" class="{}"/>').format(x1, y1, x2, y2, css)


def polyline(points: Sequence[tuple[float, float]], css: str) -> Markup:
    """Return a line through points."""
    joined = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return Markup('<polyline points="{}" class="{}"/>').format(joined, css)


def text(x: float, y: float, content: str, css: str = "tick", anchor: str = "middle") -> Markup:
    """Return a label."""
    return Markup('<text x="{:.1f}" y="{:.1f}" class="{}" text-anchor="{}">{}</text>').format(
        x, y, css, anchor, content
    )


SHAPES: tuple[str, ...] = (
    "M-4.5,0a4.5,4.5 0 1,0 9,0a4.5,4.5 0 1,0 -9,0Z",
    "M-4,-4H4V4H-4Z",
    "M0,-5.8L5.8,0L0,5.8L-5.8,0Z",
    "M0,-5.2L5,3.8H-5Z",
    "M0,5.2L5,-3.8H-5Z",
    "M-1.6,-5H1.6V-1.6H5V1.6H1.6V5H-1.6V1.6H-5V-1.6H-1.6Z",
    "M-4.7,-2.6L-2.6,-4.7L0,-2.1L2.6,-4.7L4.7,-2.6L2.1,0L4.7,2.6L2.6,4.7L0,2.1L-2.6,4.7L-4.7,2.6L-2.1,0Z",
    "M-5,0L-2.5,-4.4H2.5L5,0L2.5,4.4H-2.5Z",
)
"""Circle, square, diamond, triangle up, triangle down, plus, cross, hexagon."""


def point(x: float, y: float, shape: int, css: str, tip: str, key: str, data: tuple[float, float]) -> Markup:
    """Return a data point that opens the record `key`; `data` are the figures that it stands for."""
    return Markup(
        '<a href="#r-{}" class="point" data-key="{}" data-x="{!r}" data-y="{!r}" aria-label="{}">{}</a>'
    ).format(key[:16], key, *map(float, data), tip, mark(x, y, shape, css, tip))


def mark(x: float, y: float, shape: int, css: str, tip: str) -> Markup:
    """Return a data point; `tip` is shown by the browser on hover and read aloud."""
    return Markup('<path d="{}" transform="translate({:.1f} {:.1f})" class="mark {}"><title>{}</title></path>').format(
        SHAPES[shape % len(SHAPES)], x, y, css, tip
    )


def whisker(x: float, low: float, high: float, css: str) -> Markup:
    """Return a vertical interval with caps; `low` and `high` are pixels."""
    caps = [line(x - 2.5, y, x + 2.5, y, f"whisker {css}") for y in (low, high)]
    return Markup("").join([line(x, low, x, high, f"whisker {css}"), *caps])


def frame(x: Scale, y: Scale, head: str, x_title: str, y_title: str, x_tick: Callable[[float], str]) -> Markup:
    """Return grid lines, ticks and titles; `y.start` is the bottom. The titles of panel and y axis stand on top."""
    parts = [text(x.start, y.stop - 28, head, "head", "start"), text(x.start, y.stop - 12, y_title, "label", "start")]
    for value in y.ticks():
        parts.append(line(x.start, y(value), x.stop, y(value), "grid"))
        parts.append(text(x.start - 6, y(value) + 4, f"{value:g}", anchor="end"))
    for value in x.ticks():
        parts += [line(x(value), y.start, x(value), y.start + 4, "axis"), text(x(value), y.start + 17, x_tick(value))]
    parts.append(line(x.start, y.start, x.stop, y.start, "axis"))
    parts.append(text((x.start + x.stop) / 2, y.start + 34, x_title, "label"))
    return Markup("").join(parts)


def drawing(width: float, height: float, title: str, body: Markup) -> Markup:
    """Return the whole picture with a title for screen readers."""
    return Markup(
        '<svg viewBox="0 0 {:.0f} {:.0f}" role="{}" aria-label="{}" xmlns="http://www.w3.org/2000/svg">{}</svg>'
    ).format(width, height, "group" if "<a " in body else "img", title, body)
