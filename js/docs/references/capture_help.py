"""Prints what fvvcapture, fvvcapture calibrate and fvvcapture live report with --help-json, as a list: python3 capture_help.py PACKAGE_FOLDER
Their options need neither numpy nor the extension module, which the packages around them import: here these are empty."""

import json
import pathlib
import sys
import types

folder = pathlib.Path(sys.argv[1])
for name, path in (("fvv", folder), ("fvv_capture", folder.parent / "fvv_capture")):
    sys.modules[name] = types.ModuleType(name)
    sys.modules[name].__path__ = [str(path)]

from fvv_capture.arguments import calibrate_parser, capture_parser, live_parser  # noqa: E402

print(json.dumps([parser("").as_json() for parser in (capture_parser, calibrate_parser, live_parser)]))
