// fvvmux/geometry.h: the meshes of a capture as the stream gets them, decimated by the plan's budget. Knows
// the capture and which frames stand together in a group; knows no bytes of the stream, and nothing of
// lattice points but what the budget says of them.
#pragma once

#include "fvvmux/plan.h"

#include <deque>
#include <mutex>

namespace fvv::mux {

// Frames of a group that follow each other and have the same connectivity (connectivity.h) are a run, and
// have the same faces after decimation, in the order of the first one's vertices: they could not be coded as
// motion otherwise. All else is decimated frame by frame. What a frame becomes depends on the frames of its
// group alone, whatever is asked first.
class Geometry {
public:
  // plan: all but its tracks and this are chosen. tiling: of the cameras.
  Geometry(const Plan &plan, const Tiling &tiling);

  // Loads frame i (counted from 0). report may be NULL; decimation is filled when the choice is to decimate.
  // Several threads may call it. Throws capture::FileError.
  capture::Mesh load(size_t i, capture::MeshReport *report,
                     std::optional<decimate::Report> &decimation) const;

private:
  struct Stretch {
    size_t first; // frame
    decimate::Run run;
    std::vector<std::vector<uint32_t>> orders; // of each frame's vertices; empty: as those of the first
  };
  struct Group {
    std::once_flag known;
    std::vector<Stretch> runs;
    std::vector<size_t> run_of; // for each frame of the group; SIZE_MAX: none
  };
  void find_runs(Group &group, size_t first, size_t count) const;
  void add_run(Group &group, size_t group_first, size_t first,
               std::vector<std::vector<uint32_t>> orders) const;
  capture::Mesh source(size_t i, capture::MeshReport *report = nullptr) const;
  decimate::Footprint cameras(size_t i) const;

  const capture::Capture capture;
  const Tiling tiling;
  const DecimationChoice choice;
  const uint32_t group_size;
  const bool tracked, normals; // otherwise nobody looks for runs; reads normals
  mutable std::deque<Group> groups;
};

} // namespace fvv::mux
