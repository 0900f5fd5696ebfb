// capture/video_check.h: one video of a capture, looked at before any work starts. Internal to check_files.
#pragma once

#include "capture/capture.h"

namespace fvv::capture {

// camera: whose the source is; NULL: the atlas', whose size is that of its pictures. kind: "pictures" or
// "masks". Adds to findings.
void check_video(const Capture &capture, const Camera *camera, const std::string &kind,
                 const PictureSource &source, const VideoProbe &probe, Findings &findings);

} // namespace fvv::capture
