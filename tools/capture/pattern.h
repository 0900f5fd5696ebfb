// capture/pattern.h: file names of a sequence, written as printf would: "cam0/%04d.png". Only %d, %0Nd and %%
// are understood; nothing is ever handed to printf, so a pattern from a stranger's file is harmless.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace fvv::capture {

class Pattern {
public:
  // Nothing when text is no pattern; *what is then the reason, a part of a sentence.
  static std::optional<Pattern> parse(const std::string &text, std::string *what);

  const std::string &text() const { return source; } // as it was written
  bool is_numbered() const { return numbered; }      // has a %d; otherwise it names one file
  std::string file(int64_t frame) const;             // frame >= 0
  // The frame whose file this is, if there is one: the inverse of file().
  std::optional<int64_t> frame(std::string_view file) const;

private:
  std::string source, prefix, suffix; // around the number, %% resolved
  bool numbered = false;
  unsigned width = 0; // digits at least
};

} // namespace fvv::capture
