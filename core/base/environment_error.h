// What the machine refused, not the input: a full disk, no memory, too many open files, a device
// that fails. It is no photo's verdict: it ends the run, what is done is kept, and the same command
// goes on when there is room again. Exit code 4.
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

// To be called in a handler that makes a verdict of exceptions: throws on what the machine refused,
// memory included, and returns for all others.
void RethrowOfEnvironment();

// After a library failed without saying why: throws EnvironmentError where there is no moderate
// amount of memory to be had, or no file can be opened any more. Then it says nothing of its input.
void ThrowIfMachineIsShort();

}  // namespace orient
