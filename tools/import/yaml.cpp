// import/yaml.cpp: YAML by yaml-cpp's events, as far as cv::FileStorage writes it. Building on the events and
// not on YAML::Node shows the aliases, keeps line numbers, and finds keys that stand twice.
#include "capture/text_scan.h"
#include "import/tree.h"

#include <sstream>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

namespace fvv::import {

namespace {

class Builder : public YAML::EventHandler {
public:
  explicit Builder(const std::string &path_) : path(path_) {}

  void OnDocumentStart(const YAML::Mark &) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark &mark, YAML::anchor_t anchor) override { scalar(mark, "", anchor, ""); }
  void OnAlias(const YAML::Mark &mark, YAML::anchor_t) override {
    fail(mark, "expected no anchors and aliases, found an alias");
  }
  void OnScalar(const YAML::Mark &mark, const std::string &tag, YAML::anchor_t anchor,
                const std::string &value) override {
    scalar(mark, tag, anchor, value);
  }
  void OnSequenceStart(const YAML::Mark &mark, const std::string &tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, false);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark &mark, const std::string &tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, true);
  }
  void OnMapEnd() override { close(); }

  Node root;

private:
  struct Level {
    Node node;
    bool is_map, has_key;
    std::string key;
  };

  [[noreturn]] void fail(const YAML::Mark &mark, const std::string &what) const {
    fail_at(path, static_cast<uint64_t>(mark.line) + 1, what);
  }

  Node start(const YAML::Mark &mark, const std::string &tag, YAML::anchor_t anchor, bool is_scalar) {
    if (anchor) fail(mark, "expected no anchors and aliases, found an anchor");
    if (++count > max_nodes)
      fail(mark, "expected at most " + std::to_string(max_nodes) + " values, found more");
    Node node;
    node.line = static_cast<uint64_t>(mark.line) + 1;
    node.is_scalar = is_scalar;
    constexpr std::string_view prefix = "tag:yaml.org,2002:";
    if (tag.compare(0, prefix.size(), prefix) == 0)
      node.attributes.emplace_back("type_id", tag.substr(prefix.size()));
    return node;
  }
  void scalar(const YAML::Mark &mark, const std::string &tag, YAML::anchor_t anchor,
              const std::string &value) {
    Node node = start(mark, tag, anchor, true);
    if (levels.empty()) fail(mark, "expected keys and values, found " + capture::quote(value));
    Level &level = levels.back();
    if (level.is_map && !level.has_key) {
      level.key = value;
      level.has_key = true;
      return;
    }
    node.text = value;
    add(std::move(node));
  }
  void open(const YAML::Mark &mark, const std::string &tag, YAML::anchor_t anchor, bool is_map) {
    if (levels.size() == max_depth)
      fail(mark, "expected values at most " + std::to_string(max_depth) + " deep, found more");
    if (levels.empty() ? !is_map : levels.back().is_map && !levels.back().has_key)
      fail(mark, "expected a key, found a sequence or a map");
    levels.push_back({start(mark, tag, anchor, false), is_map, false, ""});
  }
  void close() {
    Node node = std::move(levels.back().node);
    levels.pop_back();
    if (levels.empty())
      root = std::move(node);
    else
      add(std::move(node));
  }
  void add(Node node) {
    Level &level = levels.back();
    if (level.is_map) node.name = std::move(level.key);
    level.has_key = false;
    level.node.children.push_back(std::move(node));
  }

  const std::string &path;
  std::vector<Level> levels;
  size_t count = 0;
};

} // namespace

Node parse_yaml(std::string_view bytes, const std::string &path) {
  std::string text(bytes);
  constexpr std::string_view quirk = "%YAML:1.0";
  if (text.compare(0, quirk.size(), quirk) == 0) text[quirk.size() - 4] = ' ';
  Builder builder(path);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder)) fail_at(path, 1, "expected keys and values, found nothing");
  } catch (const YAML::Exception &error) {
    fail_at(path, static_cast<uint64_t>(error.mark.line) + 1, "expected YAML, found: " + error.msg);
  }
  return std::move(builder.root);
}

} // namespace fvv::import
