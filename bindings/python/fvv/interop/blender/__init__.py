"""A clip in Blender: objects that follow the frame of the scene.

The extension in bindings/blender has menus for what is here. `bpy` is imported when a clip is loaded.
"""

from __future__ import annotations

from .colours import baked
from .export import add_ring, export_rendered, export_textured
from .shown import Colours, Shown, load, restore

__all__ = [
    "Colours",
    "Shown",
    "add_ring",
    "baked",
    "export_rendered",
    "export_textured",
    "load",
    "restore",
]
