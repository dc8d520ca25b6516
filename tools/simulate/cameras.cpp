#include "tools/simulate/cameras.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace orient::simulation {
namespace {

using Eigen::Vector2d;

constexpr double kPastFilm_mm = 0.55;  // of the scanner's bed around the film

// Scan of a film: the film and a little of what holds it. The rebate is equally wide on all sides.
void SetFilm(double film_half_mm, double pixel_size_mm, SimulatedCamera* camera) {
  camera->pixel_size_mm = pixel_size_mm;
  camera->film_half_mm = film_half_mm;
  const Vector2d half = 0.5 * camera->file.camera.frame_mm;
  const Vector2d film = half.array() + (film_half_mm - half.maxCoeff() + kPastFilm_mm);
  camera->width_px = static_cast<int>(std::ceil(2 * film.x() / pixel_size_mm));
  camera->height_px = static_cast<int>(std::ceil(2 * film.y() / pixel_size_mm));
}

// Marks numbered from 1 on, or from as many as there are.
void AddMarks(const std::vector<Vector2d>& positions_mm, CameraFile* file) {
  for (const Vector2d& position : positions_mm)
    file->fiducials.push_back(
        {std::to_string(file->fiducials.size() + 1), position, "mark", std::nullopt});
}

SimulatedCamera FilmCamera(const std::string& name, double principal_distance_mm,
                           const Vector2d& principal_point_mm, const Vector2d& frame_mm,
                           std::vector<MarkElement> mark) {
  SimulatedCamera camera;
  Camera& geometry = camera.file.camera;
  geometry.name = name;
  geometry.principal_distance_mm = principal_distance_mm;
  geometry.principal_point_mm = principal_point_mm;
  geometry.frame_mm = frame_mm;
  camera.file.marks["mark"].elements = std::move(mark);
  return camera;
}

// Symbols in the rebate: lines outwards of marks 1 to 4, dots along the side beside marks 5 to 8.
void NumberMarks(double first_mm, double step_mm, CameraFile* file) {
  for (size_t i = 0; i < file->fiducials.size(); ++i) {
    Fiducial& fiducial = file->fiducials[i];
    const int count = static_cast<int>(i % 4) + 1;
    if (i < 4) {
      const Vector2d outwards(fiducial.position_mm.x() > 0 ? 1 : -1, 0);
      fiducial.symbol =
          MarkSymbol{SymbolKind::kLines, count, first_mm * outwards, step_mm * outwards};
    } else {
      const bool on_left_or_right =
          std::abs(fiducial.position_mm.x()) > std::abs(fiducial.position_mm.y());
      const Vector2d along = on_left_or_right ? Vector2d(0, 1) : Vector2d(1, 0);
      fiducial.symbol =
          MarkSymbol{SymbolKind::kDots, count, first_mm * along, 1.5 * step_mm * along};
    }
  }
}

SimulatedCamera Demo(const SimulationOptions& options) {
  SimulatedCamera camera =
      FilmCamera("Simulated 6 cm frame camera", 60.124, {0.021, -0.013}, {56, 56},
                 {CrossElement{2.0, 0.10, 0.5, 0}, DotElement{0.2}, CircleElement{1.3, 0.08}});
  camera.file.camera.lens = BrownDistortion{{-1.1e-7, 2.4e-11, 0}, {1.5e-7, -0.8e-7}};
  AddMarks({{-26.204, 26.197}, {26.201, 26.203}, {26.196, -26.202}, {-26.199, -26.198}},
           &camera.file);
  if (options.mark_symbols) NumberMarks(2.3, 0.35, &camera.file);
  SetFilm(30.2, options.pixel_size_um.value_or(25) * 1e-3, &camera);
  return camera;
}

// 23 cm film: 212 mm frame; the RC30 has marks in the middle of the sides as well.
SimulatedCamera Wild(const SimulationOptions& options, bool rc30) {
  SimulatedCamera camera =
      FilmCamera(rc30 ? "Simulated Wild RC30" : "Simulated Wild RC10", rc30 ? 153.412 : 152.673,
                 rc30 ? Vector2d(0.006, -0.003) : Vector2d(0.012, 0.008), {212, 212},
                 {CrossElement{2.4, 0.10, 0.6, rc30 ? 0 : std::numbers::pi / 4}, DotElement{0.15},
                  CircleElement{1.6, 0.08}});
  camera.file.camera.lens = RadialTable{{0, 30, 60, 90, 120, 150}, {0, 1.8, 2.6, 0.4, -2.9, -1.2}};
  AddMarks({{-106.004, -106.001}, {105.998, 105.999}, {-106.002, 106.005}, {106.003, -106.002}},
           &camera.file);
  if (rc30)
    AddMarks({{-110.003, 0.002}, {110.001, -0.001}, {0.002, 110.004}, {-0.001, -110.002}},
             &camera.file);
  if (options.mark_symbols) NumberMarks(1.9, 0.4, &camera.file);
  SetFilm(115, options.pixel_size_um.value_or(50) * 1e-3, &camera);
  return camera;
}

// 23 cm film with marks in the middle of the sides; the data strip and an exposed tongue in the
// rebate tell the scan orientation.
SimulatedCamera Lmk(const SimulationOptions& options) {
  SimulatedCamera camera = FilmCamera("Simulated Zeiss LMK", 152.011, {-0.007, 0.004}, {222, 222},
                                      {CrossElement{2.2, 0.08, 0.4, 0}, DotElement{0.1}});
  AddMarks({{-113.502, 0.001}, {-0.003, 113.498}, {113.499, -0.002}, {0.002, -113.503}},
           &camera.file);
  camera.file.data_strip = FrameSide::kLeft;
  camera.file.border = {{BorderSign::kBright, {40, 111}, {47, 114}}};
  SetFilm(119, options.pixel_size_um.value_or(50) * 1e-3, &camera);
  return camera;
}

// A 13 x 18 cm terrestrial camera, marks in the middle of the sides.
SimulatedCamera Umk(const SimulationOptions& options) {
  SimulatedCamera camera = FilmCamera("Simulated Zeiss UMK", 99.147, {0.004, 0.011}, {166, 120},
                                      {CrossElement{1.6, 0.06, 0.3, 0}, CircleElement{1.0, 0.05}});
  AddMarks({{-81.001, 0.002}, {0.001, 58.003}, {80.998, -0.001}, {-0.002, -57.999}}, &camera.file);
  SetFilm(88, options.pixel_size_um.value_or(50) * 1e-3, &camera);
  return camera;
}

// Thin bright crosses in the picture itself: the P31's five (Jiang, Zhang & Li), or a grid.
SimulatedCamera InPicture(const SimulationOptions& options, bool reseau) {
  SimulatedCamera camera = reseau ? FilmCamera("Simulated reseau camera", 50.417, {0, 0}, {60, 60},
                                               {CrossElement{1.2, 0.04, 0, 0}})
                                  : FilmCamera("Simulated Wild P31", 99.123, {0, 0}, {119, 91},
                                               {CrossElement{2.4, 0.06, 0, 0}});
  camera.file.marks["mark"].background = MarkBackground::kImage;
  if (reseau) {
    for (int row = -5; row <= 5; ++row)
      for (int col = -5; col <= 5; ++col)
        camera.file.fiducials.push_back(
            {fmt::format("{}/{}", col + 6, row + 6), {5.0 * col, 5.0 * row}, "mark", std::nullopt});
  } else {
    AddMarks({{0, 42.504}, {-57.494, 15}, {0.002, -42.498}, {57.496, 15}, {0, 15}}, &camera.file);
  }
  SetFilm(0.5 * camera.file.camera.frame_mm.maxCoeff() + 2,
          options.pixel_size_um.value_or(25) * 1e-3, &camera);
  return camera;
}

// A digital frame of the given sensor; the pixel size is fitted to a whole number of pixels.
SimulatedCamera Digital(const std::string& name, const Vector2d& sensor_mm, double principal_mm,
                        double pixel_size_mm) {
  SimulatedCamera camera;
  Camera& geometry = camera.file.camera;
  geometry.name = name;
  geometry.kind = CameraKind::kDigital;
  geometry.principal_distance_mm = principal_mm;
  geometry.principal_point_mm = {-0.014, 0.009};
  camera.width_px = static_cast<int>(std::lround(sensor_mm.x() / pixel_size_mm));
  camera.height_px = static_cast<int>(std::lround(sensor_mm.y() / pixel_size_mm));
  camera.pixel_size_mm = pixel_size_mm;
  geometry.image_px = Eigen::Vector2i(camera.width_px, camera.height_px);
  geometry.frame_mm = pixel_size_mm * Vector2d(camera.width_px, camera.height_px);
  geometry.lens = BrownDistortion{{3.0e-8, -4.0e-12, 0}, {-0.5e-7, 0.4e-7}};
  if (geometry.frame_mm.norm() > 150) geometry.lens = std::monostate{};
  return camera;
}

}  // namespace

SimulatedCamera NewCamera(const SimulationOptions& options) {
  switch (options.camera) {
    case CameraPreset::kRc10:
      return Wild(options, false);
    case CameraPreset::kRc30:
      return Wild(options, true);
    case CameraPreset::kLmk:
      return Lmk(options);
    case CameraPreset::kUmk:
      return Umk(options);
    case CameraPreset::kP31:
      return InPicture(options, false);
    case CameraPreset::kReseau:
      return InPicture(options, true);
    case CameraPreset::kDigital:
      return Digital("Simulated digital frame camera", {53.4, 40.0}, 70.3,
                     options.pixel_size_um.value_or(20) * 1e-3);
    case CameraPreset::kDemo:
      break;
  }
  return Demo(options);
}

SimulatedCamera OldCamera(const SimulationOptions& options) {
  const SimulatedCamera fresh = NewCamera(options);
  const Camera& geometry = fresh.file.camera;
  const double longer = 1.12;
  const double principal_mm = longer * geometry.principal_distance_mm;
  // pixel = gsd * c / h, with everything relative to the new photo's pixel.
  const double pixel_mm =
      fresh.pixel_size_mm * options.old_gsd_ratio * longer / options.old_height_ratio;
  if (!options.old_film)
    return Digital("Simulated older digital camera", geometry.frame_mm, principal_mm, pixel_mm);
  SimulationOptions film = options;
  film.pixel_size_um = pixel_mm * 1e3;
  SimulatedCamera camera = options.camera == CameraPreset::kDigital ? Demo(film) : NewCamera(film);
  camera.file.camera.name = "Simulated older film camera";
  camera.file.camera.principal_distance_mm = principal_mm;
  return camera;
}

double FlyingHeight(const SimulatedCamera& camera, double gsd_m) {
  return gsd_m / camera.pixel_size_mm * camera.file.camera.principal_distance_mm;
}

}  // namespace orient::simulation
