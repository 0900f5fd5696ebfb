#include "capture/capture_fields.h"

#include "capture/text_scan.h"

#include <cmath>
#include <numeric>

namespace fvv::capture {

double finite(const JsonValue &value) {
  const double number = value.number();
  if (!std::isfinite(number)) value.fail("expected a finite number, found " + value.found());
  return number;
}

double positive(const JsonValue &value) {
  const double number = finite(value);
  if (!(number > 0)) value.fail("expected a number > 0, found " + value.found());
  return number;
}

std::optional<fvv_rational> parse_rational(std::string_view text) {
  int64_t numerator = 0, denominator = 1;
  const size_t slash = text.find('/');
  const auto digits = [](std::string_view part, int64_t &number) {
    return part.find_first_not_of("0123456789") == part.npos && parse_integer(part, number);
  };
  if (!digits(text.substr(0, slash), numerator) ||
      (slash != text.npos && !digits(text.substr(slash + 1), denominator)) || !denominator)
    return {};
  const int64_t divisor = std::gcd(numerator, denominator);
  if (numerator / divisor > UINT32_MAX || denominator / divisor > UINT32_MAX) return {};
  return fvv_rational{static_cast<uint32_t>(numerator / divisor),
                      static_cast<uint32_t>(denominator / divisor)};
}

fvv_rational read_rational(const JsonValue &value, int64_t least, const char *what) {
  if (value.is_integer()) return {static_cast<uint32_t>(value.integer(least, UINT32_MAX)), 1};
  const std::optional<fvv_rational> rational =
      value.is_text() ? parse_rational(value.text()) : std::optional<fvv_rational>();
  if (!rational || rational->numerator < least)
    value.fail(std::string("expected ") + what + ", found " + value.found());
  return *rational;
}

Pattern read_pattern(const JsonValue &value) {
  std::string what;
  const std::optional<Pattern> pattern = Pattern::parse(value.text(), &what);
  if (!pattern) value.fail(what);
  return *pattern;
}

Pattern read_pattern(const JsonValue &value, const Frames &frames) {
  const Pattern pattern = read_pattern(value);
  if (!pattern.is_numbered() && frames.count > 1)
    value.fail("expected %d or %0Nd for the frame number, because there are " + std::to_string(frames.count) +
               " frames, found " + value.found());
  return pattern;
}

Lattice read_lattice(const JsonValue &value) {
  value.allow_keys({"origin", "step"});
  Lattice lattice;
  lattice.step = positive(value.at("step"));
  const JsonValue origin = value.at("origin");
  for (size_t k = 0; k < 3; k++) {
    lattice.origin[k] = finite(origin.items(3, k));
    if (!std::isfinite(std::fabs(lattice.origin[k]) + lattice.step * FVV_LATTICE_MAX))
      value.fail("expected |origin| + step * 2^28 to be finite");
  }
  return lattice;
}

} // namespace fvv::capture
