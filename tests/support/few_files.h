// Limits how many files the process may open, as on a machine that is short of file descriptors.
#pragma once

#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

namespace orient {

// During its lifetime, `count` more files may be opened.
class FewFiles {
 public:
  explicit FewFiles(rlim_t count) {
    const int next = open("/dev/null", O_RDONLY);
    close(next);
    getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit few{static_cast<rlim_t>(next) + count, before_.rlim_max};
    setrlimit(RLIMIT_NOFILE, &few);
  }
  ~FewFiles() { setrlimit(RLIMIT_NOFILE, &before_); }
  FewFiles(const FewFiles&) = delete;
  FewFiles& operator=(const FewFiles&) = delete;

 private:
  rlimit before_{};
};

// UBSan opens a pipe to inspect a class that it has not seen before, and takes the object for
// damaged if it cannot: tests with FewFiles run only without sanitizers. The process is asked,
// because tests compiled without sanitizers may be linked with them.
inline bool UnderSanitizers() { return dlsym(RTLD_DEFAULT, "__asan_init") != nullptr; }

}  // namespace orient

#define ORIENT_REQUIRE_FEW_FILES() \
  if (UnderSanitizers()) GTEST_SKIP() << "UBSan itself needs files to be opened"
