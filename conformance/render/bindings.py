"""Renders by the protocol of conformance/PROTOCOL.md with the Python package fvv, whose pixels are fvvrender's."""

import base64
import json
import sys

import fvv
import numpy


def render(request):
    view = request["view"]
    matrix = [[view["fx"], 0, view["cx"]], [0, view["fy"], view["cy"]], [0, 0, 1]]
    size = (view["width"], view["height"])
    camera = fvv.Camera(0, matrix, numpy.reshape(view["rotation"], (3, 3)), view["translation"], size=size)
    source = request["path"] if "path" in request else base64.b64decode(request["data"])
    with fvv.open(source) as clip:
        pixels = fvv.render(clip, request["frame"], camera, environment=False)
    opaque = numpy.full((*pixels.shape[:2], 1), 255, numpy.uint8)
    rgba = base64.b64encode(numpy.concatenate([pixels, opaque], axis=2).tobytes()).decode()
    return {"id": request["id"], "width": size[0], "height": size[1], "rgba": rgba}


def main():
    for line in sys.stdin:
        request = json.loads(line)
        if request["op"] == "quit":
            break
        if request["op"] == "hello":
            answer = {
                "protocol": 1,
                "name": "fvv.render",
                "version": fvv.__version__,
                "format": "0.2",
                "parts": ["render"],
            }
        elif request["op"] == "render":
            try:
                answer = render(request)
            except fvv.Error as error:
                answer = {"id": request["id"], "error": str(error)}
        else:
            answer = {"id": request.get("id"), "error": f"unknown op {request['op']}"}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
