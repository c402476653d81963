"""The objects themselves, one family a file; importing this package registers them in this order.

A new object is one decorated function: a height of x and y (`register`) or a mesh (`register_mesh`), in mm.
"""

from sensors.objects.shapes import (
    batteries,
    brick,
    button,
    caps,
    coins,
    comb,
    duck,
    earphone,
    fork,
    hardware,
    keys,
    peg,
    pens,
    shaver,
    spoon,
    sticks,
    toothbrush,
    usb_stick,
    walnut,
)

__all__ = [
    "batteries",
    "brick",
    "button",
    "caps",
    "coins",
    "comb",
    "duck",
    "earphone",
    "fork",
    "hardware",
    "keys",
    "peg",
    "pens",
    "shaver",
    "spoon",
    "sticks",
    "toothbrush",
    "usb_stick",
    "walnut",
]
