// import/tree.cpp: looking things up in a tree.
#include "import/tree.h"

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

} // namespace fvv::import
