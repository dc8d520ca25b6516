#include "core/base/environment_error.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string_view>
#include <system_error>

namespace orient {

bool IsOfEnvironment(int error) {
  constexpr std::array kErrors = {ENOSPC, EDQUOT, EIO,    EMFILE,   ENFILE,
                                  ENOMEM, EFBIG,  ESTALE, ETIMEDOUT};
  return std::find(kErrors.begin(), kErrors.end(), error) != kErrors.end();
}

void RethrowIfMachineFault() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    throw EnvironmentError("out of memory; use fewer --jobs");
  } catch (const EnvironmentError&) {
    throw;
  } catch (const std::system_error& error) {  // from files, folders, or starting a thread
    if (IsOfEnvironment(error.code().value()) || error.code().value() == EAGAIN)
      throw EnvironmentError(error.what());
  } catch (const std::exception& error) {
    // OpenCV throws an exception of its own when memory is short.
    if (std::string_view(error.what()).find("(-4:Insufficient memory)") == std::string_view::npos)
      return;
    throw EnvironmentError("out of memory; use fewer --jobs");
  } catch (...) {
  }
}

void ThrowIfOutOfResources() {
  constexpr std::size_t kModerate = std::size_t{64} << 20;
  void* const volatile memory = std::malloc(kModerate);  // or it would be optimised away
  std::free(memory);
  if (memory == nullptr) throw EnvironmentError("out of memory; use fewer --jobs");
  const int file = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (file < 0 && IsOfEnvironment(errno))
    throw EnvironmentError(std::string("no file can be opened: ") + std::strerror(errno));
  if (file >= 0) close(file);
}

}  // namespace orient
