"""File > Import > Free-Viewpoint Video (.fvv), as an extension of Blender. What it does is in fvv.interop.blender."""

import os

import bpy
import fvv
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)
from bpy_extras.io_utils import ExportHelper, ImportHelper
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


class ExportFvv(bpy.types.Operator, ExportHelper):
    """Export meshes of the frame range as a free-viewpoint video, with their texture or as cameras see them"""

    bl_idname = "export_scene.fvv"
    bl_label = "Export Free-Viewpoint Video"
    filename_ext = ".fvv"

    filter_glob: StringProperty(default="*.fvv", options={"HIDDEN"})
    selected: BoolProperty(name="Selected Only", default=False)
    source: EnumProperty(
        name="Pictures",
        items=(
            ("texture", "Texture", "The image of the material, baked, with the active UV map"),
            ("cameras", "Cameras of the Scene", "Renders each frame from all cameras of the scene"),
            ("ring", "Ring of Cameras", "Renders each frame from new cameras around the meshes"),
        ),
    )
    count: IntProperty(name="Cameras of the Ring", default=12, min=3, max=64)
    max_error: FloatProperty(
        name="Error",
        default=0.0,
        min=0.0,
        unit="LENGTH",
        description="Of the surface, at most; 0: as suits the pictures",
    )

    def execute(self, context):
        given = context.selected_objects if self.selected else context.visible_objects
        meshes = [one for one in given if one.type == "MESH" and not one.hide_render]
        options = {"max_error": f"{1000 * self.max_error:g}mm"} if self.max_error else {}
        added = []
        context.window_manager.progress_begin(0, 1)
        try:
            if not meshes:
                raise fvv.UsageError(f"{self.filepath}: expected a mesh to export, found none")
            options |= {
                "force": True,
                "progress": lambda done, of: context.window_manager.progress_update(done / of),
            }
            if self.source == "texture":
                blender.export_textured(self.filepath, meshes, **options)
            else:
                if self.source == "ring":
                    added = blender.add_ring(meshes, self.count)
                cameras = added or [one for one in context.scene.objects if one.type == "CAMERA"]
                blender.export_rendered(self.filepath, meshes, cameras, **options)
        except (fvv.Error, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            context.window_manager.progress_end()
            bpy.data.batch_remove([one.data for one in added])
        return {"FINISHED"}


class ChooseColours(bpy.types.Operator):
    """Show the surface of a clip with other colours"""

    bl_idname = "object.fvv_colours"
    bl_label = "Colours of a Free-Viewpoint Video"
    bl_options = {"REGISTER", "UNDO"}

    colours: EnumProperty(name="Colours", items=COLOURS[1:])

    @classmethod
    def poll(cls, context):
        return _root_of(context.object) is not None

    def execute(self, context):
        _root_of(context.object)["fvv_colours"] = self.colours
        context.scene.frame_set(context.scene.frame_current)
        return {"FINISHED"}


class ClipPanel(bpy.types.Panel):
    bl_idname = "OBJECT_PT_fvv"
    bl_label = "Free-Viewpoint Video"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "object"

    @classmethod
    def poll(cls, context):
        return _root_of(context.object) is not None

    def draw(self, context):
        root, layout = _root_of(context.object), self.layout
        layout.prop(root, '["fvv_source"]', text="File")
        layout.prop(root, '["fvv_first"]', text="Start Frame")
        if "fvv_problem" in root:
            layout.label(text=root["fvv_problem"], icon="ERROR")
        row = layout.row(align=True)
        for identifier, name, _ in COLOURS[1:]:
            is_chosen = root["fvv_colours"] == identifier
            row.operator(ChooseColours.bl_idname, text=name, depress=is_chosen).colours = identifier


def _root_of(item):
    """The empty of the clip that an object belongs to; None: of none."""
    while item is not None and "fvv_source" not in item:
        item = item.parent
    return item


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


def _export_item(menu, _):
    menu.layout.operator(ExportFvv.bl_idname, text="Free-Viewpoint Video (.fvv)")


CLASSES = (ImportFvv, ExportFvv, ChooseColours, ClipPanel, DropFvv)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.TOPBAR_MT_file_import.append(_import_item)
    bpy.types.TOPBAR_MT_file_export.append(_export_item)
    bpy.app.handlers.load_post.append(_restore)


def unregister():
    bpy.app.handlers.load_post.remove(_restore)
    bpy.types.TOPBAR_MT_file_export.remove(_export_item)
    bpy.types.TOPBAR_MT_file_import.remove(_import_item)
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
