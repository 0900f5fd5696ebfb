// fvvserve: files and live streams over HTTP and WebSocket. Argument parsing only.
#include "cli/cli.h"
#include "cli/help.h"
#include "fvvserve/server.h"

#include <CLI/CLI.hpp>

#include <cstdio>

using namespace fvv;

namespace {

constexpr const char *footer =
    "Serves until SIGINT or SIGTERM. The addresses are printed on standard output. For development and live\n"
    "contribution; docs/tools/fvvserve.md says what to put in front of the public, and what live clients "
    "receive.\n"
    "Exit code: 0 ended by a signal, 1 failed, 2 usage.";

struct Texts {
  std::vector<std::string> live, allow_origin;
  double request = 10, idle = 60, queue_mib = 8;
};

void add_options(CLI::App &app, serve::Options &options, Texts &texts) {
  app.add_option("--root", options.root, "folder to serve; hidden files and listings are not")
      ->type_name("FOLDER");
  app.add_option(
         "--open", options.open,
         "file that the demo site plays, which is then the root unless --root names another; its page is "
         "shown where there is a screen")
      ->type_name("FILE.fvv");
  app.add_option(
      "--live", texts.live,
      "NAME=FILE: a stream at /live/NAME. A file is played by its time stamps, from the moment when the "
      "first client comes; a FIFO, or - for standard input, is sent on as it comes");
  app.add_flag("--loop", options.loop, "play files again and again, as long as anyone listens");
  app.add_flag("--follow", options.follow, "files are still being written: send on what is added to them");
  app.add_flag("--pace", options.pace, "play pipes, too, not faster than their time stamps");
  app.add_option("--port", options.port, "0: the system chooses")->capture_default_str();
  app.add_option("--bind", options.bind, "address to listen on; 0.0.0.0 or ::, all")->capture_default_str();
  app.add_option(
      "--allow-origin", texts.allow_origin,
      "origin of pages elsewhere that may read files and live streams: https://example.org, or * for all");
  app.add_option("--allow-host", options.allow_host,
                 "name under which the server may be asked, besides localhost and addresses");
  app.add_option("--queue", texts.queue_mib, "MiB that wait for one live client at most")
      ->check(CLI::Range(0.0625, 1024.0))
      ->capture_default_str();
  app.add_option("--max-connections", options.connections, "at once; others get 503")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option("--request-timeout", texts.request, "seconds for a whole request, and between two")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  app.add_option(
         "--idle-timeout", texts.idle,
         "seconds after which a live client that answers no ping, or a download that takes no byte, is ended")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  app.add_flag("--verbose", options.verbose, "one line for each request on stderr");
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app{"Serve fvv files with ranges, and live streams by WebSocket."};
  serve::Options options;
  Texts texts;
  add_options(app, options, texts);
  app.footer(footer);
  cli::set_help(app, "fvvserve",
                {
                    "fvvserve --root site",
                    "fvvserve --live players=players.fvv --loop --port 8080",
                });
  try {
    app.parse(argc, argv);
    if (options.root.empty() && options.open.empty() && texts.live.empty())
      throw CLI::RequiredError("--root, --open or --live");
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvserve", [&] {
    for (const std::string &text : texts.live) options.live.push_back(serve::parse_live(text));
    for (const std::string &text : texts.allow_origin)
      options.allow_origin.push_back(serve::parse_origin(text));
    if (!options.open.empty()) {
      serve::check_stream(options.open);
      if (options.root.empty()) options.root = serve::find_site();
    }
    using Milliseconds = std::chrono::milliseconds;
    options.request = Milliseconds(int64_t(texts.request * 1000));
    options.idle = Milliseconds(int64_t(texts.idle * 1000));
    options.queue_bytes = size_t(texts.queue_mib * (1 << 20));
    serve::serve(options, [&](const std::string &address) {
      const std::string page = options.open.empty() ? "" : serve::page_of(address, options.open);
      if (!page.empty())
        std::printf("%s\n", page.c_str());
      else if (!options.root.empty())
        std::printf("http://%s/\n", address.c_str());
      for (const serve::LiveInput &input : options.live)
        std::printf("ws://%s/live/%s\n", address.c_str(), input.name.c_str());
      std::fflush(stdout);
      if (!page.empty()) serve::show_page(page);
    });
    return cli::done;
  });
}
