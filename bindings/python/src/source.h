// Where the bytes of a clip come from: a file, an object with the buffer protocol, or an object with read_at.
// And failures as Python raises them.
#pragma once

#include "fvv/types.h"
#include "fvv_cxx/input_file.h"

#include <exception>
#include <optional>
#include <pybind11/pybind11.h>
#include <string>

namespace fvv::python {

namespace py = pybind11;

// A diagnostic that becomes an exception of fvv/errors.py: which one follows from its status.
class Failure : public std::exception {
public:
  Failure(const fvv_diagnostic &the_diagnostic, std::string the_file);
  // With another line than the diagnostic's own.
  Failure(const fvv_diagnostic &the_diagnostic, std::string the_file, std::string the_line);
  // Without an issue number and a place.
  Failure(fvv_status status, const std::string &message, const std::string &file = "");
  const char *what() const noexcept override { return line.c_str(); }

  const fvv_diagnostic diagnostic;
  const std::string file, line; // line: as a user reads it
};

// Throws a Failure when status is an error.
void require(fvv_status status, const fvv_diagnostic &diagnostic, const std::string &file);

// Makes Failure and fvv::Error exceptions of fvv/errors.py.
void register_failures();

// "MESH"; None for 0.
py::object chunk_name(uint32_t type);

// What a reader accepts: fvv_limits and what decoders of video may take.
struct Limits {
  // Throws Failure for names that are unknown and numbers below 1.
  explicit Limits(const py::dict &given);
  fvv_limits core;
  uint64_t max_picture_memory = uint64_t(4) << 30; // bytes
};

class Source {
public:
  // object: str (a path), something with read_at(offset, size) and size, or the buffer protocol. Bytes of a
  // buffer are not copied.
  Source(const py::object &object, const std::string &name);
  ~Source(); // with the GIL
  Source(const Source &) = delete;
  Source &operator=(const Source &) = delete;

  const InputFile &file() const { return *opened; } // until close
  const std::string &name() const { return shown; }
  // With the GIL: releases the file, buffer or object. Nothing is read after it.
  void close();
  // With the GIL: raises what read_at raised last.
  void rethrow();

private:
  static fvv_status read_buffer(void *user, uint64_t offset, void *out, size_t size);
  static fvv_status read_object(void *user, uint64_t offset, void *out, size_t size);

  const std::string shown;
  Py_buffer buffer = {};
  py::object reader;
  std::optional<py::error_already_set> pending;
  std::optional<InputFile> opened;
};

} // namespace fvv::python
