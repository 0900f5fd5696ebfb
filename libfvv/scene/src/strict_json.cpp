// Strict parsing and typed access.

#include "fvv_scene/strict_json.h"
#include "fvv_scene/file_io.h"

#include <algorithm>
#include <numeric>

namespace fvv::scene {

namespace {

using nlohmann::json;

// Far more than any description needs; a file of brackets alone must not cost gigabytes.
constexpr size_t max_depth = 32;

std::string escaped(const std::string &key) {
  std::string out;
  for (const char c : key) {
    if (c == '~')
      out += "~0";
    else if (c == '/')
      out += "~1";
    else
      out += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  }
  return out;
}

// Builds the document. nlohmann-json's own parser uses the last of two equal keys, and loses the place of a
// number that overflows.
class Builder : public nlohmann::json_sax<json> {
public:
  Builder(std::string_view text, const std::string &file) : bytes(text), name(file) {}

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(int64_t value) override { return add(value); }
  bool number_unsigned(uint64_t value) override { return add(value); }
  bool number_float(double value, const std::string &) override { return add(value); }
  bool string(std::string &value) override { return add(std::move(value)); }
  bool binary(json::binary_t &value) override { return add(std::move(value)); }
  bool start_object(size_t) override { return add(json::object(), true); }
  bool end_object() override { return close(); }
  bool start_array(size_t) override { return add(json::array(), true); }
  bool end_array() override { return close(); }
  bool key(std::string &text) override {
    levels.back().key = text;
    if (levels.back().value->contains(text))
      throw Error(name + ": " + pointer() + ": the key is repeated in its object");
    return true;
  }
  bool parse_error(size_t position, const std::string &, const nlohmann::detail::exception &error) override {
    // The library's sentence without its own prefix and without the raw bytes that it echoes.
    std::string what = error.what();
    for (const char *prefix : {"] ", "parse error at "}) {
      const size_t at = what.find(prefix);
      if (at != std::string::npos) what.erase(0, at + std::char_traits<char>::length(prefix));
      if (at != std::string::npos && *prefix == 'p') what.erase(0, what.find(": ") + 2);
    }
    const size_t echo = what.find("; last read: "), expected = what.find("; expected ");
    if (echo != std::string::npos)
      what.erase(echo, expected != std::string::npos && expected > echo ? expected - echo : what.npos);
    const std::string_view before = bytes.substr(0, position ? position - 1 : 0);
    const size_t line_start = before.rfind('\n') + 1; // npos + 1 is 0: the first line
    throw Error(name + ":" + std::to_string(1 + std::count(before.begin(), before.end(), '\n')) + ":" +
                std::to_string(before.size() - line_start + 1) + ": not JSON: " + what);
  }

  json document;

private:
  struct Level {
    json *value;
    std::string key;
  };

  bool add(json value, bool open = false) {
    json *place = &document;
    if (!levels.empty()) {
      Level &level = levels.back();
      if (level.value->is_array()) level.value->push_back(nullptr);
      place = level.value->is_array() ? &level.value->back() : &(*level.value)[level.key];
    }
    *place = std::move(value);
    if (open) {
      if (levels.size() == max_depth)
        throw Error(name + ": " + pointer() + ": expected at most " + std::to_string(max_depth) +
                    " arrays and objects inside one another");
      levels.push_back({place, ""});
    }
    return true;
  }
  bool close() {
    levels.pop_back();
    return true;
  }
  std::string pointer() const {
    std::string out;
    for (const Level &level : levels)
      out += "/" + (level.value->is_array() ? std::to_string(level.value->size() - 1) : escaped(level.key));
    return out;
  }

  std::string_view bytes;
  const std::string &name;
  std::vector<Level> levels;
};

// Levenshtein's distance: insertions, deletions and replacements.
size_t distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t(0));
  for (size_t i = 0; i < a.size(); i++) {
    size_t diagonal = row[0]++;
    for (size_t j = 0; j < b.size(); j++) {
      const size_t replaced = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

} // namespace

json parse_strict_json(std::string_view bytes, const std::string &name) {
  Builder builder(bytes, name);
  json::sax_parse(bytes, &builder);
  return std::move(builder.document);
}

void JsonValue::fail(const std::string &what) const {
  throw Error(place() + ": " + what);
}

std::string JsonValue::found() const {
  if (value->is_null()) return "null";
  if (value->is_boolean()) return value->get<bool>() ? "true" : "false";
  if (value->is_number()) return value->dump();
  if (value->is_string()) return quote(value->get_ref<const std::string &>());
  return value->is_array() ? "an array" : "an object";
}

void JsonValue::expect(bool as_expected, const char *what) const {
  if (!as_expected) fail(std::string("expected ") + what + ", found " + found());
}

void JsonValue::allow_keys(std::initializer_list<const char *> keys) const {
  expect(value->is_object(), "an object");
  for (const auto &entry : value->items()) {
    const std::string &key = entry.key();
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    // A key as long as a file must not cost its square.
    const std::string_view start = std::string_view(key).substr(0, 40);
    const char *nearest = *std::min_element(keys.begin(), keys.end(), [&](const char *a, const char *b) {
      return distance(start, a) < distance(start, b);
    });
    JsonValue(*this, entry.value(), escaped(key.substr(0, 40)))
        .fail("unknown key, the nearest that is allowed here is " + quote(nearest));
  }
}

std::optional<JsonValue> JsonValue::find(const char *key) const {
  expect(value->is_object(), "an object");
  const auto place = value->find(key);
  if (place == value->end()) return std::nullopt;
  return JsonValue(*this, *place, escaped(key));
}

JsonValue JsonValue::at(const char *key) const {
  const std::optional<JsonValue> child = find(key);
  if (!child) fail("expected key " + quote(key) + ", found none");
  return *child;
}

std::vector<std::string> JsonValue::keys() const {
  expect(value->is_object(), "an object");
  std::vector<std::string> out;
  for (const auto &[key, _] : value->items()) out.push_back(key);
  return out;
}

size_t JsonValue::size() const {
  expect(value->is_array(), "an array");
  return value->size();
}

JsonValue JsonValue::item(size_t index) const {
  return JsonValue(*this, (*value)[index], std::to_string(index));
}

JsonValue JsonValue::items(size_t count, size_t index) const {
  if (size() != count)
    fail("expected " + std::to_string(count) + " items, found " + std::to_string(value->size()));
  return item(index);
}

std::string JsonValue::text() const {
  expect(value->is_string(), "a string");
  const std::string &text = value->get_ref<const std::string &>();
  if (text.find('\0') != std::string::npos) fail("expected text without the character U+0000");
  return text;
}

bool JsonValue::boolean() const {
  expect(value->is_boolean(), "true or false");
  return value->get<bool>();
}

double JsonValue::number() const {
  expect(value->is_number(), "a number");
  return value->get<double>();
}

int64_t JsonValue::integer(int64_t least, int64_t most) const {
  const std::string range = "an integer from " + std::to_string(least) + " to " + std::to_string(most);
  const bool fits = value->is_number_unsigned() ? value->get<uint64_t>() <= static_cast<uint64_t>(INT64_MAX)
                                                : value->is_number_integer();
  expect(fits && value->get<int64_t>() >= least && value->get<int64_t>() <= most, range.c_str());
  return value->get<int64_t>();
}

} // namespace fvv::scene
