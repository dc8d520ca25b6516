#include "tools/report/figures/mosaic_sources.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

const MosaicSources kThen = {{"a b 'east'", "1234, pixel 0.5 m"}, {"roll 7: 4711", "5678"}};

TEST(MosaicSources, TheTextSaysWhatTheOrthophotosWereMadeFrom) {
  EXPECT_EQ(TextOfSources(kThen), "1234, pixel 0.5 m: a b 'east'\n5678: roll 7: 4711");
  EXPECT_EQ(SourcesOf(TextOfSources(kThen)), kThen);
  EXPECT_TRUE(SourcesOf("").empty());
  EXPECT_TRUE(SourcesOf("no such text").empty());
}

TEST(MosaicSources, NothingHasChangedForTheSameOrthophotosOrForThoseThatDoNotTell) {
  EXPECT_FALSE(ChangesOf(kThen, kThen).Any());
  EXPECT_FALSE(ChangesOf(kThen, {{"a b 'east'", ""}, {"roll 7: 4711", ""}}).Any());
  EXPECT_FALSE(ChangesOf({}, kThen).Any());
}

TEST(MosaicSources, OtherOnesAndThoseThatAreGoneAndNewOnesAreNamed) {
  const MosaicChanges changes = ChangesOf(kThen, {{"a b 'east'", "4321"}, {"new", "8765"}});
  EXPECT_EQ(changes.others, (std::vector<std::string>{"a b 'east'", "roll 7: 4711"}));
  EXPECT_EQ(changes.lacking, std::vector<std::string>{"new"});
}

}  // namespace
}  // namespace orient
