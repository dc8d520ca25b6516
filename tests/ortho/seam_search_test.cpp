#include "ortho/seam_search.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace orient::ortho {
namespace {

using Grey = std::function<double(double, double)>;  // of a place on the ground, metres

constexpr int kHalf = 100;  // of a photo, cells
constexpr double kCell_m = 2;

// A ground seen from `nadir`; `grey` as this photo shows it.
class TwoPhotos {
 public:
  void Add(const std::string& name, const Eigen::Vector2d& nadir, const Grey& grey) {
    const double half = kHalf * kCell_m;
    PhotoCells cells;
    cells.grid = MapGrid::Around(
        {nadir.x() - half, nadir.y() - half, nadir.x() + half, nadir.y() + half}, kCell_m);
    Image image(cells.grid.width, cells.grid.height);
    for (int row = 0; row < image.height; ++row)
      for (int col = 0; col < image.width; ++col) {
        const Eigen::Vector2d at = cells.grid.GroundFromPixel(col + 0.5, row + 0.5);
        image.At(col, row) = static_cast<float>(grey(at.x(), at.y()));
      }
    cells.bands = {image};
    cells_.push_back(cells);
    photos_.push_back({name, nadir, {}});
  }

  // Each place of `bounds` by the photo that shows it; "" is nobody.
  std::string At(const Eigen::Vector2d& place) const {
    const Seamlines seamlines = SeamlinesOfLeastDifference(photos_, cells_);
    return At(seamlines, place);
  }
  static std::string At(const Seamlines& seamlines, const Eigen::Vector2d& place) {
    const MapGrid pixel =
        MapGrid::Around({place.x() - 0.1, place.y() - 0.1, place.x() + 0.1, place.y() + 0.1}, 0.25);
    const int label = seamlines.PhotoAt(pixel, {0, 0, 1, 1}).front();
    return label < 0 ? "" : seamlines.Photos()[static_cast<std::size_t>(label)];
  }

  std::vector<SeamPhoto> photos_;
  std::vector<PhotoCells> cells_;
};

// Noise of the two photos that is not the same.
Grey Noisy(unsigned seed, const Grey& grey = nullptr) {
  return [random = std::mt19937(seed), grey](double x, double y) mutable {
    return std::normal_distribution(100.0, 2.0)(random) + (grey ? grey(x, y) : 0);
  };
}

TEST(LeastDifference, WithoutAReasonIsTheLineOfTheNearestNadir) {
  TwoPhotos two;
  two.Add("a", {0, 0}, Noisy(1));
  two.Add("b", {120, 0}, Noisy(2));
  const Seamlines seamlines = SeamlinesOfLeastDifference(two.photos_, two.cells_);
  for (double y = -190; y < 200; y += 20) {
    EXPECT_EQ(TwoPhotos::At(seamlines, {60 - 16, y}), "a") << y;
    EXPECT_EQ(TwoPhotos::At(seamlines, {60 + 16, y}), "b") << y;
  }
}

TEST(LeastDifference, RunsAroundAHouseThatLeans) {
  const auto house = [](double from) {
    return [from](double x, double y) {
      return x > from && x < from + 24 && std::abs(y) < 20 ? 100 + 5 * (x - from) : 0.0;
    };
  };
  TwoPhotos two;
  two.Add("a", {0, 0}, Noisy(1, house(52)));
  two.Add("b", {120, 0}, Noisy(2, house(44)));
  const Seamlines seamlines = SeamlinesOfLeastDifference(two.photos_, two.cells_);
  for (double y = -17; y < 20; y += 4) {
    const std::string first = TwoPhotos::At(seamlines, {47, y});
    for (double x = 47; x < 76; x += 2) EXPECT_EQ(TwoPhotos::At(seamlines, {x, y}), first) << x;
  }
}

TEST(LeastDifference, CountsNoConstantDifferenceOfTones) {
  TwoPhotos two;
  two.Add("a", {0, 0}, Noisy(1));
  two.Add("b", {120, 0}, Noisy(2, [](double, double) { return 60.0; }));
  EXPECT_EQ(two.At({60 - 16, 31}), "a");
  EXPECT_EQ(two.At({60 + 16, 31}), "b");
}

TEST(LeastDifference, StaysInItsStripWhateverIsThere) {
  TwoPhotos two;
  two.Add("a", {0, 0}, Noisy(1));
  two.Add("b", {120, 0}, Noisy(2, [](double x, double) { return x > 20 ? 50.0 * (x / 10) : 0; }));
  const Seamlines seamlines = SeamlinesOfLeastDifference(two.photos_, two.cells_);
  for (double y = -190; y < 200; y += 20) {
    EXPECT_EQ(TwoPhotos::At(seamlines, {60 - 31, y}), "a");
    EXPECT_EQ(TwoPhotos::At(seamlines, {60 + 31, y}), "b");
  }
}

TEST(LeastDifference, GivesEveryCellThatAnyPhotoShowsToOneOfThoseThatDo) {
  TwoPhotos four;
  std::mt19937 random(3);
  for (int i = 0; i < 4; ++i) {
    four.Add(std::string(1, static_cast<char>('a' + i)),
             {std::uniform_real_distribution(0.0, 250.0)(random),
              std::uniform_real_distribution(0.0, 250.0)(random)},
             Noisy(static_cast<unsigned>(i)));
    for (int hole = 0; hole < 40; ++hole)
      four.cells_.back().bands[0].At(60 + hole % 8, 80 + hole / 8) = kNoData;
  }
  const Seamlines seamlines = SeamlinesOfLeastDifference(four.photos_, four.cells_);
  for (double x = -201; x < 460; x += 14)
    for (double y = -201; y < 460; y += 14) {
      std::string showing;
      for (std::size_t i = 0; i < 4; ++i) {
        const MapGrid& grid = four.cells_[i].grid;
        const int col = static_cast<int>(std::floor(x / kCell_m)) - static_cast<int>(grid.west);
        const int row =
            static_cast<int>(grid.north) - 1 - static_cast<int>(std::floor(y / kCell_m));
        if (col >= 0 && row >= 0 && col < grid.width && row < grid.height &&
            four.cells_[i].Has(col, row))
          showing += four.photos_[i].name;
      }
      const std::string shown = TwoPhotos::At(seamlines, {x, y});
      EXPECT_EQ(shown.empty(), showing.empty()) << x << " " << y;
      EXPECT_NE(showing.find(shown), std::string::npos) << x << " " << y;
    }
}

TEST(LeastDifference, OfPhotosFromOnePlaceShowsTheFirst) {
  TwoPhotos two;
  two.Add("a", {0, 0}, Noisy(1));
  two.Add("b", {0, 0}, Noisy(2));
  EXPECT_EQ(two.At({50, 50}), "a");
  EXPECT_EQ(two.At({-150, 50}), "a");
}

}  // namespace
}  // namespace orient::ortho
