// Looking things up in a tree.

#include "scene/src/import/tree.h"
#include "fvv_scene/file_io.h"

#include <exception>
#include <expat.h>
#include <memory>
#include <sstream>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

namespace fvv::import {

const std::string *Node::find_attribute(const char *key) const {
  for (const auto &[name_, value] : attributes)
    if (name_ == key) return &value;
  return nullptr;
}

const std::string &Node::attribute(const std::string &path, const char *key) const {
  if (const std::string *value = find_attribute(key)) return *value;
  fail_at(path, line, "expected an attribute " + std::string(key) + " of <" + name + ">, found none");
}

const Node *Node::find(const std::string &path, const char *key) const {
  const Node *found = nullptr;
  for (const Node &node : children) {
    if (node.name != key) continue;
    if (found) fail_at(path, node.line, "expected one " + std::string(key) + ", found a second");
    found = &node;
  }
  return found;
}

const Node &Node::child(const std::string &path, const char *key) const {
  if (const Node *node = find(path, key)) return *node;
  fail_at(path, line,
          "expected " + std::string(key) + " in " + (name.empty() ? "the document" : name) + ", found none");
}

namespace {

class Reader {
public:
  explicit Reader(const std::string &path_) : path(path_), parser(XML_ParserCreate(nullptr)) {
    if (!parser) throw std::bad_alloc();
    XML_SetUserData(parser.get(), this);
    XML_SetElementHandler(
        parser.get(),
        [](void *user, const char *name, const char **attributes) {
          self(user).guard([&] { self(user).open(name, attributes); });
        },
        [](void *user, const char *) { self(user).guard([&] { self(user).close(); }); });
    XML_SetCharacterDataHandler(parser.get(), [](void *user, const char *text, int size) {
      self(user).guard([&] { self(user).levels.back().text.append(text, size_t(size)); });
    });
    XML_SetStartDoctypeDeclHandler(
        parser.get(), [](void *user, const char *, const char *, const char *, int) {
          self(user).guard([&] { self(user).fail("expected no document type (<!DOCTYPE>), found one"); });
        });
    XML_SetUnknownEncodingHandler(parser.get(), ascii, nullptr);
  }

  Node parse(std::string_view bytes) {
    const XML_Status status = XML_Parse(parser.get(), bytes.data(), static_cast<int>(bytes.size()), XML_TRUE);
    if (problem) std::rethrow_exception(problem);
    if (status != XML_STATUS_OK)
      fail(std::string("expected XML, found: ") + XML_ErrorString(XML_GetErrorCode(parser.get())));
    return std::move(root);
  }

private:
  static Reader &self(void *user) { return *static_cast<Reader *>(user); }
  uint64_t line() const { return XML_GetCurrentLineNumber(parser.get()); }
  [[noreturn]] void fail(const std::string &what) const { fail_at(path, line(), what); }

  // No exception may cross expat, which is C.
  template <class Step> void guard(const Step &step) {
    if (problem) return;
    try {
      step();
    } catch (...) {
      problem = std::current_exception();
      XML_StopParser(parser.get(), XML_FALSE);
    }
  }

  void open(const char *name, const char **attributes) {
    if (levels.size() == max_depth)
      fail("expected elements at most " + std::to_string(max_depth) + " deep, found <" + name + ">");
    Node node;
    node.name = name;
    node.line = line();
    for (; *attributes; attributes += 2, count++) node.attributes.emplace_back(attributes[0], attributes[1]);
    if (++count > max_nodes)
      fail("expected at most " + std::to_string(max_nodes) + " elements and attributes, found more");
    levels.push_back(std::move(node));
  }
  void close() {
    Node node = std::move(levels.back());
    levels.pop_back();
    (levels.empty() ? root : levels.back().children.emplace_back()) = std::move(node);
  }

  // Python writes encoding='ASCII' where the registered name, which expat knows, is US-ASCII.
  static int ascii(void *, const XML_Char *name, XML_Encoding *encoding) {
    if (std::string_view(name) != "ASCII") return XML_STATUS_ERROR;
    for (int byte = 0; byte < 256; byte++) encoding->map[byte] = byte < 128 ? byte : -1;
    encoding->data = nullptr;
    encoding->convert = nullptr;
    encoding->release = nullptr;
    return XML_STATUS_OK;
  }

  struct Free {
    void operator()(XML_Parser p) const { XML_ParserFree(p); }
  };
  const std::string &path;
  std::unique_ptr<std::remove_pointer_t<XML_Parser>, Free> parser;
  std::exception_ptr problem;
  std::vector<Node> levels;
  Node root;
  size_t count = 0;
};

} // namespace

Node parse_xml(std::string_view bytes, const std::string &path) {
  return Reader(path).parse(bytes);
}

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
    if (levels.empty()) fail(mark, "expected keys and values, found " + scene::quote(value));
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
