/* fvv_media/error.h: the one exception type of fvv_media. */
#ifndef FVV_MEDIA_ERROR_H
#define FVV_MEDIA_ERROR_H

#include <stdexcept>
#include <string>

namespace fvv::media {

/* what() is one sentence: "path: what is wrong", or only what is wrong where no path is known. Every function
 * of fvv_media throws this and nothing else but std::bad_alloc. */
class Error : public std::runtime_error {
public:
  explicit Error(const std::string &text) : std::runtime_error(text) {}
  Error(const std::string &name, const std::string &text)
      : std::runtime_error(name.empty() ? text : name + ": " + text) {}
};

} // namespace fvv::media

#endif
