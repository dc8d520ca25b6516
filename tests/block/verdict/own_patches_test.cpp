#include "block/verdict/own_patches.h"

#include <gtest/gtest.h>

#include <cmath>

namespace orient::block {
namespace {

PatchResult Used(double col_px, double row_px) {
  PatchResult patch;
  patch.state = PatchState::kMatched;
  patch.residual_px = {col_px, row_px};
  return patch;
}

PatchResult Rejected(Reason reason) {
  PatchResult patch = Used(5, 5);
  patch.state = PatchState::kRejected;
  patch.findings = {{.reason = reason}};
  return patch;
}

TEST(OwnPatches, AreUsedWithTheRmsOfACoordinateOrContradictTheBlock) {
  const OwnPatches own =
      OwnPatchesOf({Used(0.3, 0.4), Used(-0.5, 0), Rejected(Reason::kPatchContradictsBlock),
                    Rejected(Reason::kPatchContradictsOthers), PatchResult()});
  EXPECT_EQ(own.used, 2);
  EXPECT_EQ(own.contradicting, 1);
  EXPECT_DOUBLE_EQ(own.rms_px, 0.5 / std::sqrt(2.0));
}

TEST(OwnPatches, OfNoneAreNone) {
  const OwnPatches own = OwnPatchesOf({});
  EXPECT_EQ(own.used, 0);
  EXPECT_EQ(own.rms_px, 0);
}

TEST(IsHeldOff, WherePatchesFitTwoAndAHalfTimesWorseThanAlone) {
  EXPECT_FALSE(IsHeldOff({100, 0, 0.49}, 0.2));
  EXPECT_TRUE(IsHeldOff({100, 0, 0.51}, 0.2));
}

TEST(IsHeldOff, OnlyByTwoTenthsOfAPixelOrMore) {
  EXPECT_FALSE(IsHeldOff({100, 0, 0.2}, 0.05));
  EXPECT_TRUE(IsHeldOff({100, 0, 0.21}, 0.05));
}

TEST(IsHeldOff, NeverToldByFewerThanThirtyPatches) {
  EXPECT_FALSE(IsHeldOff({29, 0, 2}, 0.1));
  EXPECT_TRUE(IsHeldOff({30, 0, 2}, 0.1));
}

}  // namespace
}  // namespace orient::block
