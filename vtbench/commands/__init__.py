"""The commands of `vtbench`, one a module.

Each module has `add(commands)`, which declares the command, and does its work in a function that imports what it
needs when it runs: the door itself stays light.
"""

from vtbench.commands import (
    backbones,
    board,
    bring,
    calibrate_taxels,
    check,
    compare,
    convert,
    env,
    evaluate,
    explain,
    export,
    frame_cost,
    generate,
    listing,
    objects,
    physics,
    run,
    score_slip,
    show,
    slip_cost,
    sparse_cost,
    submissions,
    time,
    train_backbone,
)

MODULES = (
    listing,
    objects,
    check,
    generate,
    bring,
    convert,
    show,
    run,
    score_slip,
    evaluate,
    export,
    submissions,
    board,
    compare,
    explain,
    physics,
    calibrate_taxels,
    frame_cost,
    slip_cost,
    sparse_cost,
    time,
    backbones,
    train_backbone,
    env,
)
