// A failure of the machine, not of the input: a full disk, no memory, too many open files, a device
// fault. It says nothing about any photo: it ends the run, finished results are kept, and the same
// command continues from them once the cause is removed. Exit code 4.
#pragma once

#include <stdexcept>
#include <string>

namespace orient {

class EnvironmentError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Whether the error of a system call (errno) is the machine's.
bool IsOfEnvironment(int error);

// For handlers that turn exceptions into a result: throws EnvironmentError for machine failures,
// including lack of memory, and returns for all other exceptions.
void RethrowIfMachineFault();

// After a library failed without saying why: throws EnvironmentError where there is no moderate
// amount of memory left, or no more files can be opened. Then the input is not to blame.
void ThrowIfOutOfResources();

}  // namespace orient
