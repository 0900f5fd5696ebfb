"""From cameras to captures: footage, keying, visual hulls, calibration. The command fvvcapture, or `python -m fvv_capture`.

    from fvv_capture.process import Request, process
    process(Request("videos", "room.json", "players.fvv", plates="empty_stage"))

Needs `pip install fvv[capture]`: OpenCV and SciPy.
"""
