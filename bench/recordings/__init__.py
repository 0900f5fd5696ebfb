"""From the pictures of cameras to streams: how well each step of fvvcapture does, and how fast."""
