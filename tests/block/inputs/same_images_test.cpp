#include "block/inputs/same_images.h"

#include <gtest/gtest.h>

namespace orient::block {
namespace {

BlockPhotoFile Photo(const std::string& name, const std::string& digest) {
  BlockPhotoFile photo;
  photo.name = name;
  photo.exterior.made_from["scan"] = digest;
  return photo;
}

TEST(SameImages, CopiesUnderOtherNamesAreNamedTogether) {
  const std::vector<BlockPhotoFile> photos = {Photo("p1", "one"),      Photo("p2", "two"),
                                              Photo("p1copy", "one"),  Photo("unread", ""),
                                              Photo("unread too", ""), BlockPhotoFile()};
  const Findings findings = SameImages(photos);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings.front().reason, Reason::kSameImage);
  EXPECT_EQ(findings.front().where, "p1, p1copy");
  EXPECT_EQ(findings.front().value, 2);
  EXPECT_TRUE(SameImages({photos[0], photos[1]}).empty());
}

}  // namespace
}  // namespace orient::block
