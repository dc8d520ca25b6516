#include "tools/simulate/photo_making.h"

#include "tools/simulate/noise.h"
#include "tools/simulate/photo_rendering.h"

namespace orient::simulation {
namespace {

// A film's shrinkage: 1 plus some hundred millionths in all four parameters.
Eigen::Matrix2d Stretch(double sigma_ppm, RandomStream* random) {
  Eigen::Matrix2d stretch = Eigen::Matrix2d::Identity();
  for (Eigen::Index i = 0; i < 4; ++i)
    stretch(i / 2, i % 2) += 1e-6 * sigma_ppm * random->Gaussian();
  return stretch;
}

ScanOrientation ChooseOrientation(const SimulationOptions& options, bool old,
                                  RandomStream* random) {
  const auto any = kAllScanOrientations[random->Next() % kAllScanOrientations.size()];
  return old ? ScanOrientation::kR0 : options.orientation.value_or(any);
}

std::vector<MarkCondition> ChooseMarks(const SimulationOptions& options, size_t count,
                                       RandomStream* random) {
  std::vector<MarkCondition> marks(count, MarkCondition::kClean);
  std::vector<size_t> order;
  for (size_t i = 0; i < count; ++i) order.push_back(i);
  for (size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random->Next() % i]);
  for (size_t i = 0; i < count; ++i) {
    const int rank = static_cast<int>(i);
    if (rank < options.missing_marks)
      marks[order[i]] = MarkCondition::kMissing;
    else if (rank < options.missing_marks + options.dirty_marks)
      marks[order[i]] = MarkCondition::kDirty;
  }
  return marks;
}

}  // namespace

PhotoPlan PlanPhoto(const SimulationOptions& options, const SimulatedCamera& camera,
                    const PlannedPhoto& photo, bool old, int number) {
  const std::uint32_t seed = Hash(options.seed, number, old ? 1 : 2);
  RandomStream random(seed);
  ScanSetup setup;
  setup.width = camera.width_px;
  setup.height = camera.height_px;
  setup.pixel_size_mm = camera.pixel_size_mm;
  setup.half_frame_mm = 0.5 * camera.file.camera.frame_mm.maxCoeff();
  std::vector<MarkCondition> marks(camera.file.fiducials.size(), MarkCondition::kClean);
  if (camera.film_half_mm <= 0)
    return {photo, ScanGeometry(setup), Polarity::kPositive, marks, seed};

  setup.orientation = ChooseOrientation(options, old, &random);
  if (LiesAcross(setup.orientation)) std::swap(setup.width, setup.height);
  setup.rotation_rad = RadFromDeg(options.scan_rotation_deg * random.Gaussian());
  setup.shift_mm = {random.Uniform(-0.25, 0.25), random.Uniform(-0.25, 0.25)};
  setup.stretch = Stretch(options.film_shrink_ppm, &random);
  if (options.film_bend_um > 0)
    setup.bend = RandomBend(setup.half_frame_mm, options.film_bend_um, seed + 1);
  if (!old) marks = ChooseMarks(options, marks.size(), &random);
  const Polarity polarity = old ? Polarity::kPositive : options.polarity;
  return {photo, ScanGeometry(setup), polarity, marks, seed};
}

FilmFrame FilmOf(const SimulatedCamera& camera, const PhotoPlan& plan) {
  FilmFrame film;
  film.camera = camera.file;
  film.film_half_mm = camera.film_half_mm;
  film.conditions = plan.marks;
  film.seed = plan.seed;
  return film;
}

ScannerOptions ScannerOf(const SimulationOptions& options, const PhotoPlan& plan) {
  ScannerOptions scanner;
  scanner.grain = options.grain;
  scanner.negative = plan.polarity == Polarity::kNegative;
  scanner.bits = options.bits;
  scanner.seed = plan.seed + 9;
  return scanner;
}

std::vector<std::uint16_t> MakePhoto(const SimulationOptions& options,
                                     const SimulatedCamera& camera, const PhotoPlan& plan,
                                     const GroundRaster& ground, const Terrain& terrain) {
  constexpr double kPastFrame_mm = 0.3;
  Image image =
      RenderPhoto(camera.Seeing(), plan.photo.pose, plan.scan, ground, terrain, kPastFrame_mm);
  DrawFilm(FilmOf(camera, plan), plan.scan, options.blur_px, &image);
  return Scan(image, ScannerOf(options, plan));
}

InteriorResult TrueInterior(const SimulatedCamera& camera, const PhotoPlan& plan) {
  InteriorResult result;
  result.photo = plan.photo.name;
  result.status = Status::kOk;
  result.width = plan.scan.Setup().width;
  result.height = plan.scan.Setup().height;
  result.pixel_size_um = camera.pixel_size_mm * 1e3;
  result.polarity = plan.polarity;
  result.orientation = plan.scan.Setup().orientation;
  result.photo_from_pixel = plan.scan.BestAffine();
  result.sigma0_um = plan.scan.BendRms() * 1e3 / std::sqrt(2.0);
  for (size_t i = 0; i < camera.file.fiducials.size(); ++i) {
    const Fiducial& fiducial = camera.file.fiducials[i];
    MarkResult mark;
    mark.id = fiducial.id;
    if (plan.marks[i] != MarkCondition::kMissing) {
      mark.state = MarkState::kUsed;
      mark.pixel = plan.scan.PixelFromPhoto(fiducial.position_mm);
      mark.residual_um = 1e3 * (fiducial.position_mm - plan.scan.BestAffine() * *mark.pixel);
    }
    result.marks.push_back(mark);
  }
  return result;
}

}  // namespace orient::simulation
