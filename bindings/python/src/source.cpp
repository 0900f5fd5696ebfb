#include "source.h"

#include "fvv_cxx/stream_error.h"

#include <algorithm>
#include <cstring>

namespace fvv::python {

namespace {

fvv_diagnostic diagnostic_of(fvv_status status, const std::string &message) {
  fvv_diagnostic out = {};
  out.status = status;
  std::strncpy(out.message, message.c_str(), sizeof out.message - 1);
  return out;
}

std::string line_of(const fvv_diagnostic &diagnostic, const std::string &file) {
  char line[4096];
  fvv_diagnostic_format(&diagnostic, file.empty() ? nullptr : file.c_str(), line, sizeof line);
  return line;
}

const char *class_of(fvv_status status) {
  switch (status) {
  case FVV_ERROR_LIMIT:
    return "LimitError";
  case FVV_ERROR_UNSUPPORTED:
    return "UnsupportedError";
  case FVV_ERROR_DAMAGED:
  case FVV_ERROR_TRUNCATED:
  case FVV_ERROR_INVALID:
    return "DamagedError";
  case FVV_ERROR_ARGUMENT:
  case FVV_ERROR_STATE:
  case FVV_ERROR_INPUT:
    return "UsageError";
  default:
    return "Error";
  }
}

void raise(const Failure &failure) {
  const fvv_diagnostic &d = failure.diagnostic;
  if (d.status == FVV_ERROR_MEMORY) return PyErr_SetString(PyExc_MemoryError, failure.what());
  if (d.status == FVV_ERROR_IO) return PyErr_SetString(PyExc_OSError, failure.what());
  const py::object type = py::module_::import("fvv.errors").attr(class_of(d.status));
  const bool placed = d.chunk_type || d.issue;
  // Names of files need not be UTF-8.
  const auto text = [](const std::string &bytes) {
    return py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(bytes.data(), Py_ssize_t(bytes.size()), "replace"));
  };
  const py::object error =
      type(text(failure.line),
           py::arg("file") = failure.file.empty() ? py::object(py::none()) : text(failure.file),
           py::arg("chunk") = chunk_name(d.chunk_type),
           py::arg("offset") = placed ? py::object(py::int_(d.offset)) : py::object(py::none()),
           py::arg("issue") = d.issue ? py::object(py::int_(d.issue)) : py::object(py::none()));
  PyErr_SetObject(type.ptr(), error.ptr());
}

} // namespace

Failure::Failure(const fvv_diagnostic &the_diagnostic, std::string the_file)
    : diagnostic(the_diagnostic), file(std::move(the_file)), line(line_of(diagnostic, file)) {}

Failure::Failure(const fvv_diagnostic &the_diagnostic, std::string the_file, std::string the_line)
    : diagnostic(the_diagnostic), file(std::move(the_file)), line(std::move(the_line)) {}

Failure::Failure(fvv_status status, const std::string &message, const std::string &the_file)
    : diagnostic(diagnostic_of(status, message)), file(the_file),
      line(the_file.empty() ? message : the_file + ": " + message) {}

void require(fvv_status status, const fvv_diagnostic &diagnostic, const std::string &file) {
  if (status >= 0) return;
  if (diagnostic.status) throw Failure(diagnostic, file);
  throw Failure(status, fvv_status_text(status), file);
}

void register_failures() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Failure &failure) {
      raise(failure);
    } catch (const StreamError &error) {
      raise(Failure(error.diagnostic, "", error.what()));
    } catch (const Error &error) {
      raise(Failure(error.kind == Error::usage ? FVV_ERROR_ARGUMENT : FVV_ERROR_DAMAGED,
                    error.in(Spelling::python)));
    }
  });
}

py::object chunk_name(uint32_t type) {
  if (!type) return py::none();
  std::string name;
  for (int i = 0; i < 4; i++) {
    const char c = char(type >> 8 * i & 0xff);
    name += c >= 32 && c < 127 ? c : '?';
  }
  return py::str(name);
}

Limits::Limits(const py::dict &given) {
  fvv_limits_default(&core);
  for (const auto &[key, value] : given) {
    const auto name = py::str(key).cast<std::string>();
    const auto number = value.cast<uint64_t>();
    if (!number) throw Failure(FVV_ERROR_ARGUMENT, "limit " + name + ": expected 1 or more");
    const struct {
      const char *name;
      uint32_t *value;
    } narrow[] = {{"max_vertices", &core.max_vertices},         {"max_faces", &core.max_faces},
                  {"max_cameras", &core.max_cameras},           {"max_tracks", &core.max_tracks},
                  {"max_dimension", &core.max_dimension},       {"max_groups", &core.max_groups},
                  {"max_group_chunks", &core.max_group_chunks}, {"max_text", &core.max_text},
                  {"max_environment", &core.max_environment}};
    bool found = true;
    if (name == "max_payload") {
      core.max_payload = number;
    } else if (name == "max_picture_memory") {
      max_picture_memory = number;
    } else {
      found = false;
      for (const auto &one : narrow)
        if (name == one.name) {
          if (number > UINT32_MAX) throw Failure(FVV_ERROR_ARGUMENT, "limit " + name + ": above 4294967295");
          *one.value = uint32_t(number);
          found = true;
        }
    }
    if (!found) throw Failure(FVV_ERROR_ARGUMENT, "there is no limit " + name);
  }
}

Source::Source(const py::object &object, const std::string &name) : shown(name) {
  if (py::isinstance<py::str>(object)) {
    const py::bytes path = py::reinterpret_steal<py::bytes>(PyUnicode_EncodeFSDefault(object.ptr()));
    opened.emplace(std::string(path), name);
  } else if (py::hasattr(object, "read_at")) {
    reader = object;
    opened.emplace(fvv_input{read_object, this, object.attr("size").cast<uint64_t>()}, name);
  } else {
    if (PyObject_GetBuffer(object.ptr(), &buffer, PyBUF_SIMPLE)) throw py::error_already_set();
    opened.emplace(fvv_input{read_buffer, this, uint64_t(buffer.len)}, name);
  }
}

Source::~Source() {
  close();
}

void Source::close() {
  opened.reset();
  if (buffer.obj) PyBuffer_Release(&buffer);
  reader = py::object();
}

void Source::rethrow() {
  if (!pending) return;
  py::error_already_set error = std::move(*pending);
  pending.reset();
  throw error;
}

fvv_status Source::read_buffer(void *user, uint64_t offset, void *out, size_t size) {
  std::memcpy(out, static_cast<const char *>(static_cast<Source *>(user)->buffer.buf) + offset, size);
  return FVV_OK;
}

fvv_status Source::read_object(void *user, uint64_t offset, void *out, size_t size) {
  auto *source = static_cast<Source *>(user);
  const py::gil_scoped_acquire acquire;
  try {
    const py::object got = source->reader.attr("read_at")(offset, size);
    Py_buffer view = {};
    if (PyObject_GetBuffer(got.ptr(), &view, PyBUF_SIMPLE)) throw py::error_already_set();
    const auto length = size_t(view.len);
    if (length == size) std::memcpy(out, view.buf, size);
    PyBuffer_Release(&view);
    if (length == size) return FVV_OK;
    PyErr_Format(PyExc_OSError, "read_at(%llu, %zu) returned %zu bytes", (unsigned long long)offset, size,
                 length);
    throw py::error_already_set();
  } catch (py::error_already_set &error) {
    if (!source->pending) source->pending.emplace(std::move(error));
  }
  return FVV_ERROR_IO;
}

} // namespace fvv::python
