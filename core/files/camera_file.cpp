#include "core/files/camera_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>

#include "core/base/error.h"
#include "core/files/mark_elements_toml.h"
#include "core/files/toml_fields.h"
#include "core/geometry/principal_axes.h"
#include "core/geometry/rotation.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// A pixel's two sides may differ by this much before the frame's size is taken for a mistake.
constexpr double kMaxPixelAspect = 0.01;
// An identification symbol stands beside its mark (docs/conventions.md).
constexpr double kMaxSymbolDistance_mm = 6;
constexpr int kMaxSymbolCount = 20;
constexpr double kMinBorderFeature_mm = 1;
constexpr int kMinFiducials = 3;  // what an affine transform needs
// Values beyond these are in another unit (metres, micrometres, pixels) than the file's.
constexpr double kMinDistanceOverDiagonal = 0.1, kMaxDistanceOverDiagonal = 50;
constexpr double kMaxMarkSize_mm = 20;  // from one end of a mark to the other
// Fiducials whose spread across a line is less than this part of that along it lie on one line.
constexpr double kMinThickness = 0.05;
// Two marks cannot be distinguished when they are nearer than this.
constexpr double kMinMarkDistance_mm = 1;

template <typename Enum>
Enum Choice(const TomlTable& table, std::string_view key,
            std::initializer_list<std::pair<std::string_view, Enum>> choices) {
  const std::string text = table.Text(key);
  std::string known;
  for (const auto& [name, value] : choices) {
    if (name == text) return value;
    known += (known.empty() ? "" : " or ") + std::string(name);
  }
  table.Fail(key, fmt::format("is \"{}\"; it must be {}", text, known));
}

BrownDistortion ReadBrown(const TomlTable& table) {
  BrownDistortion brown;
  const auto copy = [&table](std::string_view key, auto* target) {
    const auto values = table.FindNumbers(key);
    if (values && values->size() > target->size())
      table.Fail(key,
                 fmt::format("has {} values; the model has {}", values->size(), target->size()));
    if (values) std::copy(values->begin(), values->end(), target->begin());
  };
  copy("k", &brown.k);
  copy("p", &brown.p);
  return brown;
}

RadialTable ReadRadialTable(const TomlTable& table) {
  const auto radii = table.FindNumbers("radius_mm"), values = table.FindNumbers("dr_um");
  if (!radii || !values) table.Fail("", "needs both radius_mm and dr_um");
  if (radii->size() != values->size())
    table.Fail("dr_um",
               fmt::format("has {} values and radius_mm {}", values->size(), radii->size()));
  if (radii->size() < 2 || radii->front() != 0)
    table.Fail("radius_mm", "must start at 0 and have at least two radii");
  if (std::adjacent_find(radii->begin(), radii->end(), std::greater_equal<>()) != radii->end())
    table.Fail("radius_mm", "must increase from one radius to the next");
  return {*radii, *values};
}

// Coefficients in another unit (r in metres, r divided by the principal distance) move the corner
// of the frame by more than its own distance from the principal point: no lens does.
void CheckDistortion(const TomlTable& table, const Camera& camera) {
  const Eigen::Vector2d corner =
      camera.frame_centre_mm + 0.5 * camera.frame_mm - camera.principal_point_mm;
  const double moved_mm = DistortionAt(camera.lens, corner).norm();
  if (moved_mm > corner.norm())
    table.Fail("", fmt::format("moves the frame's corner by {:g} mm; k is per mm^2, mm^4, mm^6, p "
                               "per mm and dr_um in micrometres",
                               moved_mm));
}

// Which keys are known depends on the model, so the table is opened twice.
void ReadDistortion(const TomlTable& root, Camera* camera) {
  const auto any =
      root.FindTable("distortion", {"model", "k", "p", "radius_mm", "dr_um", "earth_k1"});
  if (!any) return;
  enum class Model { kBrown, kRadialTable };
  const auto model = Choice<Model>(
      *any, "model", {{"brown", Model::kBrown}, {"radial_table", Model::kRadialTable}});
  if (model == Model::kBrown)
    camera->lens = ReadBrown(*root.FindTable("distortion", {"model", "k", "p", "earth_k1"}));
  else
    camera->lens =
        ReadRadialTable(*root.FindTable("distortion", {"model", "radius_mm", "dr_um", "earth_k1"}));
  camera->earth_k1 = any->FindNumber("earth_k1").value_or(0);
  CheckDistortion(*any, *camera);
}

void ReadImageSize(const TomlTable& root, Camera* camera) {
  const auto size = root.FindCounts2("image_px");
  if (camera->kind == CameraKind::kFilm) {
    if (size) root.Fail("image_px", "is for digital cameras; a scan's size is its own");
    return;
  }
  if (!size) root.Fail("", "is a digital camera's and lacks the key image_px");
  if (size->minCoeff() <= 0) root.Fail("image_px", "must be positive");
  const Eigen::Vector2d pixel_mm = camera->frame_mm.cwiseQuotient(size->cast<double>());
  if (std::abs(pixel_mm.x() / pixel_mm.y() - 1) > kMaxPixelAspect)
    root.Fail("image_px", fmt::format("and frame_mm disagree: a pixel would be {:g} x {:g} mm; "
                                      "check the order width, height in both",
                                      pixel_mm.x(), pixel_mm.y()));
  camera->image_px = size;
}

void CheckPrincipalDistance(const TomlTable& root, const Camera& camera) {
  const std::string problem = PrincipalDistanceProblem(camera);
  if (!problem.empty()) root.Fail("principal_distance_mm", problem + "; both are in millimetres");
}

Camera ReadCamera(const TomlTable& root) {
  Camera camera;
  camera.name = root.Text("name");
  camera.kind = Choice<CameraKind>(
      root, "kind", {{"film", CameraKind::kFilm}, {"digital", CameraKind::kDigital}});
  camera.principal_distance_mm = root.PositiveNumber("principal_distance_mm");
  camera.principal_point_mm = root.Vector2("principal_point_mm");
  camera.frame_mm = root.Vector2("frame_mm");
  if (camera.frame_mm.minCoeff() <= 0) root.Fail("frame_mm", "is empty; both sides are positive");
  CheckPrincipalDistance(root, camera);
  camera.frame_centre_mm =
      root.FindVector2("frame_centre_mm").value_or(Eigen::Vector2d(Eigen::Vector2d::Zero()));
  if (camera.kind == CameraKind::kDigital && !camera.frame_centre_mm.isZero(0))
    root.Fail("frame_centre_mm",
              "is for film; the frame of a digital camera is its image: of a part of it, shift "
              "principal_point_mm instead");
  if (!camera.InFrame(camera.principal_point_mm))
    root.Fail("principal_point_mm", "lies outside the frame");
  ReadImageSize(root, &camera);
  ReadDistortion(root, &camera);
  return camera;
}

std::optional<MarkSymbol> ReadSymbol(const TomlTable& fiducial) {
  const auto table = fiducial.FindTable("symbol", {"kind", "count", "at_mm", "step_mm"});
  if (!table) return std::nullopt;
  MarkSymbol symbol;
  symbol.kind = Choice<SymbolKind>(*table, "kind",
                                   {{"lines", SymbolKind::kLines}, {"dots", SymbolKind::kDots}});
  symbol.count = table->FindCount("count").value_or(0);
  if (symbol.count < 1 || symbol.count > kMaxSymbolCount)
    table->Fail("count", "must be a whole number from 1 to " + std::to_string(kMaxSymbolCount));
  symbol.at_mm = table->FindVector2("at_mm");
  if (symbol.at_mm && symbol.at_mm->norm() > kMaxSymbolDistance_mm)
    table->Fail("at_mm", "is relative to the mark and at most 6 mm away from it");
  symbol.step_mm = table->FindVector2("step_mm");
  if (symbol.step_mm && symbol.step_mm->norm() == 0) table->Fail("step_mm", "must not be zero");
  return symbol;
}

std::vector<Fiducial> ReadFiducials(const TomlTable& root, const Camera& camera,
                                    const std::map<std::string, MarkDrawing>& marks) {
  std::vector<Fiducial> fiducials;
  for (const TomlTable& table :
       root.Tables("fiducials", {"id", "position_mm", "sigma_mm", "mark", "symbol"})) {
    if (camera.kind == CameraKind::kDigital)
      root.Fail("fiducials", "belong to film; a digital camera has none");
    Fiducial fiducial;
    fiducial.id = table.Text("id");
    fiducial.position_mm = table.Vector2("position_mm");
    const Eigen::Vector2d from_centre = fiducial.position_mm - camera.frame_centre_mm;
    if ((from_centre.cwiseAbs() - camera.frame_mm).maxCoeff() > 0)
      table.Fail("position_mm", fmt::format("lies far outside the frame of {:g} x {:g} mm",
                                            camera.frame_mm.x(), camera.frame_mm.y()));
    fiducial.sigma_mm = table.FindVector2("sigma_mm");
    if (fiducial.sigma_mm && fiducial.sigma_mm->minCoeff() < 0)
      table.Fail("sigma_mm", "must not be negative");
    fiducial.mark = table.Text("mark");
    if (!marks.contains(fiducial.mark))
      table.Fail("mark", fmt::format("is \"{}\", which is not drawn; add [marks.{}]", fiducial.mark,
                                     fiducial.mark));
    fiducial.symbol = ReadSymbol(table);
    for (const Fiducial& other : fiducials) {
      if (other.id == fiducial.id)
        table.Fail("id", fmt::format("\"{}\" belongs to an earlier fiducial", fiducial.id));
      if ((other.position_mm - fiducial.position_mm).norm() < kMinMarkDistance_mm)
        table.Fail("position_mm", fmt::format("is also the position of fiducial \"{}\"", other.id));
    }
    fiducials.push_back(std::move(fiducial));
  }
  return fiducials;
}

std::optional<FrameSide> ReadDataStrip(const TomlTable& root) {
  if (!root.Has("data_strip")) return std::nullopt;
  return Choice<FrameSide>(root, "data_strip",
                           {{"left", FrameSide::kLeft},
                            {"right", FrameSide::kRight},
                            {"bottom", FrameSide::kBottom},
                            {"top", FrameSide::kTop}});
}

std::vector<BorderFeature> ReadBorder(const TomlTable& root, const Camera& camera) {
  std::vector<BorderFeature> border;
  for (const TomlTable& table : root.Tables("border", {"shows", "from_mm", "to_mm"})) {
    BorderFeature feature;
    feature.shows = Choice<BorderSign>(table, "shows",
                                       {{"text", BorderSign::kText},
                                        {"dark", BorderSign::kDark},
                                        {"bright", BorderSign::kBright}});
    const Eigen::Vector2d a = table.Vector2("from_mm"), b = table.Vector2("to_mm");
    feature.from_mm = a.cwiseMin(b);
    feature.to_mm = a.cwiseMax(b);
    if ((feature.to_mm - feature.from_mm).minCoeff() < kMinBorderFeature_mm)
      table.Fail("to_mm", "and from_mm are opposite corners of a rectangle at least 1 mm wide");
    const Eigen::Vector2d farthest =
        (a - camera.frame_centre_mm).cwiseAbs().cwiseMax((b - camera.frame_centre_mm).cwiseAbs());
    if ((farthest - camera.frame_mm).maxCoeff() > 0)
      table.Fail("from_mm", "and to_mm reach far outside the frame");
    border.push_back(feature);
  }
  return border;
}

// Marks on one line do not determine a transform: it is undetermined away from the line.
void CheckConstellation(const TomlTable& root, const std::vector<Fiducial>& fiducials) {
  if (fiducials.empty()) return;
  if (std::ssize(fiducials) < kMinFiducials)
    root.Fail("fiducials", "are fewer than the three that interior orientation needs");
  std::vector<Eigen::Vector2d> places;
  for (const Fiducial& f : fiducials) places.push_back(f.position_mm);
  if (Thickness(places) < kMinThickness)
    root.Fail("fiducials", "lie on one line and determine no interior orientation");
}

MarkImage ReadMarkImage(const TomlTable& table) {
  MarkImage image;
  image.path = (fs::path(table.File()).parent_path() / table.Text("image")).string();
  std::error_code error;
  if (!fs::exists(image.path, error))
    table.Fail("image", fmt::format("names {}, which does not exist", image.path));
  image.pixel_size_mm = table.PositiveNumber("pixel_size_mm");
  image.centre_px = table.Vector2("centre_px");
  return image;
}

void CheckElements(const TomlTable& table, const std::vector<MarkElement>& elements) {
  double brightest = 0;
  for (const MarkElement& element : elements) {
    if (2 * Reach(element) > kMaxMarkSize_mm)
      table.Fail("elements",
                 fmt::format("draw a mark of {:g} mm; sizes are in millimetres, at most 20",
                             2 * Reach(element)));
    brightest = std::max(brightest, std::abs(BrightnessOf(element)));
  }
  if (!elements.empty() && brightest == 0)
    table.Fail("elements", "are all as bright as what surrounds them (brightness 0)");
}

MarkDrawing ReadMark(const TomlTable& table) {
  MarkDrawing mark;
  for (const auto& [element, name] : table.RawTables("elements"))
    mark.elements.push_back(ReadMarkElement(*element, table.File(), name));
  CheckElements(table, mark.elements);
  if (table.Has("background"))
    mark.background = Choice<MarkBackground>(
        table, "background", {{"dark", MarkBackground::kDark}, {"image", MarkBackground::kImage}});
  if (table.Has("image")) {
    mark.image = ReadMarkImage(table);
  } else if (table.Has("pixel_size_mm") || table.Has("centre_px")) {
    table.Fail("", "has pixel_size_mm or centre_px without an image");
  }
  if (mark.elements.empty() == !mark.image.has_value())
    table.Fail("", "must have either elements or an image");
  return mark;
}

}  // namespace

std::string PrincipalDistanceProblem(const Camera& camera) {
  const double ratio = camera.principal_distance_mm / camera.frame_mm.norm();
  if (ratio >= kMinDistanceOverDiagonal && ratio <= kMaxDistanceOverDiagonal) return "";
  return fmt::format("is {:g} mm, for a frame whose diagonal is {:g} mm",
                     camera.principal_distance_mm, camera.frame_mm.norm());
}

CameraFile ReadCameraFile(const std::string& path) {
  const toml::table document = ParseTomlFile(path);
  const TomlTable root(
      document, path, "",
      {"name", "kind", "principal_distance_mm", "principal_point_mm", "frame_mm", "frame_centre_mm",
       "image_px", "distortion", "fiducials", "marks", "data_strip", "border"});
  CameraFile file;
  file.camera = ReadCamera(root);
  for (const auto& [name, table] :
       root.NamedTables("marks", {"elements", "background", "image", "pixel_size_mm", "centre_px"}))
    file.marks.emplace(name, ReadMark(table));
  file.fiducials = ReadFiducials(root, file.camera, file.marks);
  CheckConstellation(root, file.fiducials);
  file.data_strip = ReadDataStrip(root);
  file.border = ReadBorder(root, file.camera);
  return file;
}

}  // namespace orient
