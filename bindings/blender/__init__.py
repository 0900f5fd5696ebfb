"""File > Import > Free-Viewpoint Video (.fvv), as an extension of Blender. What it does is in fvv.interop.blender."""

import os

import bpy
import fvv
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper
from fvv.interop import blender

COLOURS = (
    ("auto", "Automatic", "The atlas if there is one; by the view of up to 12 cameras; baked from more"),
    ("view", "By View", "The pictures of the cameras that show the surface best from where it is seen"),
    ("baked", "Baked", "One colour for each vertex, from all cameras that see it"),
    ("sent", "Sent", "The colours of vertices that are in the file, of low resolution"),
)


class ImportFvv(bpy.types.Operator, ImportHelper):
    """Import a free-viewpoint video: meshes that follow the timeline, and its cameras"""

    bl_idname = "import_scene.fvv"
    bl_label = "Import Free-Viewpoint Video"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".fvv"

    filter_glob: StringProperty(default="*.fvv", options={"HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    first: IntProperty(
        name="Start Frame", default=1, description="Frame of the scene at which the clip begins"
    )
    colours: EnumProperty(name="Colours", items=COLOURS, default="auto")
    pictures: BoolProperty(
        name="Pictures of Cameras", default=True, description="As background images of the cameras"
    )
    environment: BoolProperty(
        name="Environment", default=True, description="Surroundings and lights, if there are any"
    )
    sound: BoolProperty(name="Sound", default=True, description="As strips of the sequencer")
    exact: BoolProperty(
        name="Colours as Filmed",
        default=True,
        description='Set the view transform of the scene to "Standard", which shows the colours of pictures as they are',
    )

    def execute(self, context):
        paths = [os.path.join(self.directory, one.name) for one in self.files if one.name] or [self.filepath]
        for path in paths:
            try:
                clip = fvv.open(path)
                shown = blender.load(
                    clip,
                    os.path.splitext(os.path.basename(path))[0],
                    first=self.first,
                    colours=None if self.colours == "auto" else self.colours,
                    pictures=self.pictures,
                    environment=self.environment,
                    sound=self.sound,
                )
            except (fvv.Error, OSError) as error:
                self.report({"ERROR"}, str(error))
                return {"CANCELLED"}
            self.report({"INFO"}, f"{shown.name}: {len(clip)} frames")
        if self.exact:
            context.scene.view_settings.view_transform = "Standard"
        return {"FINISHED"}


class DropFvv(bpy.types.FileHandler):
    """Files that are dropped on the 3D viewport"""

    bl_idname = "IMPORT_SCENE_FH_fvv"
    bl_label = "Free-Viewpoint Video"
    bl_import_operator = ImportFvv.bl_idname
    bl_file_extensions = ".fvv"

    @classmethod
    def poll_drop(cls, context):
        return context.area is not None and context.area.type == "VIEW_3D"


@bpy.app.handlers.persistent
def _restore(*_):
    blender.restore()


def _import_item(menu, _):
    menu.layout.operator(ImportFvv.bl_idname, text="Free-Viewpoint Video (.fvv)")


def register():
    for one in (ImportFvv, DropFvv):
        bpy.utils.register_class(one)
    bpy.types.TOPBAR_MT_file_import.append(_import_item)
    bpy.app.handlers.load_post.append(_restore)


def unregister():
    bpy.app.handlers.load_post.remove(_restore)
    bpy.types.TOPBAR_MT_file_import.remove(_import_item)
    for one in (DropFvv, ImportFvv):
        bpy.utils.unregister_class(one)
