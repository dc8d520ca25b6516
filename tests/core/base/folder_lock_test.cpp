#include "core/base/folder_lock.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <memory>

#include "core/base/error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

// Whether another process gets the lock.
bool OthersGetIt(const std::string& folder, FolderLock::Mode mode = FolderLock::Mode::kAlone) {
  const pid_t child = fork();
  if (child == 0) {
    try {
      const FolderLock lock(folder, "lock", mode);
      _exit(0);
    } catch (const InputError&) {
      _exit(1);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST(FolderLock, KeepsOthersOutWhileItLivesAndLeavesNothing) {
  const TemporaryFolder folder;
  {
    const FolderLock lock(folder / "", "lock");
    EXPECT_FALSE(OthersGetIt(folder / ""));
    EXPECT_THROW(FolderLock(folder / "", "lock"), InputError);
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "lock"));
  EXPECT_TRUE(OthersGetIt(folder / ""));
}

TEST(FolderLock, SharedKeepsOutOnlyThoseWhoWantItAlone) {
  const TemporaryFolder folder;
  {
    const FolderLock lock(folder / "", "lock", FolderLock::Mode::kShared);
    EXPECT_TRUE(OthersGetIt(folder / "", FolderLock::Mode::kShared));
    EXPECT_FALSE(OthersGetIt(folder / ""));
  }
  const FolderLock lock(folder / "", "lock");
  EXPECT_FALSE(OthersGetIt(folder / "", FolderLock::Mode::kShared));
}

TEST(FolderLock, OfAKilledProgramHoldsNobodyUp) {
  const TemporaryFolder folder;
  EXPECT_TRUE(OthersGetIt(folder / ""));  // ends without its destructor
  EXPECT_TRUE(std::filesystem::exists(folder / "lock"));
  const FolderLock lock(folder / "", "lock");
}

}  // namespace
}  // namespace orient
