// The command line of fvvsynth: its options by what they are about, and the checks between them.
#pragma once

#include "fvvsynth/atlas.h"
#include "fvvsynth/capture_writer.h"
#include "fvvsynth/footage/footage.h"

#include <CLI/CLI.hpp>
#include <string>

namespace fvv::synth {

class Command {
public:
  // Declares all options. app: refers to this object from then on.
  explicit Command(CLI::App &app);
  Command(const Command &) = delete;
  Command &operator=(const Command &) = delete;

  // After parsing, once. Throws Error (usage) for values that do not fit, or do not fit each other.
  void settle();

  std::string output;
  bool force = false;
  Settings settings;
  Recording recording; // of a capture
  Shoot shoot;         // of footage, where settings.still

private:
  void add_scene(CLI::App &app);
  void add_rig(CLI::App &app);
  void add_files(CLI::App &app);
  void add_realism(CLI::App &app);
  void add_footage(CLI::App &app);
  void add_running(CLI::App &app);
  void settle_realism();
  void settle_files();
  void settle_rig();

  std::string size, scene_kind = "practice", rig = "studio", rate = "25", meshes = "tracked",
                    pictures = "png";
  bool realistic = false, atlas = false;
  uint32_t atlas_size = default_atlas_size;
  CLI::Option *cameras = nullptr, *atlas_side = nullptr, *hull_cells = nullptr, *noise = nullptr,
              *exposure = nullptr, *shutter = nullptr, *footage = nullptr;
};

} // namespace fvv::synth
