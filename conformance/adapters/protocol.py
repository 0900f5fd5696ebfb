"""The line protocol of ../PROTOCOL.md for a decoder in Python."""

import base64
import json
import pathlib
import sys


def serve(hello, decode, questions=None, join=None):
    """hello: what the decoder says of itself. decode(bytes, live): a report; join(bytes): that of who joined late. questions: functions by operation, (bytes, request)
    to the answer to a question on one frame."""
    for line in sys.stdin:
        request = json.loads(line)
        if request["op"] == "quit":
            break
        try:
            if request["op"] == "hello":
                answer = {"protocol": 1, **hello}
            else:
                data = request.get("data")
                content = (
                    pathlib.Path(request["path"]).read_bytes() if data is None else base64.b64decode(data)
                )
                if question := (questions or {}).get(request["op"]):
                    answer = question(content, request)
                elif join and request.get("joined"):
                    answer = join(content)
                else:
                    answer = decode(content, bool(request.get("live")))
        except (KeyError, OSError, ValueError) as error:
            answer = {"error": f"{type(error).__name__}: {error}"}
        if "id" in request:
            answer["id"] = request["id"]
        print(json.dumps(answer), flush=True)
