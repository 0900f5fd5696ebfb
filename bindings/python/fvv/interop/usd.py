"""A clip as a USD stage: meshes and cameras over time."""

from __future__ import annotations

import os
import shutil
import tempfile
from typing import Any, Union

import numpy

from .._core import Camera, Mesh
from ..clip import EVERY, Clip, ClipFrame
from ..errors import UsageError
from ..outputs import FileOutput
from .conventions import along_minus_z, linear_of_srgb, turned, upside_down
from .optional_import import optional_import

Path = Union[str, "os.PathLike[str]"]


def export(clip: Clip, path: Path, frames: slice = EVERY, *, force: bool = False) -> None:
    """Writes the meshes and cameras of a clip as a USD file: .usd, .usdc (binary) or .usda (text).

    /fvv/mesh_T is the mesh of track T: points, and where they change faces, colours (displayColor, linear light), texture
    coordinates (st), and normals where they were sent. It is invisible before its first frame. /fvv/cameras has the cameras;
    what USD's cameras lack is in the attributes fvv:lens, fvv:distortion, fvv:skew, fvv:width and fvv:height. Time codes are
    frames from the clip's start, metersPerUnit is 1, the up axis is Y or Z; with any other axis up /fvv is rotated. Between time
    codes USD interpolates points: ask for whole time codes where faces change.

    frames: which. force: replaces an existing file. The file appears when it is whole. Raises `UsageError` for other names,
    an existing file, or the file that the clip is read from.
    """
    name = os.fspath(path)
    if os.path.splitext(name)[1] not in (".usd", ".usdc", ".usda"):
        raise UsageError(f"{name}: expected a name that ends in .usd, .usdc or .usda", file=name)
    chosen = clip[frames]
    if not chosen:
        raise UsageError(f"{clip.name}: expected a frame to export, found none", file=clip.name)
    output = FileOutput(name, force, [clip.name])
    try:
        # USD chooses the format by the name, which FileOutput's has not.
        with tempfile.TemporaryDirectory() as folder:
            written = os.path.join(folder, os.path.basename(name))
            _Stage(clip, written).add(chosen)
            with open(written, "rb") as file:
                shutil.copyfileobj(file, output)
        output.commit()
    finally:
        output.discard()


class _Stage:
    """A stage that is being written."""

    def __init__(self, clip: Clip, path: str) -> None:
        self._clip = clip
        self._usd = {
            name: optional_import(f"pxr.{name}", "usd") for name in ("Gf", "Sdf", "Usd", "UsdGeom", "Vt")
        }
        geometry = self._usd["UsdGeom"]
        self._stage = self._usd["Usd"].Stage.CreateNew(path)
        up = clip.up or "+y"
        geometry.SetStageUpAxis(self._stage, geometry.Tokens.z if up == "+z" else geometry.Tokens.y)
        geometry.SetStageMetersPerUnit(self._stage, 1.0)
        self._stage.SetTimeCodesPerSecond(float(clip.rate))
        self._stage.SetFramesPerSecond(float(clip.rate))
        root = geometry.Xform.Define(self._stage, "/fvv")
        self._stage.SetDefaultPrim(root.GetPrim())
        if up not in ("+y", "+z"):
            root.AddTransformOp().Set(self._matrix(turned(up, "+y")))
        # By path of the attribute: what its value follows from, the value, and the time code up to which it holds.
        self._known: dict[str, tuple[object, Any, float]] = {}

    def add(self, frames: list[ClipFrame]) -> None:
        codes = [self._code(frame) for frame in frames]
        self._stage.SetStartTimeCode(codes[0])
        self._stage.SetEndTimeCode(codes[-1])
        for frame, code in zip(frames, codes):
            for track, mesh in frame.meshes.items():
                self._add_mesh(f"/fvv/mesh_{track}", mesh, code, first=codes[0])
            for camera in frame.cameras.values():
                self._add_camera(camera, code)
        self._stage.GetRootLayer().Save()

    def _code(self, frame: ClipFrame) -> float:
        code = (frame.time - self._clip.start) * float(self._clip.rate)
        return float(round(code)) if abs(code - round(code)) < 1e-6 else code

    def _matrix(self, rotation: Any) -> Any:
        """Of USD, which multiplies rows by matrices."""
        whole = numpy.eye(4)
        whole[:3, :3] = numpy.transpose(rotation)
        return self._usd["Gf"].Matrix4d(*whole.ravel().tolist())

    def _set(self, attribute: Any, value: Any, code: float, changed: object) -> None:
        """Sets a sample where what it follows from is not that of the sample before. USD interpolates: what was not set
        since gets a second sample where it ends."""
        key = str(attribute.GetPath())
        before, held, last = self._known.get(key, (None, None, code))
        if before != changed:
            if before is not None:
                attribute.Set(held, last)
            attribute.Set(value, code)
            held = value
        self._known[key] = (changed, held, code)

    def _add_mesh(self, path: str, mesh: Mesh, code: float, first: float) -> None:
        geometry, vt, types = self._usd["UsdGeom"], self._usd["Vt"], self._usd["Sdf"].ValueTypeNames
        prim = geometry.Mesh.Get(self._stage, path)
        if not prim:
            prim = geometry.Mesh.Define(self._stage, path)
            prim.CreateSubdivisionSchemeAttr(geometry.Tokens.none)
            if code > first:
                prim.CreateVisibilityAttr().Set(geometry.Tokens.invisible, first)
                prim.CreateVisibilityAttr().Set(geometry.Tokens.inherited, code)
        points = mesh.positions
        if points.dtype == numpy.float64:  # far from 0, where the points of USD, float32, are coarse
            points = (points - mesh.origin).astype(numpy.float32)
            if not prim.GetOrderedXformOps():
                prim.AddTranslateOp().Set(self._usd["Gf"].Vec3d(*mesh.origin.tolist()))
        prim.CreatePointsAttr().Set(vt.Vec3fArray.FromNumpy(points), code)
        box = numpy.stack([points.min(axis=0), points.max(axis=0)])
        prim.CreateExtentAttr().Set(vt.Vec3fArray.FromNumpy(box), code)
        faces = mesh.indices.tobytes()
        corners = vt.IntArray.FromNumpy(mesh.indices.astype(numpy.int32).ravel())
        self._set(prim.CreateFaceVertexIndicesAttr(), corners, code, faces)
        counts = vt.IntArray.FromNumpy(numpy.full(mesh.face_count, 3, numpy.int32))
        self._set(prim.CreateFaceVertexCountsAttr(), counts, code, mesh.face_count)
        if mesh.has_normals:
            prim.CreateNormalsAttr().Set(vt.Vec3fArray.FromNumpy(mesh.normals), code)
            prim.SetNormalsInterpolation(geometry.Tokens.vertex)
        variables = geometry.PrimvarsAPI(prim)
        if mesh.uvs is not None:
            st = variables.CreatePrimvar("st", types.TexCoord2fArray, geometry.Tokens.vertex)
            self._set(st.GetAttr(), vt.Vec2fArray.FromNumpy(upside_down(mesh.uvs)), code, mesh.uvs.tobytes())
        if mesh.colours is not None:
            colour = variables.CreatePrimvar("displayColor", types.Color3fArray, geometry.Tokens.vertex)
            light = vt.Vec3fArray.FromNumpy(linear_of_srgb(mesh.colours))
            self._set(colour.GetAttr(), light, code, mesh.colours.tobytes())

    def _add_camera(self, camera: Camera, code: float) -> None:
        path = f"/fvv/cameras/camera_{camera.id}"
        geometry, types = self._usd["UsdGeom"], self._usd["Sdf"].ValueTypeNames
        prim = geometry.Camera.Get(self._stage, path)
        if prim and not camera.moves:
            return
        new = not prim
        if new:
            geometry.Scope.Define(self._stage, "/fvv/cameras")
            prim = geometry.Camera.Define(self._stage, path)
            prim.CreateClippingRangeAttr().Set(self._usd["Gf"].Vec2f(0.01, 10000))
            if camera.name:
                prim.GetPrim().SetDisplayName(camera.name)
            prim.AddTransformOp()

        def give(attribute: Any, value: Any) -> None:
            attribute.Set(value, code) if camera.moves else attribute.Set(value)

        matrix = along_minus_z(camera)
        rows = self._usd["Gf"].Matrix4d(*matrix.T.ravel().tolist())
        give(prim.GetOrderedXformOps()[0], rows)
        k = camera.K
        # Tenths of metres: USD measures a camera's parts in tenths of the unit. 50 mm.
        focal = 0.5
        across, up = focal * camera.width / k[0, 0], focal * camera.height / k[1, 1]
        give(prim.CreateFocalLengthAttr(), focal)
        give(prim.CreateHorizontalApertureAttr(), across)
        give(prim.CreateVerticalApertureAttr(), up)
        give(prim.CreateHorizontalApertureOffsetAttr(), across * (0.5 - k[0, 2] / camera.width))
        give(prim.CreateVerticalApertureOffsetAttr(), up * (k[1, 2] / camera.height - 0.5))
        own = {
            "lens": (types.String, camera.lens),
            "distortion": (types.DoubleArray, camera.distortion.tolist()),
            "skew": (types.Double, float(k[0, 1])),
            "width": (types.Int, camera.width),
            "height": (types.Int, camera.height),
        }
        for name, (kind, value) in own.items():
            give(prim.GetPrim().CreateAttribute(f"fvv:{name}", kind), value)
