// Objects that belong to the process that made them: with threads, and with locks that these may hold.
#pragma once

#include <memory>
#include <unistd.h>
#include <utility>

namespace fvv::python {

// A process that was forked has none of the threads, and nothing there releases the locks: it never destroys
// what it inherited.
template <class T, class... Arguments> std::shared_ptr<T> make_for_this_process(Arguments &&...arguments) {
  const pid_t process = getpid();
  return {new T(std::forward<Arguments>(arguments)...), [process](T *object) {
            if (getpid() == process) delete object;
          }};
}

} // namespace fvv::python
