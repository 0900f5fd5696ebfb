"""Answers requests of ../PROTOCOL.md on stdin and stdout, one JSON object in a line. usage: python3 -m reference"""

import base64
import json
import pathlib
import sys

from .container import DATA
from .decoder import report

PARTS = ["check", "mesh", "camera", "visibility", "colours", "video", "sound", "environment"]


def hello():
    version = f"{DATA['format']['major']}.{DATA['format']['minor']}"
    return {"protocol": 1, "name": "reference", "version": version, "format": version, "parts": PARTS}


def decode(request):
    """The report of a stream that is given by its path or its bytes."""
    if "data" in request:
        data = base64.b64decode(request["data"])
    else:
        data = pathlib.Path(request["path"]).read_bytes()
    return {"id": request.get("id"), **report(data, bool(request.get("live")))}


def main():
    for line in sys.stdin:
        request = json.loads(line)
        if request["op"] == "quit":
            break
        answer = hello() if request["op"] == "hello" else decode(request)
        print(json.dumps(answer, separators=(",", ":")), flush=True)


if __name__ == "__main__":
    main()
