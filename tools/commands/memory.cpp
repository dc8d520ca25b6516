#include "tools/commands/memory.h"

#include <cpl_conv.h>
#include <gdal.h>
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>

namespace orient {

void KeepReleasedMemory() {
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);  // the most that glibc takes
  mallopt(M_TRIM_THRESHOLD, 256 * kMegabyte);
}

void BoundBlockCache(int megabytes) {
  const GIntBig most = GIntBig{megabytes} << 20;
  if (CPLGetConfigOption("GDAL_CACHEMAX", nullptr) == nullptr)
    GDALSetCacheMax64(std::min(GDALGetCacheMax64(), most));
}

void AllowManyFiles() {
  constexpr rlim_t kEnough = 65536;
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  const rlim_t most = std::min(limit.rlim_max, kEnough);
  if (limit.rlim_cur >= most) return;
  limit.rlim_cur = most;
  setrlimit(RLIMIT_NOFILE, &limit);  // or it stays as it is
}

}  // namespace orient
