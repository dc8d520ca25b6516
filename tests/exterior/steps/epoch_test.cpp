// Real epochs: patches cut from one orthophoto, sought in the orthophoto of another year and
// season. The two are registered to a pixel or two, so the truth is the identity.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "core/matching/correlation.h"
#include "core/matching/gradient_channels.h"
#include "core/matching/interest_points.h"
#include "exterior/steps/match.h"
#include "tests/support/shared_data.h"

namespace orient::exterior {
namespace {

constexpr int kPatches = 250;
constexpr double kRight_px = 2, kWrong_px = 4;
const Eigen::Vector2d kRadius(20, 20);

struct Counts {
  double patches = 0, found = 0, right = 0, wrong = 0;
  void Add(const Eigen::Vector2d& error) {
    ++found;
    right += error.norm() <= kRight_px ? 1 : 0;
    wrong += error.norm() > kWrong_px ? 1 : 0;
  }
  double Right() const { return right / patches; }
  double Wrong() const { return wrong / patches; }
};

// Two orthophotos of one place, patches cut from `from` and sought in `in`.
class Epochs {
 public:
  Epochs(const std::string& from, const std::string& in, int side)
      : from_(Raster::Open(from)), in_(Raster::Open(in)), side_(side) {
    const Image image = from_.ReadGrey().image;
    InterestOptions options;
    options.min_distance_px = 20;
    const double border = side / 2.0 + kRadius.x() + 2;
    std::vector<Eigen::Vector2d> all;
    for (const InterestPoint& point : FindInterestPoints(image, options)) {
      const Eigen::Vector2d pixel = point.pixel.array().floor() + 0.5;
      if ((pixel.array() > border).all() && pixel.x() < image.width - border &&
          pixel.y() < image.height - border)
        all.push_back(pixel);
    }
    for (std::size_t i = 0; i < kPatches; ++i)
      if (i * all.size() / kPatches < all.size()) places_.push_back(all[i * all.size() / kPatches]);
  }

  // Where `find` sees the patch, if it does.
  template <typename Find>
  Counts Count(const Find& find) const {
    const PhotoImage from(from_, false), in(in_, false);
    Counts counts;
    for (const Eigen::Vector2d& place : places_) {
      AlignedPatch patch;
      patch.image = from.Around(place, Eigen::Vector2d::Constant(side_ / 2.0), 1).image;
      patch.predicted_px = place;
      ++counts.patches;
      const std::optional<Eigen::Vector2d> found = find(patch, in);
      if (found) counts.Add(*found - place);
    }
    return counts;
  }

 private:
  Raster from_, in_;
  int side_;
  std::vector<Eigen::Vector2d> places_;
};

using Found = std::optional<Eigen::Vector2d>;

Found BestPlace(const AlignedPatch& patch, const PhotoImage& photo, bool gradients) {
  const ImageWindow window = photo.Around(patch.predicted_px, kRadius + patch.Centre(), 1);
  const Image scores = gradients
                           ? CorrelateChannels(ChannelsOf(patch.image), ChannelsOf(window.image))
                           : Correlate(patch.image, window.image);
  const auto peaks = FindPeaks(scores, 1, 2.5, -1);
  if (peaks.empty()) return std::nullopt;
  return Eigen::Vector2d(window.RasterFromImage(peaks[0].position + patch.Centre()));
}

Found Precisely(const AlignedPatch& patch, const PhotoImage& photo, bool gradients) {
  const PreciseSearch search(patch, photo, kRadius);
  PreciseMatch match = search.ByGrey({});
  if (!match.found && gradients) match = search.ByGradients();
  return match.found ? Found(match.pixel) : std::nullopt;
}

// The nearest of the five best candidates.
Found Candidate(const AlignedPatch& patch, const PhotoImage& photo, bool gradients) {
  CandidateOptions options;
  options.gradients = gradients;
  Found nearest;
  for (const auto& candidate : FindCandidates(patch, photo, kRadius, options))
    if (!nearest ||
        (candidate.pixel - patch.predicted_px).norm() < (*nearest - patch.predicted_px).norm())
      nearest = candidate.pixel;
  return nearest;
}

// Grey values against gradients, both ways through both places.
TEST(SlowEpoch, GradientsFindWhatGreyValuesDoNot) {
  ORIENT_REQUIRE_SHARED_DATA(data, "epoch");
  std::printf("%-10s %-7s %4s | best place  | among five  | accepted        wrongly\n", "place",
              "in", "px");
  std::printf("%-10s %-7s %4s | grey  grad  | grey  both  | grey  both    grey  both\n", "", "",
              "");
  for (const int side : {31, 61})
    for (const std::string place : {"L15_0004", "L34_0128"})
      for (const std::string from : {"a", "b"}) {
        const std::string in = from == "a" ? "b" : "a";
        const std::string stem = fmt::format("{}/{}_", data, place);
        const Epochs epochs(stem + from + ".jpg", stem + in + ".jpg", side);
        const auto count = [&](auto find, bool gradients) {
          return epochs.Count([&](const AlignedPatch& patch, const PhotoImage& photo) {
            return find(patch, photo, gradients);
          });
        };
        const Counts grey = count(BestPlace, false), gradients = count(BestPlace, true);
        const Counts few = count(Candidate, false), more = count(Candidate, true);
        const Counts old_match = count(Precisely, false), match = count(Precisely, true);
        std::printf("%-10s %s in %s %4d | %.2f  %.2f  | %.2f  %.2f  | %.2f  %.2f   %.3f  %.3f\n",
                    place.c_str(), from.c_str(), in.c_str(), side, grey.Right(), gradients.Right(),
                    few.Right(), more.Right(), old_match.Right(), match.Right(), old_match.Wrong(),
                    match.Wrong());
        EXPECT_GT(gradients.Right(), 1.3 * grey.Right());
        EXPECT_GT(match.Right(), (side > 40 ? 1.5 : 1.1) * old_match.Right());
        EXPECT_LT(match.Wrong(), side > 40 ? 0.015 : 0.035);
        EXPECT_GE(more.Right(), few.Right());
      }
}

}  // namespace
}  // namespace orient::exterior
