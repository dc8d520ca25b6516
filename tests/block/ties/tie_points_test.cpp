#include "block/ties/tie_points.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <set>

#include "core/raster/raster.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

constexpr int kSide = 420;            // of a photo, px
constexpr double kPixel_mm = 0.1;     // of a photo
constexpr double kFlying_m = 1000;    // above the plain
constexpr double kPrincipal_mm = 50;  // so that a pixel shows 2 m
constexpr double kGsd_m = kPixel_mm * kFlying_m / kPrincipal_mm;

// Fewer cells than usual, so that the tests are quick.
const TieOptions kFew{.cells = 10};

// Smooth random grey values over the ground, the same for the same number.
class Texture {
 public:
  explicit Texture(unsigned seed) : values_(kNodes * kNodes) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> grey(0, 255);
    for (double& value : values_) value = grey(random);
  }
  double At(double x_m, double y_m) const {
    return 0.6 * Smooth(x_m / (3 * kGsd_m), y_m / (3 * kGsd_m)) +
           0.4 * Smooth(x_m / (9 * kGsd_m) + 50, y_m / (9 * kGsd_m) + 50);
  }

 private:
  static constexpr int kNodes = 512;
  double Node(int i, int j) const {
    return values_[static_cast<std::size_t>((i & (kNodes - 1)) * kNodes + (j & (kNodes - 1)))];
  }
  double Smooth(double u, double v) const {
    const double i = std::floor(u), j = std::floor(v);
    const auto ease = [](double t) { return t * t * (3 - 2 * t); };
    const double fu = ease(u - i), fv = ease(v - j);
    const int a = static_cast<int>(i), b = static_cast<int>(j);
    return (1 - fv) * ((1 - fu) * Node(a, b) + fu * Node(a + 1, b)) +
           fv * ((1 - fu) * Node(a, b + 1) + fu * Node(a + 1, b + 1));
  }
  std::vector<double> values_;
};

// A hill of 60 m in a plain, 10 m cells, 4 km wide.
GroundSurface Hill() {
  constexpr int kCells = 400;
  Eigen::MatrixXf heights(kCells, kCells);
  for (int row = 0; row < kCells; ++row)
    for (int col = 0; col < kCells; ++col) {
      const double x = 10 * col - 2000, y = 2000 - 10 * row;
      heights(row, col) = static_cast<float>(60 * std::exp(-(x * x + y * y) / (2 * 300 * 300)));
    }
  return GroundSurface::FromGrid(heights, -2000, 2000, 10);
}

Camera SmallCamera() {
  Camera camera;
  camera.kind = CameraKind::kDigital;
  camera.principal_distance_mm = kPrincipal_mm;
  camera.frame_mm = {kSide * kPixel_mm, kSide * kPixel_mm};
  camera.image_px = Eigen::Vector2i(kSide, kSide);
  return camera;
}

PhotoView ViewFrom(double x_m, double y_m, double kappa_rad) {
  const Camera camera = SmallCamera();
  return {camera, DigitalPhotoFromPixel(camera), {{x_m, y_m, kFlying_m}, {0.01, -0.02, kappa_rad}}};
}

// Photos of one scene, drawn exactly; what is said of their poses may be wrong.
class TiePoints : public testing::Test {
 protected:
  ~TiePoints() override {
    for (const std::string& path : paths_) std::filesystem::remove(path);
  }

  void AddPhoto(const PhotoView& truth, unsigned scene = 1) {
    const Texture texture(scene);
    std::vector<unsigned char> grey(kSide * kSide);
    for (int row = 0; row < kSide; ++row)
      for (int col = 0; col < kSide; ++col) {
        const auto ground = truth.GroundFromPixel({col + 0.5, row + 0.5}, surface_);
        grey[static_cast<std::size_t>(row * kSide + col)] =
            ground ? static_cast<unsigned char>(texture.At(ground->x(), ground->y()) + 0.5) : 0;
      }
    paths_.push_back(testing::TempDir() + "/orient_ties_" + std::to_string(TestSeed()) + "_" +
                     std::to_string(paths_.size()) + ".png");
    WritePng(paths_.back(), kSide, kSide, 1, grey);
    rasters_.push_back(std::make_unique<Raster>(Raster::Open(paths_.back())));
    images_.push_back(std::make_unique<exterior::PhotoImage>(*rasters_.back(), false));
    truth_.push_back(truth);
    photos_.push_back(
        {"p" + std::to_string(photos_.size()), truth, Matrix6d::Zero(), images_.back().get()});
  }

  // Three of a strip and one of the next one, flown the other way.
  void AddFourPhotos() {
    AddPhoto(ViewFrom(-336, 0, 0.02));
    AddPhoto(ViewFrom(0, 0, -0.03));
    AddPhoto(ViewFrom(336, 0, 0.01));
    AddPhoto(ViewFrom(0, 560, 3.1));
  }

  // Says that a photo stands elsewhere than it does, with a standard deviation of `sigma_px`.
  void Mislead(std::size_t photo, const Eigen::Vector2d& shift_px, double sigma_px) {
    const double sigma_m = sigma_px * kGsd_m;
    photos_[photo].view.pose.position_m.head<2>() += shift_px * kGsd_m;
    photos_[photo].pose_covariance.diagonal().head<2>().fill(sigma_m * sigma_m);
  }

  // How far a sighting is from where the photos truly show what the owner's pixel shows.
  double ErrorOf(const MeasuredTie& tie, const TieSighting& sighting) const {
    const auto ground =
        truth_[tie.seen.front().photo].GroundFromPixel(tie.seen.front().pixel, surface_);
    return (*truth_[sighting.photo].PixelFromGround(*ground) - sighting.pixel).norm();
  }

  double RmsError(const std::vector<MeasuredTie>& ties) const {
    double sum = 0;
    int count = 0;
    for (const MeasuredTie& tie : ties)
      for (std::size_t i = 1; i < tie.seen.size(); ++i, ++count)
        sum += std::pow(ErrorOf(tie, tie.seen[i]), 2);
    return std::sqrt(sum / std::max(count, 1));
  }

  const GroundSurface surface_ = Hill();
  std::vector<std::string> paths_;
  std::vector<std::unique_ptr<Raster>> rasters_;
  std::vector<std::unique_ptr<exterior::PhotoImage>> images_;
  std::vector<PhotoView> truth_;
  std::vector<TiePhoto> photos_;
};

TEST_F(TiePoints, LieWhereThePhotosShowTheSameGround) {
  AddFourPhotos();
  for (std::size_t owner = 0; owner < photos_.size(); ++owner) {
    const auto ties = FindTies(photos_, owner, surface_, kFew);
    EXPECT_GT(ties.size(), 10U) << owner;
    EXPECT_LT(RmsError(ties), 0.1) << owner;
    for (const MeasuredTie& tie : ties) EXPECT_EQ(tie.seen.front().photo, owner);
  }
}

TEST_F(TiePoints, JoinAllPhotosThatShowAPlace) {
  AddFourPhotos();
  std::set<std::set<std::size_t>> joined;
  for (std::size_t owner = 0; owner < photos_.size(); ++owner)
    for (const MeasuredTie& tie : FindTies(photos_, owner, surface_, kFew)) {
      std::set<std::size_t> photos;
      for (const TieSighting& sighting : tie.seen) photos.insert(sighting.photo);
      ASSERT_EQ(photos.size(), tie.seen.size());
      joined.insert(photos);
    }
  for (const std::set<std::size_t>& fold :
       std::vector<std::set<std::size_t>>{{0, 1}, {1, 2}, {0, 1, 2}, {1, 3}, {0, 1, 2, 3}})
    EXPECT_TRUE(joined.contains(fold)) << "fold " << fold.size();
}

TEST_F(TiePoints, NoPlaceIsMeasuredFromTwoPhotos) {
  AddFourPhotos();
  std::vector<std::pair<std::size_t, Eigen::Vector3d>> places;
  for (std::size_t owner = 0; owner < photos_.size(); ++owner)
    for (const MeasuredTie& tie : FindTies(photos_, owner, surface_, kFew))
      places.emplace_back(owner, tie.ground_m);
  for (const auto& [owner, place] : places) {
    for (const auto& [other, there] : places) {
      if (owner != other) {
        EXPECT_GT((place - there).norm(), kGsd_m);
      }
    }
  }
}

TEST_F(TiePoints, PosesOffByManyPixelsAreCoveredByTheirCovariance) {
  AddPhoto(ViewFrom(0, 0, 0));
  AddPhoto(ViewFrom(336, 0, 0.02));
  const std::size_t near = FindTies(photos_, 0, surface_, kFew).size();
  Mislead(1, {14, -11}, 8);
  const auto ties = FindTies(photos_, 0, surface_, kFew);
  EXPECT_GT(ties.size(), near * 6 / 10);
  EXPECT_LT(RmsError(ties), 0.15);
}

TEST_F(TiePoints, APoseBeyondItsCovarianceGivesNoWrongTies) {
  AddPhoto(ViewFrom(0, 0, 0));
  AddPhoto(ViewFrom(336, 0, 0.02));
  Mislead(1, {60, 45}, 2);
  EXPECT_LE(FindTies(photos_, 0, surface_, kFew).size(), 1U);
}

TEST_F(TiePoints, PhotosOfDifferentScenesHaveNone) {
  AddPhoto(ViewFrom(0, 0, 0), 1);
  AddPhoto(ViewFrom(336, 0, 0), 2);
  Mislead(1, {0, 0}, 5);
  EXPECT_LE(
      FindTies(photos_, 0, surface_, kFew).size() + FindTies(photos_, 1, surface_, kFew).size(),
      1U);
}

TEST_F(TiePoints, TheirCovarianceHoldsWhatTheyMiss) {
  AddFourPhotos();
  double chi2 = 0;
  int count = 0;
  for (std::size_t owner = 0; owner < photos_.size(); ++owner)
    for (const MeasuredTie& tie : FindTies(photos_, owner, surface_, kFew))
      for (std::size_t i = 1; i < tie.seen.size(); ++i, count += 2) {
        const Eigen::Matrix2d& covariance = tie.seen[i].covariance_px2;
        chi2 += std::pow(ErrorOf(tie, tie.seen[i]), 2) / covariance.trace();
      }
  ASSERT_GT(count, 200);
  EXPECT_LT(chi2 / count, 1.2);
}

}  // namespace
}  // namespace orient::block
