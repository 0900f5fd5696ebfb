#include "options.h"

#include "fvv_mux/option_table.h"
#include "source.h"

#include <algorithm>
#include <thread>

namespace fvv::python {

namespace {

// What the package makes of the table: by identifier, in its order.
py::list rows() {
  py::list out;
  for (const mux::Option &option : mux::option_table()) {
    py::dict row;
    row["name"] = option.name;
    row["former"] = option.former;
    row["since"] = option.since;
    row["type"] = option.python;
    row["help"] = python_words(option.help);
    row["default"] = option.text(mux::Options());
    row["example"] = option.example;
    row["separator"] = std::string(1, option.separator);
    row["of_capture"] = option.of_capture;
    row["planned"] = option.is_planned;
    out.append(row);
  }
  return out;
}

} // namespace

std::string python_words(const std::string &message) {
  return spell(message, Spelling::python);
}

void refuse(const Error &error, fvv_status broken) {
  throw Failure(error.kind == Error::usage ? FVV_ERROR_ARGUMENT : broken, error.in(Spelling::python));
}

mux::Options options_of(const py::dict &given) {
  mux::Options options;
  options.threads = std::clamp(std::thread::hardware_concurrency(), 1u, 256u);
  try {
    for (const auto &[key, value] : given)
      mux::set_option(options, py::cast<std::string>(key), py::cast<std::string>(value));
    return mux::settled(options);
  } catch (const Error &error) {
    refuse(error, FVV_ERROR_ARGUMENT);
  }
}

void register_options(py::module_ &module) {
  module.def("option_table", &rows);
}

} // namespace fvv::python
