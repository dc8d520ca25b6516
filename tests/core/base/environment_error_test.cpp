#include "core/base/environment_error.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <new>
#include <string>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/few_files.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

template <typename Thrown>
bool IsRethrown(const Thrown& thrown) {
  try {
    try {
      throw thrown;
    } catch (...) {
      RethrowIfMachineFault();
    }
  } catch (const EnvironmentError&) {
    return true;
  }
  return false;
}

TEST(EnvironmentError, AFullDiskAndMemoryAreTheMachinesAMissingFolderIsNot) {
  EXPECT_TRUE(IsOfEnvironment(ENOSPC));
  EXPECT_TRUE(IsOfEnvironment(EMFILE));
  EXPECT_FALSE(IsOfEnvironment(ENOENT));
  EXPECT_FALSE(IsOfEnvironment(EACCES));
}

TEST(EnvironmentError, MemoryThatIsOutIsNoVerdictAndADamagedFileIsOne) {
  EXPECT_TRUE(IsRethrown(std::bad_alloc()));
  EXPECT_TRUE(IsRethrown(EnvironmentError("disk full")));
  EXPECT_FALSE(IsRethrown(InputError("damaged")));
  EXPECT_FALSE(IsRethrown(std::logic_error("a mistake of ours")));
}

TEST(EnvironmentError, AMachineThatOpensNoFileAnyMoreIsShort) {
  ORIENT_REQUIRE_FEW_FILES();
  ThrowIfOutOfResources();
  const FewFiles none(0);
  EXPECT_THROW(ThrowIfOutOfResources(), EnvironmentError);
}

// As on a full disk: no file may grow beyond the limit.
TEST(EnvironmentError, AFileThatTheDiskDoesNotHoldIsOneAndLeavesNothing) {
  const TemporaryFolder folder;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(WriteFileAtomically(folder / "a", std::string(5000, 'x')), EnvironmentError);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));
}

}  // namespace
}  // namespace orient
