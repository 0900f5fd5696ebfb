// The command line of fvvrender: its options by what they are about, and the checks between them.
#pragma once

#include "fvvrender/render.h"

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace fvv::rendering {

class Command {
public:
  // Declares all options. app: refers to this object from then on.
  explicit Command(CLI::App &app);
  Command(const Command &) = delete;
  Command &operator=(const Command &) = delete;

  // After parsing. Throws Error (usage) for values that do not fit, or do not fit each other.
  Options options();

  bool as_json = false;

private:
  void add_picture(CLI::App &app);
  void add_viewpoint(CLI::App &app);
  void add_film(CLI::App &app);
  void add_texture(CLI::App &app);
  void add_layers(CLI::App &app);
  void add_running(CLI::App &app);
  void check_film() const;
  void take_film();

  Options given;
  std::optional<std::string> size, sources, excluded, frames, fps;
  std::vector<int> background = {0, 0, 0}, unseen = {128, 128, 128};
  std::vector<double> film_target;
  CLI::Option *frame_option = nullptr, *visible_by = nullptr, *unseen_option = nullptr;
  std::vector<CLI::Option *> of_films, of_orbits;
};

} // namespace fvv::rendering
