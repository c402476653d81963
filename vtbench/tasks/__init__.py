"""One benchmark task a file: data, splits, target, metrics, probes. A new one is a file here and a line below."""

from vtbench.registry import Registry
from vtbench.tasks import (
    few_shot,
    granularity,
    grasp_biotacsp,
    objects_deep,
    objects_interference,
    objects_pose,
    pairing,
    robustness,
    slip_fvsight,
    slip_hard,
    texture_fabricslide16,
)
from vtbench.tasks.base import Task

TASKS: Registry[Task] = Registry("task", see="vtbench list tasks")

_FILES = (
    objects_deep,
    objects_interference,
    objects_pose,
    pairing,
    robustness,
    granularity,
    few_shot,
    texture_fabricslide16,
    slip_fvsight,
    slip_hard,
    grasp_biotacsp,
)
for _file in _FILES:
    TASKS.register(_file.TASK.id)(_file.TASK)

__all__ = ["TASKS", "Task"]
