// Strictly checked JSON. Parses with nlohmann-json, rejects duplicate keys, and returns values whose errors
// name their JSON pointer (RFC 6901).
#pragma once

#include "fvv_scene/file_io.h"

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace fvv::scene {

// Error "name:LINE:COLUMN: not JSON: ..." for malformed text, columns in bytes from 1; "name: POINTER: ..."
// for a key that is repeated in an object.
nlohmann::json parse_strict_json(std::string_view bytes, const std::string &name);

// One value of a document and its place. Borrows the document and the name of its file.
class JsonValue {
public:
  JsonValue(const nlohmann::json &document, const std::string &file) : value(&document), name(&file) {}

  std::string place() const { return *name + (pointer.empty() ? "" : ": " + pointer); } // "name: POINTER"
  // Error "name: POINTER: what".
  [[noreturn]] void fail(const std::string &what) const;

  // Refuses every key that is not in the list, and names the nearest one that is.
  void allow_keys(std::initializer_list<const char *> keys) const;
  JsonValue at(const char *key) const; // fails when absent
  std::optional<JsonValue> find(const char *key) const;

  size_t size() const; // of an array
  JsonValue item(size_t index) const;
  JsonValue items(size_t count, size_t index) const; // the same of an array that must have count items

  std::vector<std::string> keys() const; // of an object, sorted

  bool is_text() const { return value->is_string(); }
  bool is_object() const { return value->is_object(); }
  bool is_number() const { return value->is_number(); }
  bool is_integer() const { return value->is_number_integer(); }
  std::string text() const; // without NUL
  bool boolean() const;
  double number() const;
  int64_t integer(int64_t least, int64_t most) const;

  std::string raw() const { return value->dump(); } // as JSON, to compare values
  // The value for an error message: "a string", "3.5", ...
  std::string found() const;

private:
  JsonValue(const JsonValue &parent, const nlohmann::json &child, const std::string &token)
      : value(&child), name(parent.name), pointer(parent.pointer + "/" + token) {}
  void expect(bool as_expected, const char *what) const;

  const nlohmann::json *value;
  const std::string *name;
  std::string pointer;
};

} // namespace fvv::scene
