"""A decoder under test in Python, over the reference decoder: frames and meshes alone."""

import base64
import json
import pathlib
import sys

# Of your own decoder you need what replaces this: a function that returns meshes by time, or raises.
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from reference.decoder import report  # noqa: E402


def decode(content):
    found, frames = report(content), []
    for frame in found["frames"]:
        arrays = {name: value for name, value in frame["arrays"].items() if name.startswith("mesh/")}
        frames.append({"time": frame["time"], "arrays": arrays})
    return {"status": found["status"], "issues": [], "frames": frames}


for line in sys.stdin:
    request = json.loads(line)
    if request["op"] == "quit":
        break
    if request["op"] == "hello":
        answer = {"protocol": 1, "name": "example.py", "version": "1", "format": "0.2", "parts": ["mesh"]}
    else:
        is_path = "path" in request
        content = pathlib.Path(request["path"]).read_bytes() if is_path else base64.b64decode(request["data"])
        answer = {"id": request["id"], **decode(content)}
    print(json.dumps(answer), flush=True)
