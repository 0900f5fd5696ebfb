"""What cameras see: visibility weights of the stream against depth maps that a client makes, both compared with rays."""

import json

from . import drawing, experiment, system

FRAMES = 6
CASES = {
    "hull, whole": ("hull", ("--keep-geometry", "--step", "1mm")),
    "hull, default budget": ("hull", ()),
    "tracked, default budget": ("tracked", ()),
}
DEFAULT_BIAS = 0.2
MOST_OVER_BEST = 1.05  # times the error of the best bias


def measured(what, path):
    key = experiment.digest_of(experiment.program("fvvbench")), what, path
    return experiment.kept(
        "visibility", key, lambda: json.loads(experiment.run("fvvbench", what, path).output)
    )


def case(name):
    meshes, options = CASES[name]
    frames = f"0-{FRAMES - 1}"
    made = experiment.packed(system.clip(meshes), "--frames", frames, "--visibility", "weight", *options)
    weights = measured("visibility", made.path)
    found = made.summary["visibility"]
    return {
        "bytes_per_frame": found["bytes"] / FRAMES,
        "all_bytes_per_frame": made.summary["bytes"] / FRAMES,
        "error_percent": weights["error_percent"],
        "shown_wrongly_percent": weights["shown_wrongly_percent"],
        "hidden_wrongly_percent": weights["hidden_wrongly_percent"],
        "client_ms": weights["order_ms"] + weights["decode_ms"],
        "cameras": 7,
        "maps": measured("depth", made.path),
    }


def measure(quick):
    if quick:
        made = experiment.packed(system.clip("hull", system.QUICK_FRAMES))
        return measured("visibility", made.path) | {
            "bytes": made.summary["visibility"]["bytes"] / system.QUICK_FRAMES
        }
    return {"frames": FRAMES, "cases": {name: case(name) for name in CASES}}


def headlines(results):
    return {"bytes_per_frame": results["bytes"], "error_percent": results["error_percent"]}


def draw(results, folder):
    figure, panels = drawing.sheet(len(results["cases"]), 1, 3.7, 3.4)
    for axis, (name, found) in zip(panels, results["cases"].items()):
        for number, size in enumerate(sorted({r["size"] for r in found["maps"]}, reverse=True)):
            rows = [r for r in found["maps"] if r["size"] == size]
            drawing.line(axis, number, [r["bias"] for r in rows], [r["error_percent"] for r in rows],
                         f"depth map, {size:g} of the picture's size")  # fmt: skip
        axis.axhline(
            found["error_percent"],
            color=drawing.BLACK,
            linestyle="--",
            label=f"weights, {found['bytes_per_frame']:,.0f} bytes",
        )
        axis.axvline(
            DEFAULT_BIAS, color=drawing.BLACK, linestyle=":", linewidth=1.1, label="default tolerance"
        )
        axis.set_ylim(0, 4.2)
        axis.set_title(name[0].upper() + name[1:])
        axis.set_xlabel("tolerance of the depth map, pixels")
        axis.set_ylabel("places judged otherwise than by rays, %")
        axis.legend(loc="upper right", fontsize=7)
    drawing.save(figure, folder / "visibility.svg")


def map_of(found, size=1.0, bias=DEFAULT_BIAS):
    return next(r for r in found["maps"] if r["size"] == size and r["bias"] == bias)


def text(results):
    lines = [
        "| meshes | weights: bytes per frame | of the stream | error | time | depth maps: error | at half the size | time |"
    ]
    lines.append("|---|---|---|---|---|---|---|---|")
    for name, f in results["cases"].items():
        whole, half = map_of(f), map_of(f, 0.5)
        lines.append(
            f"| {name} | {f['bytes_per_frame']:,.0f} | {100 * f['bytes_per_frame'] / f['all_bytes_per_frame']:.1f} % | {f['error_percent']:.2f} % "
            f"| {f['client_ms']:.1f} ms | {whole['error_percent']:.2f} % | {half['error_percent']:.2f} % | {whole['map_ms'] * f['cameras']:.0f} ms |"
        )
    found = results["cases"]["hull, default budget"]
    table = "\n".join(lines)
    ratio = map_of(found)["map_ms"] * found["cameras"] / found["client_ms"]
    return f"""![Error of depth maps over their tolerance, and of visibility weights](visibility.svg)

**Visibility weights take {found['bytes_per_frame']:,.0f} bytes per frame, {100 * found['bytes_per_frame'] / found['all_bytes_per_frame']:.1f} % of a default stream of hulls, and spare a client
the depth maps, which cost {ratio:.0f} times the processor time; full-size depth maps err less ({map_of(found)['error_percent']:.2f} % against {found['error_percent']:.2f} %).**
Without weights (`--visibility none`) a client makes a depth map for each camera and frame. An error is a place of the surface that lies in a
camera's picture and faces it (cosine above 0.25), and is judged seen or hidden otherwise than by a ray. Per frame, {found['cameras']} cameras of 480x270:

{table}

Times are of one thread of a processor with the code of the reference renderer, three samples along the side of a pixel. On a graphics card depth maps cost
less, and draw calls besides. The format has no other kinds any more: bits of vertices and bits of faces erred more than weights
([docs/encoding/visibility.md](../../encoding/visibility.md#cost-and-accuracy) has their last figures)."""


def defaults(results):
    found = results["cases"]["hull, default budget"]
    best = min((r for r in found["maps"] if r["size"] == 1), key=lambda r: r["error_percent"])
    return [
        ("fvvmux --visibility", "auto: weights below a tenth of the pictures",
         f"{found['bytes_per_frame']:,.0f} bytes per frame, error {found['error_percent']:.2f} % (hull, default budget)"),
        ("fvvmux --texture-depth-bias", DEFAULT_BIAS,
         f"error {map_of(found)['error_percent']:.2f} %; least of those tried {best['error_percent']:.2f} % at {best['bias']:g}",
         map_of(found)["error_percent"] <= MOST_OVER_BEST * best["error_percent"]),
    ]  # fmt: skip


EXPERIMENTS = (
    experiment.Experiment(
        "visibility", "Visibility: weights or depth maps", measure, draw, text, headlines, defaults
    ),
)
