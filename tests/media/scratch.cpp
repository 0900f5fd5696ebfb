// The tests write their files into the current folder: a new one, which goes away with the run.
#define CATCH_CONFIG_EXTERNAL_INTERFACES // of Catch2 2
#include "fvv_catch.h"

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace {

#if __has_include(<catch2/catch_all.hpp>)
using Listener = Catch::EventListenerBase;
#else
using Listener = Catch::TestEventListenerBase;
#endif

class Scratch : public Listener {
public:
  using Listener::Listener;

  void testRunStarting(const Catch::TestRunInfo &) override {
    std::string name = (std::filesystem::temp_directory_path() / "fvv-media-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error(name + ": cannot be made");
    folder = name;
    std::filesystem::current_path(folder);
  }
  void testRunEnded(const Catch::TestRunStats &) override {
    std::filesystem::current_path(folder.parent_path());
    std::filesystem::remove_all(folder);
  }

private:
  std::filesystem::path folder;
};

} // namespace

CATCH_REGISTER_LISTENER(Scratch)
