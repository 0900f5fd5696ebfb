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

// "25", "30000/1001" or 25, in lowest terms. least: of the numerator. what: for the message.
fvv_rational read_rational(const JsonValue &value, int64_t least, const char *what) {
  const auto refuse = [&] { value.fail(std::string("expected ") + what + ", found " + value.found()); };
  int64_t rate[2] = {0, 1};
  if (value.is_text()) {
    const std::string text = value.text();
    const size_t slash = text.find('/');
    const auto digits = [&](std::string_view part, int64_t &number) {
      return part.find_first_not_of("0123456789") == part.npos && parse_integer(part, number);
    };
    if (!digits(std::string_view(text).substr(0, slash), rate[0]) ||
        (slash != text.npos && !digits(std::string_view(text).substr(slash + 1), rate[1])))
      refuse();
  } else if (value.is_integer()) {
    rate[0] = value.integer(least, UINT32_MAX);
  } else {
    refuse();
  }
  if (rate[0] < least || !rate[1]) refuse();
  const int64_t divisor = std::gcd(rate[0], rate[1]);
  if (rate[0] / divisor > UINT32_MAX || rate[1] / divisor > UINT32_MAX) refuse();
  return {static_cast<uint32_t>(rate[0] / divisor), static_cast<uint32_t>(rate[1] / divisor)};
}

Pattern read_pattern(const JsonValue &value, const Frames &frames) {
  std::string what;
  const std::optional<Pattern> pattern = Pattern::parse(value.text(), &what);
  if (!pattern) value.fail(what);
  if (!pattern->is_numbered() && frames.count > 1)
    value.fail("expected %d or %0Nd for the frame number, because there are " + std::to_string(frames.count) +
               " frames, found " + value.found());
  return *pattern;
}

} // namespace fvv::capture
