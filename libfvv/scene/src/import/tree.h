// XML and YAML documents as a tree of names and texts with line numbers, read defensively: no document type,
// no entities but XML's five and character references, no anchors and aliases, bounded size, depth and count.
// Parsing is libexpat's and yaml-cpp's; calibrations are read elsewhere.
#pragma once

#include "scene/src/import/camera.h"

namespace fvv::import {

struct Node {
  std::string name; // of the element or key; empty for an item of a sequence
  std::string text; // of an element, without its children's; of a scalar
  uint64_t line = 0;
  std::vector<std::pair<std::string, std::string>> attributes; // of an element; "type_id" for YAML's tags
  std::vector<Node> children;
  bool is_scalar = true; // YAML: neither map nor sequence

  const std::string *find_attribute(const char *key) const;
  // Error "PATH:LINE: ..." when it is missing.
  const std::string &attribute(const std::string &path, const char *key) const;
  // Error when there are several of that name; null when there is none.
  const Node *find(const std::string &path, const char *key) const;
  const Node &child(const std::string &path, const char *key) const; // Error when missing too
};

constexpr unsigned max_depth = 16;
constexpr size_t max_nodes = 200000; // a few tens of MiB for any input
constexpr uint64_t max_xml_size = uint64_t(64) << 20;
constexpr uint64_t max_yaml_size = uint64_t(4) << 20; // yaml-cpp reads a megabyte a second and less

// The root element. Error "PATH:LINE: ..." for everything that is not plain XML.
Node parse_xml(std::string_view bytes, const std::string &path);

// A document whose root is a map. "%YAML:1.0", with which OpenCV's files begin and which is not YAML, is read
// as "%YAML 1.0".
Node parse_yaml(std::string_view bytes, const std::string &path);

} // namespace fvv::import
