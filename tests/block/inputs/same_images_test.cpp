#include "block/inputs/same_images.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

TEST(SameImages, CopiesUnderOtherNamesAreNamedTogether) {
  const TemporaryFolder folder;
  const auto scan = [&](const char* name, const std::string& contents) {
    WriteFileAtomically(folder / name, contents);
    return std::string(folder / name);
  };
  const std::vector<std::string> paths = {scan("p1.tif", "one"), scan("p2.tif", "two"),
                                          scan("p1copy.tif", "one"), folder / "missing.tif"};
  const Findings findings = SameImages(paths);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings.front().reason, Reason::kSameImage);
  EXPECT_EQ(findings.front().where, "p1, p1copy");
  EXPECT_EQ(findings.front().value, 2);
  EXPECT_TRUE(SameImages({paths[0], paths[1]}).empty());
}

}  // namespace
}  // namespace orient::block
