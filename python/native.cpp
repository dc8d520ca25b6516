#include "python/native.h"

#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "tools/commands/command.h"
#include "tools/commands/memory.h"

namespace py = pybind11;

PYBIND11_MODULE(_native, m) {
  m.doc() = "Orient's libraries; import `orient` instead.";
  m.attr("version") = orient::ProgramVersion();
  // As in the program's own main.
  orient::BoundBlockCache();
  py::register_exception<orient::InputError>(m, "InputError", PyExc_ValueError);
  py::register_exception<orient::UsageError>(m, "UsageError", PyExc_ValueError);
  py::register_exception<orient::EnvironmentError>(m, "MachineError", PyExc_OSError);
  orient::python::AddRuns(m);
  orient::python::AddResults(m);
  orient::python::AddGeometry(m);
}
