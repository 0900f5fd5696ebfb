"""A clip in Blender: objects that follow the frame of the scene.

The extension in bindings/blender has menus for what is here. `bpy` is imported when a clip is loaded.
"""

from __future__ import annotations

from .colours import baked
from .shown import Colours, Shown, load, restore

__all__ = ["Colours", "Shown", "baked", "load", "restore"]
