#include "tools/commands/memory.h"

#include <malloc.h>

namespace orient {

void KeepReleasedMemory() {
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);  // the most that glibc takes
  mallopt(M_TRIM_THRESHOLD, 256 * kMegabyte);
}

}  // namespace orient
