#include "core/files/toml_fields.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

TEST(ParseTomlFile, AKeyOfThousandsOfPartsIsRefused) {
  const TemporaryFolder folder;
  std::string key = "a";
  for (int i = 0; i < 200000; ++i) key += ".a";
  WriteFileAtomically(folder / "deep.toml", "b = 1\n" + key + " = 1\n");
  ExpectError<InputError>([&] { ParseTomlFile(folder / "deep.toml"); },
                          {folder / "deep.toml", "line 2"});
  WriteFileAtomically(folder / "deep.toml", "c = '" + key + "'\na.b.c = 1\n[d.e]\n");
  EXPECT_EQ(ParseTomlFile(folder / "deep.toml").size(), 3u);
}

TEST(ParseTomlFile, DotsInCommentsAndTextsAreNoKeys) {
  const TemporaryFolder folder;
  const std::string dots(100, '.');
  WriteFileAtomically(folder / "a.toml", "# it's a rule " + dots + "\na = 1  # \"" + dots +
                                             "\nb = \"\\\"" + dots + "\"\n[c.d]\n");
  EXPECT_EQ(ParseTomlFile(folder / "a.toml").size(), 3u);
  WriteFileAtomically(folder / "b.toml",
                      "a = \"\"\"\n" + dots + "\n# \"\"\"\"\nb = '''" + dots + "'''\n");
  EXPECT_EQ(ParseTomlFile(folder / "b.toml").size(), 2u);
  std::string key = "b";
  for (int i = 0; i < 200000; ++i) key += ".c";
  WriteFileAtomically(folder / "c.toml", "a = {x = \"\"\"\n\"\"\", " + key + " = 1}\n");
  ExpectError<InputError>([&] { ParseTomlFile(folder / "c.toml"); }, {"line 2", "64 parts"});
}

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
