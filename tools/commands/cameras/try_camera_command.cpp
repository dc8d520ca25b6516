#include "tools/commands/cameras/try_camera_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <ostream>
#include <vector>

#include "block/inputs/camera_library.h"
#include "block/inputs/mark_shapes.h"
#include "block/inputs/measurement_inputs.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "interior/interior.h"
#include "interior/marks/drawing_fit.h"
#include "interior/marks/mark_picture.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// The linear part of the transform from photo mm to scan pixels; without a transform, from the
// stated or tagged pixel size.
Matrix2d PixelFromMm(const InteriorResult& result, const Raster& scan,
                     const interior::InteriorOptions& options) {
  if (result.photo_from_pixel) return result.photo_from_pixel->A.inverse();
  double pixel_mm = 1e-3 * result.pixel_size_um.value_or(100.0);
  if (const auto dpi = scan.DpiTag(); dpi && !result.pixel_size_um) pixel_mm = 25.4 / *dpi;
  if (options.pixel_size_um) pixel_mm = 1e-3 * *options.pixel_size_um;
  const Matrix2d axes =
      PhotoFromPixelAxes(options.orientation.value_or(ScanOrientation::kR0)) * pixel_mm;
  return axes.inverse();
}

std::vector<interior::DrawnMark> DrawnMarks(const InteriorResult& result, const CameraFile& camera,
                                            const interior::MarkShapes& shapes) {
  std::vector<interior::DrawnMark> drawn;
  for (size_t i = 0; i < result.marks.size(); ++i) {
    const MarkResult& mark = result.marks[i];
    const std::optional<Vector2d>& pixel = mark.pixel ? mark.pixel : mark.expected;
    if (!pixel) continue;
    drawn.push_back(
        {mark.id, shapes.at(camera.fiducials[i].mark), *pixel, mark.state == MarkState::kUsed});
  }
  return drawn;
}

// For every drawing of elements whose used marks another drawing explains better: that drawing.
void PrintBetterDrawings(const CameraFile& camera, const InteriorResult& result, const Raster& scan,
                         const Matrix2d& pixel_from_mm, std::ostream& out) {
  constexpr size_t kMostMarks = 3;
  constexpr double kClearlyBetter = 0.02;
  interior::CutOptions cut;
  cut.negative = result.polarity == Polarity::kNegative;
  std::map<std::string, std::vector<interior::SeenMark>> by_drawing;
  for (size_t i = 0; i < result.marks.size(); ++i) {
    const std::string& drawing = camera.fiducials[i].mark;
    if (result.marks[i].state != MarkState::kUsed || camera.marks.at(drawing).image) continue;
    auto& seen = by_drawing[drawing];
    if (seen.size() < kMostMarks)
      seen.push_back(CutMark(scan, *result.marks[i].pixel, pixel_from_mm, cut));
  }
  for (const auto& [name, seen] : by_drawing) {
    const auto& elements = camera.marks.at(name).elements;
    const auto fitted = interior::FitDrawing(seen);
    if (!fitted) continue;
    // Both over the same surroundings: those of the larger of the two.
    const double radius =
        std::max(interior::RadiusOf(elements), interior::RadiusOf(fitted->elements));
    const double present = interior::LocateDrawing(elements, seen, radius).MeanCorrelation();
    const double better = interior::LocateDrawing(fitted->elements, seen, radius).MeanCorrelation();
    if (better < present + kClearlyBetter) {
      out << fmt::format("{}: correlation {:.3f}; no other drawing is clearly better\n", name,
                         present);
      continue;
    }
    out << fmt::format("{}: correlation {:.3f}; {:.3f} with\n  elements = [\n", name, present,
                       better);
    for (const MarkElement& element : fitted->elements)
      out << "    " << ElementText(element) << ",\n";
    out << "  ]\n";
  }
}

void Print(const InteriorResult& result, std::ostream& out) {
  SummaryTable table({"mark", "state", "score", "col", "row", "sigma px", "residual um"});
  for (const MarkResult& mark : result.marks)
    table.AddRow({mark.id, std::string(Name(mark.state)), mark.score ? Fixed(*mark.score, 3) : "-",
                  mark.pixel ? Fixed(mark.pixel->x(), 2) : "-",
                  mark.pixel ? Fixed(mark.pixel->y(), 2) : "-",
                  mark.sigma_px ? Fixed(mark.sigma_px->maxCoeff(), 3) : "-",
                  mark.residual_um ? Fixed(mark.residual_um->norm(), 0) : "-"});
  table.Print(out);
  out << "\nstatus    " << Name(result.status) << "\n";
  for (const Finding& finding : result.findings) out << "  " << Sentence(finding) << "\n";
}

}  // namespace

bool TryCameraCommand::Asked() const { return app_ != nullptr && app_->parsed(); }

void TryCameraCommand::Setup(CLI::App& cameras) {
  app_ = cameras.add_subcommand(
      "try", "Compare a camera's drawings of the fiducial marks with a scan, in a picture");
  app_->add_option("CAMERA", camera_, "Camera file, or a name from the library")->required();
  app_->add_option("SCAN", scan_path_, "Scan that shows the marks")->required();
  app_->add_option("--out", out_, "Picture to write (.png)")->required();
  AddCameraLibraryOption(*app_, &library_);
  AddMeasurementsOption(*app_, &measurements_);
  AddScanOptions(*app_, &scan_);
  AddOverwriteOption(*app_, &overwrite_);
}

ExitCode TryCameraCommand::Run(const std::string& library, std::ostream& out) const {
  RefuseToOverwrite({out_}, overwrite_);
  const std::string camera_file =
      block::FindCameraFile(camera_, library_.empty() ? library : library_);
  RefuseToReplaceInputs({out_}, {scan_path_, camera_file});
  const CameraFile camera = ReadCameraFile(camera_file);
  if (camera.camera.kind == CameraKind::kDigital)
    throw InputError(camera_ + " is a digital camera, which has no fiducial marks to try");
  const interior::MarkShapes shapes = block::LoadMarkShapes(camera);
  const Raster scan = Raster::OpenScan(scan_path_);
  interior::InteriorOptions options;
  options.pixel_size_um = scan_.pixel_size_um;
  options.polarity = scan_.polarity;
  options.orientation = scan_.orientation;
  options = block::WithMarksOf(measurements_, PhotoName(scan_path_), options);
  const InteriorResult result = OrientInterior(scan, camera, shapes, options);
  Print(result, out);
  const auto drawn = DrawnMarks(result, camera, shapes);
  if (drawn.empty()) {
    out << "No mark was found, so there is nothing to draw; click two marks (--measurements), or "
           "give --pixel-size-um.\n";
    return ExitCode::kSomeNotOriented;
  }
  const Matrix2d pixel_from_mm = PixelFromMm(result, scan, options);
  const bool negative = result.polarity.value_or(options.polarity.value_or(Polarity::kPositive)) ==
                        Polarity::kNegative;
  const interior::Picture picture = DrawDrawings(scan, drawn, pixel_from_mm, negative);
  WritePng(out_, picture.width, picture.height, 3, picture.rgb);
  if (result.photo_from_pixel)
    PrintBetterDrawings(camera, result, scan, pixel_from_mm, out);
  else
    out << fmt::format(
        "There is no transform: the outlines are drawn at {:.1f} um a pixel, upright{}.\n",
        1e3 / std::sqrt(std::abs(pixel_from_mm.determinant())),
        options.orientation ? " as --orientation says" : "");
  out << "picture   " << out_ << "\n";
  return result.status == Status::kFailed ? ExitCode::kSomeNotOriented : ExitCode::kAllDone;
}

}  // namespace orient
