"""Charts of a clip by matplotlib: bytes, key and delta frames, vertices and faces, and where the cameras are."""

from __future__ import annotations

import dataclasses
import io
import os
from typing import TYPE_CHECKING, Any

import numpy
from numpy.typing import NDArray

from ._core import Camera, Mesh
from .clip import Clip
from .comparison import Comparable, compare
from .errors import DamagedError, Error
from .records import Track

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[numpy.float64]

INK, FAINT, GREY, GRID, PAPER = "#222222", "#777777", "#9c9c9c", "#d8d8d2", "#fbfbf8"
#: By kind of track; colours of Okabe and Ito (2008), which people with colour-blindness can tell apart.
COLOURS = {
    "mesh": "#0060a0",
    "video": "#d98200",
    "calibration": "#c44e00",
    "visibility": "#00795c",
    "environment": "#777777",
    "data": "#222222",
    "audio": "#b0588c",
    "colours": "#4aa3d8",
}
STYLE = {
    "figure.facecolor": PAPER,
    "savefig.facecolor": PAPER,
    "axes.facecolor": PAPER,
    "axes.edgecolor": FAINT,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "font.size": 9,
    "svg.hashsalt": "fvv",
}
#: Of lines of rungs, in order.
DASHES = ("-", "--", ":", "-.")
#: More tracks than these are shown as one series for each kind.
MOST_SERIES = 12
#: Of each surface and frame; the rms distance needs no more.
ERROR_SAMPLES = 10000


@dataclasses.dataclass(frozen=True)
class Series:
    """What some tracks send, by frame."""

    name: str
    colour: Any
    rungs: frozenset[int]  # who reads one of these receives it
    bytes: NDArray[numpy.int64]  # (frames,) payload from this frame on until the next
    state: NDArray[numpy.uint8]  # (frames,) 0: nothing, 1: needs earlier frames, 2: decodes alone


def shade(colour: str, part: float) -> tuple[float, ...]:
    """A colour with a part of white."""
    rgb = numpy.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    return tuple(float(one) for one in rgb + part * (1 - rgb))


def times_of(clip: Clip) -> Floats:
    """When frames begin, (frames,), in seconds; that of a damaged frame lies evenly between its neighbours."""
    times = numpy.full(len(clip), numpy.nan)
    for frame in clip:
        if frame.intact:
            times[frame.index] = frame.time
    known = numpy.flatnonzero(~numpy.isnan(times))
    if not len(known):
        raise DamagedError(f"{clip.name}: no frame is whole", file=clip.name)
    return numpy.interp(numpy.arange(len(clip)), known, times[known])


def series_of(clip: Clip, times: Floats) -> list[Series]:
    """One for each track with chunks, or for each kind of track of the same rungs where there are many, in order of tracks."""
    chunks = clip.chunks()
    at = numpy.searchsorted(times, chunks["time"] * float(clip.time_base) + 1e-9, side="right") - 1
    at = at.clip(0, len(times) - 1)
    sent = [track for track in clip.tracks if (chunks["track"] == track.id).any()]
    grouped = len(sent) > MOST_SERIES
    names: dict[str, list[Track]] = {}
    for track in sent:
        name = f"{track.kind} {track.id}" + (f": {track.name}" if track.name not in ("", track.kind) else "")
        own = rungs_of(clip, track)
        some = f", rung {', '.join(map(str, sorted(own)))}" if len(own) < len(clip.rungs) else ""
        names.setdefault((f"all {track.kind} tracks" if grouped else name) + some, []).append(track)
    out: list[Series] = []
    for name, tracks in names.items():
        kind = tracks[0].kind
        alike = [other for other in names.values() if other[0].kind == kind]
        part = 0.65 * alike.index(tracks) / len(alike)
        chosen = numpy.isin(chunks["track"], [track.id for track in tracks])
        sizes = numpy.bincount(at[chosen], chunks["size"][chosen], len(times)).astype(numpy.int64)
        state = numpy.zeros(len(times), numpy.uint8)
        chosen &= chunks["type"] != b"TILE"  # layouts of groups, which need nothing
        numpy.maximum.at(state, at[chosen], 1 + chunks["key"][chosen].astype(numpy.uint8))
        rungs = rungs_of(clip, tracks[0])
        out.append(Series(name, shade(COLOURS.get(kind, FAINT), part), rungs, sizes, state))
    return out


def rungs_of(clip: Clip, track: Track) -> frozenset[int]:
    """The rungs with which a viewer receives a track: those that list it, or all where none does or the track has no alternatives."""
    every = frozenset(rung.number for rung in clip.rungs) or frozenset([clip.rung])
    listed = frozenset(rung.number for rung in clip.rungs if track.id in rung.tracks)
    return listed if track.alternate_group and listed else every


def borders_of(clip: Clip) -> Floats:
    """Where groups begin, in seconds, but for the first."""
    chunks = clip.chunks()
    _, first = numpy.unique(chunks["group"], return_index=True)
    begins = numpy.minimum.reduceat(chunks["time"], first) if len(first) else numpy.zeros(0)
    found: Floats = begins[1:] * float(clip.time_base)
    return found


def edges_of(times: Floats, clip: Clip) -> Floats:
    """Where frames begin and the last one ends, (frames + 1,), in seconds."""
    return numpy.append(times, max(clip.start + clip.duration, times[-1] + 1e-6))


def draw_bytes(axes: Axes, clip: Clip, edges: Floats, series: list[Series]) -> None:
    """Kilobytes of each frame, stacked by track of the rung that is read; a line for each rung, as a viewer receives one of them."""
    below = numpy.zeros(len(edges) - 1)
    most = 0.0
    for one in series:
        if clip.rung in one.rungs:
            above = below + one.bytes / 1000
            axes.stairs(
                above, edges, baseline=below, fill=True, color=one.colour, label=one.name, linewidth=0
            )
            below = above
    most = float(below.max())
    if len(clip.rungs) < 2:
        axes.set_title(f"Bytes of tracks: {rate_of(below, edges)} on average")
    else:
        for place, rung in enumerate(clip.rungs):
            total = sum(
                (one.bytes / 1000 for one in series if rung.number in one.rungs), numpy.zeros_like(below)
            )
            most = max(most, float(total.max()))
            axes.stairs(
                total, edges, baseline=None, color=INK, linewidth=1.3, linestyle=DASHES[place % len(DASHES)],
                label=f"rung {rung.number}: {rate_of(total, edges)}",
            )  # fmt: skip
        axes.set_title(f"Bytes of each rung (lines), and of the tracks of rung {clip.rung} (areas)")
    axes.set_ylabel("kB per frame")
    axes.set_ylim(0, max(most * 1.05, 1e-3))
    axes.legend(*reversed_legend(axes), loc="upper left", bbox_to_anchor=(1.005, 1), borderaxespad=0)


def rate_of(kilobytes: Floats, edges: Floats) -> str:
    """On average."""
    return f"{8e-3 * float(kilobytes.sum()) / (edges[-1] - edges[0]):.2f} Mbit/s"


def reversed_legend(axes: Axes) -> tuple[list[Any], list[str]]:
    """The legend of a stack, in the order in which it is seen."""
    handles, names = axes.get_legend_handles_labels()
    return handles[::-1], names[::-1]


def draw_keys(axes: Axes, edges: Floats, series: list[Series], borders: Floats) -> None:
    """Which frame of which track decodes alone; lines where groups begin."""
    from matplotlib.patches import Patch

    for row, one in enumerate(series):
        look = ((1, shade(_hex(one.colour), 0.55)), (2, one.colour))
        for state, colour in look:
            shown = numpy.where(one.state == state, 0.42, 0.0)
            axes.stairs(row + shown, edges, baseline=row - shown, fill=True, color=colour, linewidth=0)
    for border in borders:
        axes.axvline(border, color=INK, linewidth=0.8)
    axes.set_yticks(range(len(series)), [one.name for one in series])
    axes.set_ylim(len(series) - 0.5, -0.5)
    axes.grid(False)
    axes.set_title("Key frames (dark) and frames that need earlier ones (light); lines: groups")
    handles = [Patch(color=INK, label="key"), Patch(color=GREY, label="delta")]
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.005, 1), borderaxespad=0)


def _hex(colour: tuple[float, ...]) -> str:
    return "#" + "".join(f"{round(255 * one):02x}" for one in colour)


def draw_counts(axes: Axes, clip: Clip, edges: Floats) -> None:
    """Vertices and faces of all meshes of each frame; a gap where a frame is damaged."""
    vertices, faces = numpy.full((2, len(clip)), numpy.nan)
    for frame in clip:
        try:
            meshes = frame.meshes.values()
        except DamagedError:
            continue
        vertices[frame.index] = sum(mesh.vertex_count for mesh in meshes)
        faces[frame.index] = sum(mesh.face_count for mesh in meshes)
    for values, name, colour in ((faces, "faces", COLOURS["video"]), (vertices, "vertices", COLOURS["mesh"])):
        axes.stairs(values, edges, baseline=None, color=colour, label=name, linewidth=1.6)
    axes.set_ylim(bottom=0)
    axes.set_title("Vertices and faces")
    axes.set_ylabel("per frame")
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:,.0f}")
    axes.legend(loc="upper left", bbox_to_anchor=(1.005, 1), borderaxespad=0)


def draw_errors(axes: Axes, clip: Clip, edges: Floats, against: Comparable) -> None:
    """How far the surface of each frame is from that of a reference; a gap where one of them has no mesh."""
    found = compare(against, clip, samples=ERROR_SAMPLES)
    scale, unit = (1.0, "units of the reference") if found.unit == "unknown" else (1000.0, "mm")
    places = {clip[i].number: i for i in range(len(clip))}
    rms, most = numpy.full((2, len(clip)), numpy.nan)
    for pair in found.frames:
        if pair.b.frame in places:
            rms[places[pair.b.frame]] = scale * pair.distance.symmetric.rms
            most[places[pair.b.frame]] = scale * pair.distance.symmetric.max
    for values, name, colour in ((most, "largest", COLOURS["calibration"]), (rms, "rms", COLOURS["mesh"])):
        axes.stairs(values, edges, baseline=None, color=colour, label=name, linewidth=1.6)
    axes.set_ylim(bottom=0)
    axes.set_title(
        f"Distance to the surface of the reference: {scale * found.distance.symmetric.rms:.3g} {unit} rms"
    )
    axes.set_ylabel(unit)
    axes.legend(loc="upper left", bbox_to_anchor=(1.005, 1), borderaxespad=0)


def axes_of_world(up: str | None, cameras: list[Camera]) -> tuple[Floats, Floats, Floats, str]:
    """Unit vectors to the right, towards the viewer of a top view's lower edge, and up; and the name of the last. Where the
    stream states no up axis, that of the cameras' pictures, on average, is taken."""
    if up is not None:
        vertical = numpy.zeros(3)
        vertical["xyz".index(up[1])] = 1 if up[0] == "+" else -1
    else:
        mean = (
            -numpy.sum([camera.R[1] for camera in cameras], axis=0) if cameras else numpy.array([0.0, 1, 0])
        )
        vertical = numpy.zeros(3)
        axis = int(numpy.abs(mean).argmax())
        vertical[axis] = numpy.sign(mean[axis]) or 1
    right = numpy.zeros(3)
    right[1 if vertical[0] else 0] = 1
    return right, numpy.cross(right, vertical), vertical, axis_name(vertical)


def axis_name(direction: Floats) -> str:
    """ "x", or "-x" for the opposite direction."""
    axis = int(numpy.abs(direction).argmax())
    return ("-" if direction[axis] < 0 else "") + "xyz"[axis]


def draw_layout(axes: Axes, cameras: list[Camera], mesh: Mesh | None, flat: Floats, names: list[str]) -> None:
    """Cameras as frusta, and the mesh, orthographically. flat: (2, 3), the directions of the axes of the chart."""
    from matplotlib.collections import LineCollection, PolyCollection

    scene: Floats = numpy.zeros((0, 3))
    if mesh is not None and mesh.vertex_count:
        scene = mesh.positions.astype(numpy.float64)
        corners = (scene @ flat.T)[mesh.indices]
        fill = PolyCollection(list(corners), facecolors=COLOURS["mesh"], edgecolors=COLOURS["mesh"])
        fill.set(linewidth=0.3, rasterized=True)
        axes.add_collection(fill)
    centres: Floats = numpy.zeros((len(cameras), 3))
    for i, camera in enumerate(cameras):
        centres[i] = camera.centre
    middle = scene.mean(axis=0) if len(scene) else centres.mean(axis=0)
    away: Floats = numpy.sort(numpy.linalg.norm(centres - middle, axis=1))
    size = 0.18 * float(away[len(away) // 2]) if len(cameras) else 0.0
    lines: list[Floats] = []
    points = [scene, centres]
    for camera in cameras:
        pixels = numpy.array([[0, 0], [camera.width, 0], [camera.width, camera.height], [0, camera.height]])
        ends = camera.unproject(pixels, size)
        ends = ends[~numpy.isnan(ends).any(axis=1)]  # corners beyond the lens
        points.append(ends)
        ring = numpy.concatenate([ends, ends[:1]])
        lines.append(ring @ flat.T)
        lines += [numpy.stack([camera.centre, end]) @ flat.T for end in ends]
    axes.add_collection(LineCollection(lines, colors=COLOURS["video"], linewidths=0.9))
    drawn = numpy.concatenate(points) @ flat.T
    axes.plot(*(centres @ flat.T).T, "o", color=COLOURS["calibration"], markersize=3)
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    margin = 0.14 * float((high - low).max()) + 1e-6
    draw_names(axes, cameras, centres @ flat.T, middle @ flat.T, 0.7 * margin)
    axes.set_aspect("equal", adjustable="box", anchor="N")
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_xlabel(f"{names[0]} in m")
    axes.set_ylabel(f"{names[1]} in m")


def draw_names(axes: Axes, cameras: list[Camera], places: Floats, middle: Floats, away: float) -> None:
    """The names of all cameras, off their places by `away` metres, outward from the middle; with a line to the place where
    another name is there already and it is off by more."""
    taken: list[Floats] = []
    for camera, place in zip(cameras, places):
        outward = place - middle
        outward = outward / (numpy.linalg.norm(outward) or 1) if outward.any() else numpy.array([0.0, 1.0])
        free = (
            place + away * far * _turned(outward, turn)
            for far in (1.0, 1.7, 2.4, 3.1)
            for turn in (0, 30, -30, 60, -60, 90, -90, 120, -120, 150, -150, 180)
        )
        at = next((at for at in free if _is_free(at, taken, away)), place + away * outward)
        if numpy.linalg.norm(at - place) > 1.01 * away or (at - place) @ outward < 0.99 * away:
            axes.plot(*numpy.stack([place, at]).T, "-", color=GREY, linewidth=0.5, zorder=1)
        name = camera.name or str(camera.id)
        axes.text(at[0], at[1], name, ha="center", va="center", fontsize=7, color=INK)
        taken.append(at)


def _is_free(at: Floats, taken: list[Floats], away: float) -> bool:
    return all(bool((numpy.abs(at - other) > [2.2 * away, 0.9 * away]).any()) for other in taken)


def _turned(direction: Floats, degrees: float) -> Floats:
    c, s = numpy.cos(numpy.radians(degrees)), numpy.sin(numpy.radians(degrees))
    return numpy.array([[c, -s], [s, c]]) @ direction


def draw_layouts(top: Axes, side: Axes, clip: Clip) -> None:
    """The first frame that is whole, from above and from the side."""
    frame = next(frame for frame in clip if frame.intact)
    cameras = list(frame.cameras.values())
    try:
        mesh = frame.mesh
    except DamagedError:
        mesh = None
    if not cameras and mesh is None:
        for axes in (top, side):
            axes.set_axis_off()
            axes.text(0.5, 0.5, "no cameras and no mesh", ha="center", transform=axes.transAxes, color=FAINT)
        return
    right, down, up, up_name = axes_of_world(clip.up, cameras)
    draw_layout(top, cameras, mesh, numpy.stack([right, down]), [axis_name(right), axis_name(down)])
    top.invert_yaxis()
    draw_layout(side, cameras, mesh, numpy.stack([right, up]), [axis_name(right), up_name])
    guessed = "" if clip.up else ", guessed from the cameras"
    top.set_title(f"From above: {len(cameras)} cameras at {frame.time:.2f} s")
    side.set_title(f"From the side: {up_name} is up{guessed}")


def plot(clip: Clip, figure: Figure | None = None, *, against: Comparable | None = None) -> Figure:
    """A page of charts: bytes of each track over time, key and delta frames, vertices and faces, and the layout of the
    cameras with the mesh from above and from the side. Times are seconds of the clip, lengths metres.

    figure: an empty one to draw on, such as a window's; None: a new one, which pyplot does not know and which therefore needs
    no closing. against: what the clip was made from, a clip, a capture or meshes as `fvv.compare` takes them; the distance of the
    surfaces is drawn then. Decodes all meshes of the rung and no pictures. What is damaged is left out. `fvv.Error`: the clip has no frames.
    ImportError without matplotlib: `pip install fvv[plot]`.
    """
    try:
        import matplotlib
        import matplotlib.figure
    except ImportError as error:
        raise ImportError("charts need matplotlib: pip install fvv[plot]") from error
    if not len(clip):
        raise Error(f"{clip.name}: expected frames to plot, found none", file=clip.name)
    times = times_of(clip)
    edges = edges_of(times, clip)
    series = series_of(clip, times)
    with matplotlib.rc_context(STYLE):
        keys = 0.7 + 0.2 * len(series)
        figure = matplotlib.figure.Figure() if figure is None else figure
        figure.set_size_inches(11, (7.6 if against is None else 9.4) + keys)
        figure.set_layout_engine("constrained")
        figure.set_facecolor(PAPER)
        middle = [1.6] if against is None else [1.6, 1.6]
        grid = figure.add_gridspec(3 + len(middle), 2, height_ratios=[2.2, keys, *middle, 3.6])
        sizes = figure.add_subplot(grid[0, :])
        below = [figure.add_subplot(grid[row, :], sharex=sizes) for row in range(1, 2 + len(middle))]
        draw_bytes(sizes, clip, edges, series)
        draw_keys(below[0], edges, series, borders_of(clip))
        draw_counts(below[1], clip, edges)
        if against is not None:
            draw_errors(below[2], clip, edges, against)
        sizes.set_xlim(edges[0], edges[-1])
        below[-1].set_xlabel("time in s")
        draw_layouts(figure.add_subplot(grid[-1, 0]), figure.add_subplot(grid[-1, 1]), clip)
        figure.suptitle(
            f"{os.path.basename(clip.name)}: {len(clip)} frames, {clip.duration:.2f} s, {clip.size / 1e6:.2f} MB"
        )
    return figure


def save(figure: Figure, kind: str) -> bytes:
    """The file of a figure by `plot`: "png" (1430 pixels wide), "svg" or "pdf"; the same bytes for the same clip."""
    import matplotlib

    content = io.BytesIO()
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    with matplotlib.rc_context(STYLE):
        figure.savefig(content, format=kind, dpi=130, metadata=undated)
    return content.getvalue()
