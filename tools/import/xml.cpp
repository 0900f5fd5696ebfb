// import/xml.cpp: XML by libexpat. A document type declaration ends the reading before an entity could be
// declared, so that neither entities that grow nor files of this machine can come in.
#include "capture/text_scan.h"
#include "import/tree.h"

#include <exception>
#include <expat.h>
#include <memory>

namespace fvv::import {

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

} // namespace fvv::import
