"""From streams of cameras to a stream of meshes while it is filmed: the command `fvvcapture live`."""
