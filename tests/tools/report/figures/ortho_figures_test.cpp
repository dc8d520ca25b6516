#include "tools/report/figures/ortho_figures.h"

#include <gtest/gtest.h>

#include "tests/support/shared_data.h"

namespace orient {
namespace {

TEST(OrthoFigures, AFolderWithoutOrthophotosHasNone) {
  const TemporaryFolder folder;
  EXPECT_FALSE(ReadOrthoFolder(folder.Path()));
  EXPECT_FALSE(ReadOrthoFolder(folder / "absent"));
}

TEST(OrthoFigures, AccuracyOfAllIsTheMedianAndTheWorstPlaceOfThoseThatHaveOne) {
  EXPECT_FALSE(AccuracyOfAll({}));
  std::vector<OrthoFigures> photos(4);
  photos[0].ce90 = GroundAccuracy{0.1, 0.2};
  photos[1].ce90 = GroundAccuracy{0.3, 0.9};
  photos[2].ce90 = GroundAccuracy{0.2, 0.4};
  const auto all = AccuracyOfAll(photos);
  EXPECT_EQ(all->median_m, 0.2);
  EXPECT_EQ(all->worst_m, 0.9);
}

}  // namespace
}  // namespace orient
