// Nothing that the patches and the approximation say is true of the photo: no pose may be accepted.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>

#include "core/geometry/rotation.h"
#include "core/raster/resample.h"
#include "exterior/orient_photo.h"
#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

enum class Wrong { kOfElsewhere, kExchanged, kMirrored, kShifted };

const char* NameOf(Wrong wrong) {
  switch (wrong) {
    case Wrong::kOfElsewhere:
      return "OfElsewhere";
    case Wrong::kExchanged:
      return "Exchanged";
    case Wrong::kMirrored:
      return "Mirrored";
    case Wrong::kShifted:
      return "Shifted";
  }
  return "";
}

// From 25 to 169 patches, wrong in one way.
std::vector<patchdb::Patch> Patches(Wrong wrong, std::mt19937* random) {
  const TexturedPhoto& photo = PhotoOfHills();
  const int n = 2 + static_cast<int>((*random)() % 5);
  const Texture elsewhere(static_cast<unsigned>((*random)()), 6);
  std::vector<patchdb::Patch> patches =
      photo.Patches(wrong == Wrong::kOfElsewhere ? elsewhere : photo.Ground(), n, 300.0 / n);
  if (wrong == Wrong::kExchanged) {
    const std::vector<patchdb::Patch> right = patches;
    for (std::size_t i = 0; i < patches.size(); ++i)
      patches[i].chip = right[(i + 1 + (*random)() % (patches.size() - 1)) % patches.size()].chip;
  }
  if (wrong == Wrong::kMirrored)
    for (patchdb::Patch& patch : patches) patch.chip = Mirrored(std::move(patch.chip));
  return patches;
}

// Good to 10 m and 1 degree or to 30 m and 3 degrees, with kappa known or not; shifted ones are off
// by 4 to 8 sigma in two coordinates.
PhotoToOrient Approximation(Wrong wrong, bool kappa_unknown, std::mt19937* random) {
  std::normal_distribution<double> normal;
  const double scale = (*random)() % 2 == 0 ? 1 : 3;
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(10 * scale), Eigen::Vector3d::Constant(RadFromDeg(scale));
  Vector6d start = PhotoOfHills().View().pose.AsVector();
  for (int i = 0; i < 6; ++i) start[i] += sigma[i] * normal(*random);
  if (wrong == Wrong::kShifted)
    for (const int i : {0, 1}) {
      const double sigmas = 4 + 4 * std::uniform_real_distribution<double>()(*random);
      start[i] = PhotoOfHills().View().pose.AsVector()[i] +
                 ((*random)() % 2 == 0 ? 1 : -1) * sigmas * sigma[i];
    }
  if (kappa_unknown) sigma[5] = std::numbers::pi;
  PhotoToOrient photo = PhotoOfHills().ToOrient();
  photo.prior = {Pose::FromVector(start), sigma.cwiseAbs2().asDiagonal()};
  return photo;
}

// Where patches are right and the approximation alone is wrong, the pose may be right.
constexpr double kRight_px = 2;

// How many were ok that must not be, of these draws.
int CountFalse(Wrong wrong, unsigned first, unsigned last) {
  int ok = 0, given = 0, false_ok = 0;
  for (unsigned seed = first; seed <= last; ++seed) {
    std::mt19937 random(seed);
    const std::vector<patchdb::Patch> patches = Patches(wrong, &random);
    OrientPhotoOptions options;
    options.wide = seed % 10 == 0;
    const PhotoToOrient photo = Approximation(wrong, options.wide, &random);
    const ExteriorResult result = OrientPhoto(photo, PhotoOfHills().File(), patches, options);
    given += result.pose ? 1 : 0;
    if (result.status != Status::kOk) continue;
    ++ok;
    const double off_px = PhotoOfHills().WorstError(*result.pose, patches);
    std::printf("draw %u: ok with %zu patches, off by %.2f px\n", seed, patches.size(), off_px);
    false_ok += wrong != Wrong::kShifted || off_px > kRight_px ? 1 : 0;
  }
  std::printf("%s: of wrong starts %u to %u %d ok, %d weak\n", NameOf(wrong), first, last, ok,
              given - ok);
  return false_ok;
}

class WrongStarts : public testing::TestWithParam<Wrong> {};
class SlowWrongStarts : public testing::TestWithParam<Wrong> {};

TEST_P(WrongStarts, NoneOfThreeIsFalselyOk) { EXPECT_EQ(CountFalse(GetParam(), 1, 3), 0); }
// ORIENT_WRONG_STARTS=FIRST-LAST: other draws.
TEST_P(SlowWrongStarts, NoneOfTwoHundredAndFiftyIsFalselyOk) {
  unsigned first = 1, last = 250;
  const char* asked = std::getenv("ORIENT_WRONG_STARTS");
  if (asked != nullptr) {
    char beyond = 0;
    ASSERT_EQ(std::sscanf(asked, "%u-%u%c", &first, &last, &beyond), 2) << asked;
  }
  ASSERT_LE(first, last);
  ASSERT_LE(last, 1000000u);
  EXPECT_EQ(CountFalse(GetParam(), first, last), 0);
}

const auto kAll =
    testing::Values(Wrong::kOfElsewhere, Wrong::kExchanged, Wrong::kMirrored, Wrong::kShifted);
const auto kName = [](const auto& of) { return NameOf(of.param); };
INSTANTIATE_TEST_SUITE_P(Patches, WrongStarts, kAll, kName);
INSTANTIATE_TEST_SUITE_P(Patches, SlowWrongStarts, kAll, kName);

}  // namespace
}  // namespace orient::exterior
