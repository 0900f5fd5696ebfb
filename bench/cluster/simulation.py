"""How long a cluster takes for a capture that is too long to measure, from times that were measured.

A discrete-event simulation: plan, groups and merge follow each other. One scheduler hands out one task at a time, which costs
the measured overhead; a worker that is done waits for its next task. Storage is as fast for all workers as for one.
"""

import heapq
import random


def encode_seconds(tasks, workers, overhead):
    """Until the last of `tasks` (seconds each, in order) is done."""
    free = [0.0] * workers  # when each worker is
    scheduler = 0.0
    end = 0.0
    for seconds in tasks:
        begin = max(heapq.heappop(free), scheduler) + overhead
        scheduler = begin
        heapq.heappush(free, begin + seconds)
        end = max(end, begin + seconds)
    return end


def draw(measured, count, parts):
    """Seconds of `count` groups, each of `parts` of the measured ones, drawn by chance with a fixed seed."""
    chance = random.Random(1)
    return [sum(chance.choices(measured, k=parts)) for _ in range(count)]


def figures(tasks, plan, merge, overhead, workers):
    """Minutes and speedups by number of workers, over one worker that plans and merges alike."""
    found = {}
    alone = encode_seconds(tasks, 1, overhead)
    for count in workers:
        encode = encode_seconds(tasks, count, overhead)
        found[f"dask.simulated_minutes_{count}"] = (plan + encode + merge) / 60
        found[f"dask.simulated_speedup_{count}"] = (plan + alone + merge) / (plan + encode + merge)
        found[f"dask.simulated_encode_speedup_{count}"] = alone / encode
    return found
