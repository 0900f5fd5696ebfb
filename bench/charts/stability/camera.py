"""Where cameras break: lenses beyond their radius, half turns, the plane of the viewer, a day of time stamps, and captures whose
cameras are late, turned, too bright, badly cut out, or gone."""

import ctypes
import json
import math
import shutil
from fractions import Fraction

import mesh_only
import numpy as np
from PIL import Image

from .. import degradations, drawing, experiment, views

LENS_K1 = -0.4
RADII = (*np.linspace(0.1, 0.95, 10), 0.97, 0.99, 0.997, 1.003, 1.01, 1.05, 1.1, 1.2, 1.4, 1.6)  # of r_max
FROM_HALF_TURN = 90, 10, 1, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8  # degrees
HEIGHTS = 0.001, 0.002, 0.004, 0.007, 0.0085, 0.02, 0.1, 0.5  # of the eye above a floor, metres
NEAR_MM = 10  # fvvrender's near plane
RATE = Fraction(30000, 1001)
HOURS = 1 / 3600, 1 / 60, 0.25, 1, 3, 6, 12, 24
FRAMES, VIEWS, SHOWN = 4, (0, 15), (1, 3)
LATE = 0, 1, 2, 3, 4, 6, 8  # frames
TURNED_PX = 0, 0.1, 0.2, 0.5, 1, 2, 3
STOPS = 0, 0.25, 0.5, 1, 2
GROWN_PX = -6, -4, -2, -1, 0, 1, 2, 4, 6
LOST = 0, 1, 2, 3, 4, 5, 6, 7  # cameras


class Camera(ctypes.Structure):
    """fvv_camera of fvv/calibration.h."""

    _fields_ = [
        ("id", ctypes.c_uint16), ("lens", ctypes.c_uint8), ("flags", ctypes.c_uint8),
        ("width", ctypes.c_uint32), ("height", ctypes.c_uint32),
        ("fx", ctypes.c_double), ("fy", ctypes.c_double), ("cx", ctypes.c_double), ("cy", ctypes.c_double),
        ("skew", ctypes.c_double), ("distortion", ctypes.c_double * 8), ("r_max", ctypes.c_double),
        ("rotation", ctypes.c_double * 9), ("translation", ctypes.c_double * 3),
        ("name", ctypes.c_char_p), ("name_size", ctypes.c_size_t),
    ]  # fmt: skip


class Bits(ctypes.Structure):
    """fvv_calibration_bits."""

    _fields_ = [(name, ctypes.c_uint8) for name in ("rotation", "position", "pixel", "lens")]


class Bytes(ctypes.Structure):
    """fvv_bytes."""

    _fields_ = [
        ("data", ctypes.c_void_p), ("size", ctypes.c_size_t), ("capacity", ctypes.c_size_t),
        ("resize", ctypes.c_void_p), ("user", ctypes.c_void_p),
    ]  # fmt: skip


def library():
    found = ctypes.CDLL(str(experiment.TOOLS.parent / "libfvv/libfvv.so"))
    found.fvv_camera_r_max.restype = ctypes.c_double
    return found


def a_camera(focal=200.0, rotation=None, **more):
    unit = np.eye(3) if rotation is None else rotation
    camera = Camera(id=0, width=480, height=270, fx=focal, fy=focal, cx=240, cy=135, r_max=math.inf, **more)
    camera.rotation[:] = np.ravel(unit).tolist()
    return camera


def lens():
    """Rays at a distance from the axis, to their pixel and back: by libfvv, and by 20 rounds of a fixed point."""
    fvv = library()
    camera = a_camera(lens=1)
    camera.distortion[0] = LENS_K1
    camera.r_max = fvv.fvv_camera_r_max(ctypes.byref(camera))
    rows = []
    for part in RADII:
        radius = part * camera.r_max
        world, pixel, ray = (
            (ctypes.c_double * 3)(radius, 0, 1),
            (ctypes.c_double * 2)(),
            (ctypes.c_double * 3)(),
        )
        row = {
            "radius": part,
            "projected": bool(fvv.fvv_camera_project(ctypes.byref(camera), world, pixel, None)),
        }
        if row["projected"] and fvv.fvv_camera_unproject(ctypes.byref(camera), pixel, ray):
            row["error_px"] = camera.fx * abs(ray[0] - radius)
        bent = radius * (1 + LENS_K1 * radius**2)
        back = bent
        for _ in range(20):
            back = bent / (1 + LENS_K1 * back**2)
        row["plain_error_px"] = camera.fx * abs(back - radius)
        rows.append(row)
    return {"k1": LENS_K1, "r_max": camera.r_max, "rows": rows}


def rotation_vector(rotation):
    """The textbook logarithm of a rotation: angle by the trace, axis by the antisymmetric part."""
    angle = math.acos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))
    axis = np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    return angle * axis / (2 * math.sin(angle)) if angle else np.zeros(3)


def half_turn():
    """A camera that moves, turned by nearly 180 degrees, through CALB: how far a point 1,000 pixels off the axis moves."""
    fvv = library()
    focal, rows = 1000.0, []
    for short in FROM_HALF_TURN:
        rotation = degradations.rotation_by((1, 2, 3), math.radians(180 - short))
        camera = a_camera(focal, rotation, flags=1)
        bits, payload = Bits(), Bytes()
        fvv.fvv_calibration_choose(
            ctypes.byref(camera), 1, ctypes.c_double(0.001), ctypes.c_double(0.01), ctypes.byref(bits)
        )
        coder, decoder, found = ctypes.c_void_p(), ctypes.c_void_p(), Camera()
        for one in (coder, decoder):
            check(fvv.fvv_calibration_create(ctypes.byref(camera), 1, None, ctypes.byref(one)))
        check(
            fvv.fvv_calibration_encode(
                coder, ctypes.byref(bits), ctypes.byref(camera), 1, 1, ctypes.byref(payload), None
            )
        )
        check(
            fvv.fvv_calibration_decode(
                decoder, ctypes.c_void_p(payload.data), ctypes.c_size_t(payload.size), 1, None
            )
        )
        check(fvv.fvv_calibration_camera(decoder, 0, ctypes.byref(found)))
        ours = np.reshape(found.rotation[:], (3, 3))
        vector = rotation_vector(rotation)
        length = np.linalg.norm(vector)
        plain = degradations.rotation_by(vector, length) if length else np.eye(3)
        rows.append(
            {
                "degrees": short,
                "error_px": moved(ours, rotation, focal),
                "plain_error_px": moved(plain, rotation, focal),
            }
        )
        fvv.fvv_bytes_free(ctypes.byref(payload))
        for one in (coder, decoder):
            fvv.fvv_calibration_destroy(one)
    return {"rows": rows}


def check(status):
    if status:
        raise RuntimeError(f"libfvv returned {status}")


def moved(rotation, truth, focal):
    """The most that any point at 45 degrees or less from the axis can move, in pixels."""
    return focal * float(np.linalg.norm(rotation - truth, 2))


def near_plane():
    """A floor of two large triangles under a viewer who looks along it: pixels that are drawn wrongly."""
    folder = experiment.WORK / "captures/mesh-floor"
    shutil.rmtree(folder, ignore_errors=True)
    corners = np.array([(-2, 0, -2), (-2, 0, 2), (2, 0, 2), (2, 0, -2)])
    mesh_only.write_capture(folder, [(corners, np.array([(0, 1, 2), (0, 2, 3)]))])
    stream, mask = folder.with_suffix(".fvv"), folder.with_suffix(".png")
    experiment.run("fvvmux", folder, "-o", stream, "--force", "--keep-geometry", "--step", "1mm")
    columns, lines = np.meshgrid(np.arange(240) + 0.5 - 120, np.arange(180) + 0.5 - 90)
    rows = []
    for height in HEIGHTS:
        pose = f"0,{height},0,0,{height},-1"
        experiment.run("fvvrender", stream, "--no-pictures", "--pose", pose, "--focal", 120, "--size", "240x180", "-o", folder.with_suffix(".view.png"),
                "--mask", mask, "--force")  # fmt: skip
        drawn = np.asarray(Image.open(mask).convert("L")) > 128
        # Looking along -z: a pixel hits the floor at the distance at which its ray has sunk by the height.
        with np.errstate(divide="ignore"):
            ahead = np.where(lines > 0, height * 120 / lines, np.inf)
        truth = (ahead <= 2) & (np.abs(columns / 120 * ahead) <= 2)
        wrong = drawn != truth
        rows.append(
            {
                "metres": height,
                "wrong_percent": 100 * wrong.mean(),
                "nearest_mm": 1000 * float(ahead[truth].min()),
            }
        )
    return {"rows": rows}


def day():
    """A clip of a day with a few frames, the others left out: the times of its meshes against exact fractions."""
    numbers = [round(hours * 3600 * RATE) for hours in HOURS]
    chosen = [0, *numbers]
    folder = experiment.WORK / "captures/mesh-day"
    shutil.rmtree(folder, ignore_errors=True)
    mesh_only.write_capture(folder, [mesh_only.icosphere(1)])
    description = json.loads((folder / "capture.json").read_text())
    gaps = [[a + 1, b - 1] for a, b in zip(chosen, chosen[1:]) if b - a > 1]
    description["frames"] = {"first": 0, "count": chosen[-1] + 1, "left_out": gaps}
    description["frame_rate"] = f"{RATE.numerator}/{RATE.denominator}"
    description["meshes"]["pattern"] = "%d.ply"
    for number in chosen:
        shutil.copy(folder / "0000.ply", folder / f"{number}.ply")
    (folder / "capture.json").write_text(json.dumps(description))
    stream = folder.with_suffix(".fvv")
    experiment.run("fvvmux", folder, "-o", stream, "--force")
    info = experiment.answer("fvvinfo", "--chunks", stream)["files"][0]
    base = Fraction(*map(int, info["scene"]["time_base"]))
    times = [int(chunk["time"]) * base for chunk in info["chunks"] if chunk["type"] == "MESH"]
    rows = []
    for number, time in zip(numbers, times[1:]):
        exact = number / RATE
        rows.append({
            "hours": float(exact) / 3600,
            "fvv_ms": 1000 * float(abs(time - exact)),
            "double_ms": 1000 * float(abs(Fraction(int(time / base) * float(base)) - exact)),
            "float32_ms": 1000 * float(abs(Fraction(float(np.float32(float(exact)))) - exact)),
            "decimal_ms": 1000 * float(abs(number / Fraction("29.97") - exact)),
        })  # fmt: skip
    return {"rows": rows, "frames": chosen[-1] + 1}


def clip():
    """12 frames, of which the first four are used; the others are for cameras that are late."""
    return experiment.capture("small-tracked", "--rig", "small", "--meshes", "tracked", "--frames", 12)


def arc(some):
    """Some views of the arc that other experiments use, too."""
    found = views.Arc(12, range(31))
    found.views = tuple(some)
    return found


def view_of(capture, *options):
    """PSNR of a view between the cameras; the stream has the first frames of the clip alone."""
    made = experiment.packed(capture, "--quality", "42dB", *options)
    return views.measure(made.path, arc(VIEWS), frames=SHOWN) | {"bytes": made.summary["bytes"] / FRAMES}


def changed(name, change):
    def first_frames(description, folder):
        description["frames"]["count"] = FRAMES
        change(description, folder)

    return experiment.changed_capture(clip(), name, first_frames)


def late():
    """Every second camera shows a later moment than the others and the mesh."""
    rows = []
    for frames in LATE:

        def change(description, folder, frames=frames):
            for camera in description["cameras"][1::2]:
                for what in "pictures", "masks":
                    camera[what] = {"pattern": camera[what], "offset": frames}

        rows.append({"x": frames, "db": view_of(changed(f"late{frames}", change))["psnr_inside_db"]})
    return {"rows": rows}


def turned():
    """Every camera turned in a direction of its own."""
    rows = []
    for pixels in TURNED_PX:

        def change(description, folder, pixels=pixels):
            random = np.random.default_rng(1)
            for camera in description["cameras"]:
                camera["rotation"], camera["translation"] = degradations.turned(
                    camera, pixels, random.uniform(0, 2 * math.pi)
                )

        rows.append({"x": pixels, "db": view_of(changed(f"turned{pixels:g}", change))["psnr_inside_db"]})
    return {"rows": rows}


def exposed():
    rows = []
    for stops in STOPS:
        source = experiment.capture("exposed", "--rig", "small", "--frames", FRAMES, "--exposure", stops)
        row = {"x": stops}
        for way in "auto", "off":
            row[f"{way}_db"] = view_of(source, "--match-colours", way)["psnr_inside_db"]
        rows.append(row)
    return {"rows": rows}


def masked():
    rows = []
    for pixels in GROWN_PX:

        def change(description, folder, pixels=pixels):
            for camera in description["cameras"]:
                (folder / camera["name"]).mkdir()
                for frame in range(FRAMES):
                    mask = Image.open(camera["masks"] % frame).convert("L")
                    degradations.grown(mask, pixels).save(folder / camera["name"] / f"{frame:04d}.png")
                camera["masks"] = f"{camera['name']}/%04d.png"

        found = view_of(changed(f"masks{pixels}", change))
        rows.append({"x": pixels, "db": found["psnr_inside_db"], "bytes": found["bytes"]})
    return {"rows": rows}


def lost():
    """Cameras without calibration from the second frame on, the nearest to the view first, and the farthest first."""
    eye = np.mean([arc(VIEWS).place(view) for view in VIEWS], axis=0)
    rows = []
    for count in LOST:
        row = {"x": count}
        for way in "nearest", "farthest":

            def change(description, folder, count=count, way=way):
                cameras = sorted(
                    description["cameras"], key=lambda c: np.linalg.norm(degradations.centre_of(c) - eye)
                )
                for camera in (cameras if way == "nearest" else cameras[::-1])[:count]:
                    camera["per_frame"] = [{"frame": 0}] + [
                        {"frame": i, "calibrated": False} for i in range(1, FRAMES)
                    ]

            if count in (0, len(clip_cameras())) and way == "farthest":
                row["farthest_db"] = row["nearest_db"]
            else:
                row[f"{way}_db"] = view_of(changed(f"lost-{way}{count}", change))["psnr_inside_db"]
        rows.append(row)
    return {"rows": rows}


def clip_cameras():
    return json.loads((clip() / "capture.json").read_text())["cameras"]


def measure(quick):
    exact = {"lens": lens(), "half_turn": half_turn(), "day": day()}
    if quick:
        return exact
    return exact | {
        "near_plane": near_plane(),
        "late": late(),
        "turned": turned(),
        "exposed": exposed(),
        "masked": masked(),
        "lost": lost(),
    }


def draw(results, folder):
    figure, panels = drawing.sheet(3, 3, 3.6, 2.6)
    draw_lens(panels[0], results["lens"])
    draw_half_turn(panels[1], results["half_turn"]["rows"])
    draw_day(panels[2], results["day"]["rows"])
    draw_near(panels[3], results["near_plane"]["rows"])
    for axis, name, title, label in (
        (panels[4], "late", "Cameras out of step", "frames by which every second camera is late"),
        (panels[5], "turned", "Wrong calibration", "pixels by which cameras are turned"),
        (panels[7], "masked", "Wrong masks", "pixels that masks are too large (below 0: too small)"),
    ):
        rows = results[name]["rows"]
        drawing.line(axis, 0, [r["x"] for r in rows], [r["db"] for r in rows])
        axis.set(title=title, xlabel=label, ylabel="PSNR of a view, dB")
    draw_pair(
        panels[6],
        results["exposed"]["rows"],
        {"auto_db": "matched (default)", "off_db": "--match-colours off"},
    )
    panels[6].set(title="Unequal exposure", xlabel="stops either way", ylabel="PSNR of a view, dB")
    draw_pair(
        panels[8], results["lost"]["rows"], {"farthest_db": "farthest first", "nearest_db": "nearest first"}
    )
    panels[8].set(
        title="Cameras that drop out", xlabel="of 7 cameras without calibration", ylabel="PSNR of a view, dB"
    )
    drawing.words(
        panels[8], 7, results["lost"]["rows"][-1]["nearest_db"], "7: colours\nof vertices", (-62, 46)
    )
    drawing.save(figure, folder / "stability-camera.svg")


def draw_pair(axis, rows, names):
    for number, (name, label) in enumerate(names.items()):
        drawing.line(axis, number, [r["x"] for r in rows], [r[name] for r in rows], label)
    axis.legend(loc="lower left")


def draw_lens(axis, found):
    rows, floor = found["rows"], 1e-13
    drawing.line(
        axis,
        1,
        [r["radius"] for r in rows],
        [max(r["plain_error_px"], floor) for r in rows],
        "fixed point",
    )
    ours = [r for r in rows if "error_px" in r]
    drawing.line(axis, 0, [r["radius"] for r in ours], [max(r["error_px"], floor) for r in ours], "libfvv")
    axis.set_yscale("log")
    drawing.mark(axis, 1, "libfvv refuses", 0.4)
    axis.set(
        title=f"Lens beyond its radius (k1 = {found['k1']:g})",
        xlabel="distance from the axis, r_max",
        ylabel="pixel and back: error, px",
    )
    axis.legend(loc="upper left")


def draw_half_turn(axis, rows):
    x, floor = [r["degrees"] for r in rows], 1e-13
    drawing.line(axis, 1, x, [max(r["plain_error_px"], floor) for r in rows], "rotation vector, textbook")
    drawing.line(axis, 0, x, [max(r["error_px"], floor) for r in rows], "CALB")
    drawing.logarithmic(axis, "x")
    axis.set_xticks([1e-8, 1e-6, 1e-4, 1e-2, 1, 90], ["1e-8", "1e-6", "1e-4", "0.01", "1", "90"])
    axis.set_yscale("log")
    axis.set(
        title="Rotation near 180 degrees",
        xlabel="degrees that are missing to 180",
        ylabel="error, px (focal length 1,000)",
    )
    axis.legend(loc="lower left")


def draw_day(axis, rows):
    x, floor = [r["hours"] for r in rows], 1e-9
    names = {
        "decimal_ms": "29.97 per second",
        "float32_ms": "seconds in float32",
        "double_ms": "seconds in double",
        "fvv_ms": "fvv (exact: 0)",
    }
    for number, (name, label) in zip((1, 2, 3, 0), names.items()):
        drawing.line(axis, number, x, [max(r[name], floor) for r in rows], label)
    drawing.logarithmic(axis, "x", (0.001, 0.01, 0.1, 1, 24))
    axis.set_yscale("log")
    axis.set_ylim(floor / 4, 1e8)
    axis.set(title="Time over a day, 30000/1001 per second", xlabel="hours", ylabel="error, ms")
    axis.legend(loc="upper left", ncols=2, columnspacing=0.8)


def draw_near(axis, rows):
    drawing.line(axis, 0, [r["nearest_mm"] for r in rows], [r["wrong_percent"] for r in rows])
    drawing.logarithmic(axis, "x", (1, 10, 100, 1000))
    drawing.mark(axis, NEAR_MM, "nothing nearer is drawn", 0.9)
    axis.set(
        title="Near plane",
        xlabel="depth of the nearest point of a floor, mm",
        ylabel="pixels drawn wrongly, %",
    )
    axis.set_ylim(0, None)


def fall(rows, name="db", at=-1):
    return rows[0][name] - rows[at][name]


def text(results):
    lens_, turn, time = results["lens"]["rows"], results["half_turn"]["rows"], results["day"]["rows"]
    late_, turned_, exposed_, masked_, lost_ = (
        results[n]["rows"] for n in ("late", "turned", "exposed", "masked", "lost")
    )
    ours = max(r["error_px"] for r in lens_ if "error_px" in r)
    wrong = results["near_plane"]["rows"]
    near = max(r["wrong_percent"] for r in wrong if r["nearest_mm"] > NEAR_MM)
    best = next(r for r in masked_ if r["x"] == 0)
    cut, wide = masked_[0], masked_[-1]
    one = next(r for r in turned_ if r["x"] == 1)
    at = next(r for r in late_ if r["x"] == 1)
    lines = [
        "![Errors over what breaks cameras](stability-camera.svg)",
        "",
        f"**Arithmetic of cameras and time is exact or refuses, while a capture's own faults cost quality at once: one pixel of calibration "
        f"{turned_[0]['db'] - one['db']:.1f} dB, one frame out of step {late_[0]['db'] - at['db']:.1f} dB.**",
        "",
        f"- Lens: up to r_max the way to the pixel and back is off by at most {ours:.0e} px; beyond it `fvv_camera_project` refuses. A fixed point, the "
        f"usual way, is off by {max(r['plain_error_px'] for r in lens_ if r['radius'] < 1):.2g} px before r_max.",
        f"- Half turns: the error through CALB is at most {max(r['error_px'] for r in turn):.4f} px everywhere (a budget of 0.01 px); by the textbook's "
        f"rotation vector it grows to {max(r['plain_error_px'] for r in turn):.2g} px.",
        f"- Time: {time[-1]['fvv_ms']:g} ms after {time[-1]['hours']:.0f} h ({results['day']['frames']:,} frames, all but {len(time) + 1} left out); counted "
        f"at 29.97 per second it would be {time[-1]['decimal_ms']:.0f} ms, and in float32 seconds {time[-1]['float32_ms']:.1f} ms.",
        f"- Near plane: triangles that pass behind the viewer are drawn right, {near:.2f} % of pixels wrong, while the surface is more than {NEAR_MM} mm "
        f"away in depth; what is nearer is not drawn ({wrong[0]['wrong_percent']:.0f} % of pixels with the eye {1000 * wrong[0]['metres']:g} mm above a floor).",
        f"- Out of step: {late_[-1]['x']} frames cost {fall(late_):.1f} dB (exact mesh; a hull of such pictures would also lose surface).",
        f"- Calibration: {turned_[1]['x']} px cost {fall(turned_, at=1):.2f} dB, {turned_[-1]['x']} px {fall(turned_):.1f} dB.",
        f"- Exposure: {exposed_[-1]['x']} stops cost {fall(exposed_, 'auto_db'):.1f} dB with `--match-colours auto` and {fall(exposed_, 'off_db'):.1f} dB "
        "without it (the rig as a whole keeps its mean, which is not that of the truth).",
        f"- Masks: {-cut['x']} px too small cost {best['db'] - cut['db']:.1f} dB; {wide['x']} px too large {best['db'] - wide['db']:.1f} dB and "
        f"{100 * (wide['bytes'] / best['bytes'] - 1):.0f} % more bytes, so an uncertain mask should rather be too large.",
        f"- Drop-outs: without the nearest camera the view loses {fall(lost_, 'nearest_db', 1):.1f} dB, without the farthest "
        f"{fall(lost_, 'farthest_db', 1):.1f} dB; with none left it falls back to colours of vertices, {lost_[-1]['nearest_db']:.1f} dB.",
        "",
        f"Views: PSNR inside the silhouette of views that no camera filmed (arc, {' and '.join(map(str, VIEWS))} degrees), mean over frames {' and '.join(map(str, SHOWN))}, 7 cameras of 480x270, exact "
        "meshes, defaults.",
    ]
    return "\n".join(lines)


def headlines(results):
    return {
        "lens_error_px": max(max(r["error_px"] for r in results["lens"]["rows"] if "error_px" in r), 1e-9),
        "half_turn_error_px": max(r["error_px"] for r in results["half_turn"]["rows"]),
        "day_error_ms": max(r["fvv_ms"] for r in results["day"]["rows"]),
    }


def defaults(results):
    row = next(r for r in results["exposed"]["rows"] if r["x"] == 0.5)
    none = results["exposed"]["rows"][0]
    return [
        (
            "fvvmux --match-colours",
            "auto",
            f"{row['auto_db'] - row['off_db']:+.2f} dB against off where cameras differ by half a stop either way, "
            f"{none['auto_db'] - none['off_db']:+.2f} dB where they are alike",
        )
    ]


EXPERIMENTS = (
    experiment.Experiment(
        "stability-camera", "Where cameras break", measure, draw, text, headlines, defaults
    ),
)
