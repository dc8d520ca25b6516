#include "block/verdict/own_patches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace orient::block {
namespace {

PatchResult Used(std::int64_t id, double col_px, double row_px) {
  PatchResult patch;
  patch.id = id;
  patch.state = PatchState::kMatched;
  patch.sigma_px = {0.1, 0.1};
  patch.residual_px = {col_px, row_px};
  return patch;
}

PatchResult Rejected(std::int64_t id, Reason reason) {
  PatchResult patch = Used(id, 5, 5);
  patch.state = PatchState::kRejected;
  patch.findings = {{.reason = reason}};
  return patch;
}

TEST(OwnPatches, AreUsedInBothWithTheRmsOfACoordinateOrContradictTheBlock) {
  const OwnPatches own = OwnPatchesOf(
      {Used(1, 0.1, 0), Used(2, 0, 0.1), Used(3, 9, 9), Used(4, 0, 0)},
      {Rejected(3, Reason::kPatchContradictsBlock), Used(2, -0.5, 0), Used(1, 0.3, 0.4),
       Rejected(4, Reason::kPatchContradictsOthers), Used(5, 7, 7)});
  EXPECT_EQ(own.used, 2);
  EXPECT_EQ(own.rejected, 1);
  EXPECT_DOUBLE_EQ(own.alone_rms_px, 0.1 / std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(own.rms_px, 0.5 / std::sqrt(2.0));
}

TEST(OwnPatches, MisfitWhereTheyLieInTheTailOfThoseUsedAndAreNoGrossErrors) {
  const auto rejected = [](std::int64_t id, double col_px) {
    PatchResult patch = Rejected(id, Reason::kPatchContradictsBlock);
    patch.residual_px = {col_px, 0};
    return patch;
  };
  const OwnPatches own = OwnPatchesOf({Used(1, 0, 0), Used(2, 0, 0)},
                                      {Used(1, 0.2, 0), Used(2, 0, -0.2), rejected(3, 0.59),
                                       rejected(4, -0.59), rejected(5, 0.61)});
  EXPECT_EQ(own.rejected, 3);
  EXPECT_EQ(own.misfitting, 2);
}

TEST(OwnPatches, EdgesAndResidualsThatAreNoneDoNotCount) {
  PatchResult edge = Used(1, 4, 0), none = Used(2, std::numeric_limits<double>::quiet_NaN(), 0);
  edge.sigma_px = {20, 0.1};
  const OwnPatches own = OwnPatchesOf({edge, none, Used(3, 0, 0)}, {edge, none, Used(3, 1, 1)});
  EXPECT_EQ(own.used, 1);
  EXPECT_EQ(own.rms_px, 1);
}

TEST(OwnPatches, OfNoneAreNone) {
  const OwnPatches own = OwnPatchesOf({}, {});
  EXPECT_EQ(own.used, 0);
  EXPECT_EQ(own.rms_px, 0);
}

TEST(IsHeldOff, WherePatchesFitTwoAndAHalfTimesWorseThanAlone) {
  EXPECT_FALSE(IsHeldOff({100, 0, 0, 0.2, 0.49}));
  EXPECT_TRUE(IsHeldOff({100, 0, 0, 0.2, 0.51}));
}

TEST(IsHeldOff, OnlyByTwoTenthsOfAPixelOrMore) {
  EXPECT_FALSE(IsHeldOff({100, 0, 0, 0.05, 0.2}));
  EXPECT_TRUE(IsHeldOff({100, 0, 0, 0.05, 0.21}));
}

TEST(IsHeldOff, NeverToldByFewerThanThirtyPatches) {
  EXPECT_FALSE(IsHeldOff({29, 0, 0, 0.1, 2}));
  EXPECT_TRUE(IsHeldOff({30, 0, 0, 0.1, 2}));
}

}  // namespace
}  // namespace orient::block
