"""How fast fvvmux packs captures, how often it reads their files, and how much memory it takes."""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import time
from fractions import Fraction

import av

DEMO_OPTIONS = "--scale", "0.75", "--tile-fill", "flat"  # as ./run demo packs its capture


class Muxing:
    """tool(name, *arguments) runs one of the tools; work: folder for captures and streams."""

    def __init__(self, fvvmux, tool, work):
        self.fvvmux, self.tool, self.work = fvvmux, tool, pathlib.Path(work)

    def packed(self, source, *options):
        """Packs a capture: the summary, the wall time in seconds and the peak of resident memory in MiB."""
        command = [self.fvvmux, source, "-o", self.work / "packed.fvv", "--force", "--json", *options]
        begin = time.perf_counter()
        with open(self.work / "packed.json", "w+") as out:
            child = subprocess.Popen([str(c) for c in command], stdout=out)
            _, status, usage = os.wait4(child.pid, 0)
            if os.waitstatus_to_exitcode(status) not in (0, 3):
                sys.exit(f"bench: fvvmux {source} failed")
            out.seek(0)
            return json.load(out), time.perf_counter() - begin, usage.ru_maxrss / 1024

    def generated(self, name, *options):
        """A folder with a capture of fvvsynth, made unless it is there."""
        folder = self.work / name
        if not (folder / "capture.json").exists():
            self.tool("fvvsynth", "-o", folder, "--force", *options)
        return folder

    def with_videos(self, source):
        """The same capture with an H.264 file of good quality for each camera's pictures, and the masks as they are."""
        folder = self.work / f"{source.name}_videos"
        if (folder / "capture.json").exists():
            return folder
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        description = json.loads((source / "capture.json").read_text())
        frames = description["frames"]["count"]
        description["meshes"]["pattern"] = str(source / description["meshes"]["pattern"])
        for camera in description["cameras"]:
            if "masks" in camera:
                camera["masks"] = str(source / camera["masks"])
            if "pictures" not in camera:
                continue
            film = folder / f"{camera['name']}.mp4"
            with av.open(str(film), "w") as out:
                stream = out.add_stream("libx264", rate=Fraction(description["frame_rate"]))
                stream.width, stream.height, stream.pix_fmt = camera["width"], camera["height"], "yuv420p"
                stream.options = {"crf": "16", "preset": "veryfast"}
                for i in range(frames):
                    with av.open(str(source / (camera["pictures"] % i))) as picture:
                        frame = next(picture.decode(video=0)).reformat(format="yuv420p")
                    frame.pts = i
                    frame.time_base = 1 / Fraction(description["frame_rate"])
                    out.mux(stream.encode(frame))
                out.mux(stream.encode())
            camera["pictures"] = {"video": film.name}
        (folder / "capture.json").write_text(json.dumps(description))
        return folder

    def rate(self, source, *options):
        """Frames a second of the whole run."""
        summary, seconds, _ = self.packed(source, *options)
        return summary["frames"] / seconds

    def speed(self, seed_shaped):
        """Frames a second of the whole fvvmux, quality search and start included.

        mesh_reads_per_frame: mesh files that were read, for each frame. picture_reads_per_frame: picture and mask files
        that were decoded, for each such file; 1 means each once.
        """
        runs = [self.packed(seed_shaped) for _ in range(3)]
        summary = runs[0][0]
        reads, files = summary["reads"], 2 * summary["video"]["cameras"] * summary["frames"]
        figures = {
            "mux.frames_per_s": summary["frames"] / sorted(seconds for _, seconds, _ in runs)[1],
            "mux.mesh_reads_per_frame": reads["meshes"] / summary["frames"],
            "mux.picture_reads_per_frame": (reads["pictures"] + reads["masks"]) / files,
        }
        films = self.with_videos(seed_shaped.parent)
        for name, source, preset in (
            ("live", films, "live"),
            ("live_png", seed_shaped, "live"),
            ("fast", films, "fast"),
            ("medium_video", films, "medium"),
        ):
            figures[f"mux.{name}_frames_per_s"] = self.rate(source, "--preset", preset)
        demo = self.generated("synth")
        films = self.with_videos(demo)
        for name, source, preset in (
            ("demo_png", demo, "medium"),
            ("demo_video", films, "medium"),
            ("demo_live_png", demo, "live"),
            ("demo_live_video", films, "live"),
        ):
            figures[f"mux.{name}_frames_per_s"] = self.rate(source, "--preset", preset, *DEMO_OPTIONS)
        return figures

    def memory(self):
        """Peak memory of fvvmux: it should not grow with the length of a capture. Takes some minutes."""
        small = "--rig", "small", "--cameras", 2, "--size", "64x48", "--meshes", "tracked"
        figures = {}
        for frames in (100, 1000, 3000):
            folder = self.generated(f"long{frames}", *small, "--frames", frames)
            figures[f"mux.peak_mib_{frames}_frames"] = self.packed(folder)[2]
        grown = figures["mux.peak_mib_3000_frames"] - figures["mux.peak_mib_1000_frames"]
        figures["mux.bytes_per_frame_of_memory"] = grown * 2**20 / 2000
        large = "--rig", "small", "--cameras", 20, "--size", "1920x1080", "--frames", 30
        figures["mux.peak_mib_20_hd"] = self.packed(self.generated("hd20", *large))[2]
        return figures
