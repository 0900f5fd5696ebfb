"""The generator of the conformance cases: streams written from spec/fvv.md and spec/chunks.json, without libfvv.

`writer` builds streams, whole or with one fault at a known place; `payloads`, `meshes`, `motion`, `weights` and `colours`
encode the content of chunks; the modules of `subjects` describe the cases; `case` writes and compares their files.
"""
