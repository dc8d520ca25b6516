#include "core/files/inputs.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/files/results.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

TEST(WhatChanged, NamesWhatDiffersComesAndGoes) {
  const Inputs then = {{"camera", "a"}, {"dem", "b"}, {"scan", "c"}};
  EXPECT_TRUE(WhatChanged(then, then).empty());
  EXPECT_EQ(WhatChanged(then, {{"camera", "a"}, {"dem", "x"}, {"interior", "d"}}),
            (std::vector<std::string>{"dem", "interior", "scan"}));
  EXPECT_EQ(WhatChanged(then, {}).size(), 3u);
}

TEST(TextOfInputs, SpeaksAsUsersDo) {
  EXPECT_EQ(TextOfInputs({"camera", "dem", "scan"}), "camera file, DEM, scan");
  EXPECT_EQ(TextOfInputs({}), "");
}

TEST(ReadMadeFrom, IsWhatTheResultsSay) {
  const TemporaryFolder folder;
  InteriorResult interior;
  interior.photo = "p";
  interior.made_from = {{"camera", "a"}, {"options", "b"}, {"scan", "c"}};
  WriteInteriorResult(folder.Path(), interior);
  const std::string path = InteriorResultPath(folder.Path(), "p");
  EXPECT_EQ(ReadMadeFrom(path), interior.made_from);
  EXPECT_EQ(ReadInteriorResult(path).made_from, interior.made_from);

  ExteriorResult exterior;
  exterior.photo = "p";
  exterior.made_from = {{"approximation", "d"}, {"scan", "c"}};
  exterior.earth_k1 = -2.5e-9;
  exterior.asked_of_neighbours = Bounds{1, 2, 30.5, 1e6};
  WriteExteriorResult(folder.Path(), exterior);
  const ExteriorResult read = ReadExteriorResult(ExteriorResultPath(folder.Path(), "p"));
  EXPECT_EQ(read.made_from, exterior.made_from);
  EXPECT_EQ(read.earth_k1, exterior.earth_k1);
  ASSERT_TRUE(read.asked_of_neighbours);
  EXPECT_EQ(read.asked_of_neighbours->min_y, 2);
  EXPECT_EQ(read.asked_of_neighbours->max_x, 30.5);
}

TEST(ReadMadeFrom, IsEmptyOfWhatSaysNothing) {
  const TemporaryFolder folder;
  const std::string path = folder / "result.json";
  EXPECT_FALSE(ReadMadeFrom(path));
  for (const char* text : {"", "{\"photo\": ", "[]", "7", "{\"made_from\": \"0123\"}",
                           "{\"made_from\": {\"camera\": 7}}"}) {
    WriteFileAtomically(path, text);
    EXPECT_FALSE(ReadMadeFrom(path)) << text;
  }
  for (const char* text : {"{}", "{\"made_from\": null}"}) {
    WriteFileAtomically(path, text);
    EXPECT_EQ(ReadMadeFrom(path), Inputs()) << text;
  }
}

}  // namespace
}  // namespace orient
