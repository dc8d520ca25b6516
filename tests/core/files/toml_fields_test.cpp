#include "core/files/toml_fields.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

TEST(NearestWord, ATypoFindsItsKey) {
  const auto nearest = [](std::string_view word) {
    return NearestWord(word, {"principal_point_mm", "principal_distance_mm", "kind", "name"});
  };
  EXPECT_EQ(nearest("principal_ponit_mm"), "principal_point_mm");
  EXPECT_EQ(nearest("principle_distance_mm"), "principal_distance_mm");
  EXPECT_EQ(nearest("knd"), "kind");
  EXPECT_EQ(nearest("nme"), "name");
}

TEST(NearestWord, AnotherWordFindsNothing) {
  EXPECT_EQ(NearestWord("temperature", {"kind", "name"}), "");
  EXPECT_EQ(NearestWord("x", {}), "");
}

}  // namespace
}  // namespace orient
