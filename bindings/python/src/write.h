// Writing: frames from arrays, and captures on disk, become streams.
#pragma once

#include "fvv_cxx/error.h"
#include "fvv_mux/options.h"

#include <pybind11/pybind11.h>
#include <string>

namespace fvv::python {

// A message of the libraries with options named as Python names them: "--max-error" becomes "budget".
std::string python_words(const std::string &message);

// Throws Failure with the message in Python's words. broken: what an Error of the kind failed means.
[[noreturn]] void refuse(const Error &error, fvv_status broken);

// given: texts by the long names of fvvmux. Throws Failure.
mux::Options options_of(const pybind11::dict &given);

void register_write(pybind11::module_ &module);

} // namespace fvv::python
