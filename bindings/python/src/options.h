// The options of fvv_mux in Python's words.
#pragma once

#include "fvv_cxx/error.h"
#include "fvv_mux/options.h"

#include <pybind11/pybind11.h>
#include <string>

namespace fvv::python {

// A message of the libraries with options named as Python names them.
std::string python_words(const std::string &message);

// Throws Failure with the message in Python's words. broken: what an Error of the kind failed means.
[[noreturn]] void refuse(const Error &error, fvv_status broken);

// given: texts by the names of the table. Throws Failure.
mux::Options options_of(const pybind11::dict &given);

void register_options(pybind11::module_ &module);

} // namespace fvv::python
