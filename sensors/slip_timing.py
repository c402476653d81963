"""What a frame of a slip trial costs: its part of the trial's contact, friction and taxels, and its picture."""

from __future__ import annotations

import time

from sensors.slide import SlipScene, simulate_slide

SLIP_STAGES = ("contact, friction, taxels", "render", "frame total")


def measure_slip_frame(rounds: int, seed: int = 0) -> dict[str, list[float]]:
    """CPU ms of a frame by stage, a value a trial: a trial with frames and one without, over the number of frames.

    Trials are slides over the scene's objects in turn; the first, which compiles, is not counted.
    """
    scene = SlipScene(id="timing", title="timing")
    spent: dict[str, list[float]] = {stage: [] for stage in SLIP_STAGES}
    for number in range(rounds + 1):
        index = number % len(scene.objects)
        start = time.process_time_ns()
        simulate_slide(scene, index, seed)
        middle = time.process_time_ns()
        trial = simulate_slide(scene, index, seed, frames=True)
        end = time.process_time_ns()
        if number == 0:
            continue
        frames = len(trial.frame_time_s)
        forces, whole = (middle - start) / 1e6 / frames, (end - middle) / 1e6 / frames
        for stage, value in zip(SLIP_STAGES, (forces, whole - forces, whole), strict=True):
            spent[stage].append(value)
    return spent
