"""The likeness of what three draws to fvvrender, for each of its renderers (./run bench three).

The least PSNR away from outlines, over eight poses, with visibility weights and with depth maps: js/three/test/poses.mjs.
"""

import json
import pathlib

from player_renderer import run

ROOT = pathlib.Path(__file__).resolve().parents[2]


def measure():
    compared = json.loads(run("node", ROOT / "js/three/test/poses.mjs"))
    figures = {}
    for one in compared["found"]:
        if "skipped" in one:
            print(f"three: {one['kind']}: not measured: {one['skipped']}")
            continue
        least = min(line["minPsnr"] for line in one["lines"])
        figures[f"three.{one['kind'].replace('-', '_')}_psnr_db"] = least
    return figures
