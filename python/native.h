// Orient's libraries as Python's module orient._native. Arrays are NumPy's, of doubles; what is
// absent is NaN in arrays and None elsewhere; angles are radians, frames those of
// docs/conventions.md.
#pragma once

#include <pybind11/pybind11.h>

namespace orient::python {

// Each adds its part to the module.
void AddRuns(pybind11::module_& m);      // run(): the commands
void AddResults(pybind11::module_& m);   // result files and tables
void AddGeometry(pybind11::module_& m);  // a photo between scan and ground

}  // namespace orient::python
