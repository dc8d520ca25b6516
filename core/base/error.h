// The two ways in which Orient refuses to go on. A normal "no answer" is neither: it is an empty
// std::optional or a status. A broken promise by the caller is std::invalid_argument.
#pragma once

#include <stdexcept>
#include <string>

namespace orient {

// A broken world: a missing file, a damaged raster, a table with a wrong line. The message is one
// sentence for the user that names the file, the value and what to do. Exit code 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A wrong command line. Exit code 1.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace orient
