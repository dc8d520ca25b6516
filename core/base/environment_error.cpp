#include "core/base/environment_error.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <new>

namespace orient {

bool IsOfEnvironment(int error) {
  constexpr std::array kErrors = {ENOSPC, EDQUOT, EIO, EMFILE, ENFILE, ENOMEM, EFBIG};
  return std::find(kErrors.begin(), kErrors.end(), error) != kErrors.end();
}

void RethrowOfEnvironment() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    throw EnvironmentError("out of memory; use fewer --jobs");
  } catch (const EnvironmentError&) {
    throw;
  } catch (...) {
  }
}

}  // namespace orient
