#include "tools/commands/cameras/new_camera_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <ostream>
#include <set>
#include <utility>

#include "block/inputs/mark_shapes.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/table_text.h"
#include "core/files/orientation_table.h"
#include "interior/interior.h"
#include "interior/marks/mark_picture.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// ID=COL,ROW.
interior::MarkClick ClickIn(const std::string& text) {
  const size_t equals = text.find('='), comma = text.find(',', equals + 1);
  const bool parts = equals != std::string::npos && equals > 0 && comma != std::string::npos;
  const auto col = parts ? NumberIn(text.substr(equals + 1, comma - equals - 1)) : std::nullopt;
  const auto row = parts ? NumberIn(text.substr(comma + 1)) : std::nullopt;
  if (!col || !row)
    throw UsageError(fmt::format("--mark {}: give ID=COL,ROW, as in --mark 1=812,640", text));
  interior::MarkClick click;
  click.pixel = {*col, *row};
  click.mark = text.substr(0, equals);
  click.sigma_px = 1.5;  // read from a viewer that shows whole pixels
  return click;
}

std::vector<block::StatedPosition> ReadPositions(const std::string& path) {
  NamedTable table(path, {"mark", "x_mm", "y_mm"}, {});
  std::vector<block::StatedPosition> positions;
  std::set<std::string> named;
  while (table.Next()) {
    positions.push_back({table.Name("mark"), {table.Number("x_mm"), table.Number("y_mm")}});
    if (!named.insert(positions.back().mark).second)
      table.Fail("mark", fmt::format("mark {} is given a second time", positions.back().mark));
  }
  if (positions.size() < 3)
    throw InputError(
        fmt::format("{}: {} positions; three or more are needed", path, positions.size()));
  return positions;
}

std::vector<block::StatedDistance> ReadDistances(const std::string& path) {
  NamedTable table(path, {"from", "to", "distance_mm"}, {"sigma_mm"});
  std::vector<block::StatedDistance> distances;
  while (table.Next()) {
    block::StatedDistance distance{table.Name("from"), table.Name("to"),
                                   table.PositiveNumber("distance_mm")};
    if (table.Has("sigma_mm")) distance.sigma_mm = table.PositiveNumber("sigma_mm");
    if (distance.from == distance.to)
      table.Fail("to", fmt::format("the distance of mark {} from itself", distance.to));
    distances.push_back(std::move(distance));
  }
  if (distances.empty()) throw InputError(path + ": holds no distance");
  return distances;
}

std::string PathBeside(const std::string& camera_path, const std::string& ending) {
  return fs::path(camera_path).replace_extension().string() + ending;
}

// Names the pictures of the marks: a mark's id may be anything, so they are numbered.
void NamePictures(const std::string& camera_path, block::NewCamera* made) {
  int number = 0;
  for (const auto& [name, picture] : made->pictures)
    made->file.marks.at(name).image.value().path =
        PathBeside(camera_path, fmt::format("_mark_{}.png", ++number));
}

std::vector<std::string> PicturePaths(const block::NewCamera& made) {
  std::vector<std::string> paths;
  for (const auto& [name, picture] : made.pictures)
    paths.push_back(made.file.marks.at(name).image.value().path);
  return paths;
}

void WritePictures(const block::NewCamera& made) {
  for (const auto& [name, picture] : made.pictures) {
    std::vector<unsigned char> grey;
    for (const float value : picture.values)
      grey.push_back(static_cast<unsigned char>(std::lround(std::clamp(value, 0.0f, 255.0f))));
    WritePng(made.file.marks.at(name).image.value().path, picture.width, picture.height, 1, grey);
  }
}

// Reads the file as a user's run would, so that errors appear now. Removes a file that is refused.
void RequireReadable(const std::string& path) {
  try {
    ReadCameraFile(path);
  } catch (const InputError&) {
    std::error_code ignored;
    fs::remove(path, ignored);
    throw;
  }
}

void RequireFolderOf(const std::string& path) {
  const fs::path folder = fs::absolute(path).parent_path();
  if (!fs::is_directory(folder))
    throw InputError(folder.string() + ": no such folder; create it, or choose another --out");
}

bool AllAreDark(const CameraFile& camera) {
  bool any = false;
  for (const auto& [name, drawing] : camera.marks)
    for (const MarkElement& element : drawing.elements) {
      any = true;
      if (BrightnessOf(element) > 0) return false;
    }
  return any;
}

// The first scan's marks with their drawings, where they were clicked there.
void WriteOverview(const std::string& path, const block::NewCamera& made,
                   const block::ClickedScan& scan, bool negative) {
  const interior::MarkShapes shapes = interior::ShapesOf(made.file, made.pictures);
  std::vector<interior::DrawnMark> drawn;
  for (const block::NewMark& mark : made.marks)
    if (mark.first_place)
      drawn.push_back({mark.id, shapes.at(mark.drawing), *mark.first_place, true});
  const interior::Picture picture =
      DrawDrawings(scan.raster, drawn, made.first_mm_from_pixel.inverse(), negative);
  WritePng(path, picture.width, picture.height, 3, picture.rgb);
}

void Print(const block::NewCamera& made, const std::vector<block::StatedDistance>& distances,
           std::ostream& out) {
  SummaryTable table({"mark", "drawing", "correlation", "scans", "x mm", "y mm", "sigma um"});
  for (size_t i = 0; i < made.marks.size(); ++i) {
    const block::NewMark& mark = made.marks[i];
    const Fiducial& fiducial = made.file.fiducials[i];
    table.AddRow({mark.id, mark.drawing,
                  mark.correlation != 0 ? Fixed(mark.correlation, 3) : "picture",
                  std::to_string(mark.scans), Fixed(fiducial.position_mm.x(), 3),
                  Fixed(fiducial.position_mm.y(), 3),
                  fiducial.sigma_mm ? Fixed(1e3 * fiducial.sigma_mm->maxCoeff(), 0) : "stated"});
  }
  table.Print(out);
  if (!made.distance_residual_mm.empty()) {
    out << "\n";
    SummaryTable residuals({"from", "to", "stated mm", "stated - adjusted um"});
    for (size_t i = 0; i < distances.size(); ++i)
      residuals.AddRow({distances[i].from, distances[i].to, Fixed(distances[i].distance_mm, 3),
                        Fixed(1e3 * made.distance_residual_mm[i], 0)});
    residuals.Print(out);
  }
}

}  // namespace

bool NewCameraCommand::Asked() const { return app_ != nullptr && app_->parsed(); }

void NewCameraCommand::Setup(CLI::App& cameras) {
  app_ = cameras.add_subcommand(
      "new", "Make a camera file from scans on which the fiducial marks were clicked");
  app_->add_option("SCAN", scans_, "Scans of one camera, preferably of one roll, twelve at most")
      ->required();
  app_->add_option("--out", out_, "Camera file to write (.toml)")->required();
  app_->add_option("--principal-distance-mm", principal_distance_mm_,
                   "Principal distance in millimetres")
      ->required()
      ->check(CLI::Range(10.0, 2000.0));
  app_->add_option("--name", name_, "Name of the camera; the file's name if not given");
  app_->add_option("--mark", clicks_,
                   "Where a mark is on the only SCAN, ID=COL,ROW in pixels; once for every mark");
  AddTableOptions();
  AddScanOptions(*app_, &scan_);
  // Before there is a camera, nothing in a scan determines them.
  app_->get_option("--polarity")->description("Polarity of the scans; auto: positive");
  app_->get_option("--orientation")
      ->description("Scan orientation where no positions determine it; auto: r0");
  app_->add_option("--scanner", scanner_, "How much the scanner or print deforms the film")
      ->check(CLI::IsMember({"desktop", "photogrammetric"}))
      ->capture_default_str();
  app_->add_option("--frame-mm", frame_mm_,
                   "Width and height of the exposed area; as far as the marks reach if not given")
      ->expected(2)
      ->check(CLI::Range(10.0, 1000.0));
  app_->add_option("--template-radius-mm", template_radius_mm_,
                   "Half side of the picture of a mark that no drawing describes")
      ->check(CLI::Range(0.2, 9.0))
      ->capture_default_str();
  AddOverwriteOption(*app_, &overwrite_);
}

void NewCameraCommand::AddTableOptions() {
  AddMeasurementsOption(*app_, &measurements_);
  CLI::Option* positions = app_->add_option("--positions", positions_,
                                            "Table of calibrated positions (CSV: mark,x_mm,y_mm)");
  app_->add_option("--distances", distances_,
                   "Table of distances between marks (CSV: from,to,distance_mm[,sigma_mm])")
      ->excludes(positions);
}

std::vector<block::ClickedScan> NewCameraCommand::Scans() const {
  constexpr size_t kMostScans = 12;
  if (scans_.size() > kMostScans)
    throw UsageError(
        fmt::format("{} scans; give {} at most, then 'orient interior estimate-camera'",
                    scans_.size(), kMostScans));
  if (!clicks_.empty() && scans_.size() > 1)
    throw UsageError("--mark is for one SCAN; for several give --measurements with marks.csv");
  std::vector<block::ClickedScan> scans;
  for (const std::string& path : scans_) {
    block::ClickedScan scan{PhotoName(path), Raster::OpenScan(path), {}};
    for (const MarkMeasurement& mark : measurements_.MarksOf(scan.photo))
      scan.clicks.push_back({mark.mark, mark.pixel, mark.sigma_px, mark.exact});
    for (const std::string& text : clicks_) {
      scan.clicks.push_back(ClickIn(text));
      const std::string& id = scan.clicks.back().mark;
      if (std::count_if(scan.clicks.begin(), scan.clicks.end(),
                        [&](const auto& click) { return click.mark == id; }) > 1)
        throw UsageError("mark " + id + " is clicked twice; keep one");
    }
    if (scan.clicks.empty())
      throw InputError(scan.photo +
                       ": no mark is clicked on it; give --mark ID=COL,ROW, or "
                       "--measurements with a marks.csv that has the photo");
    scans.push_back(std::move(scan));
  }
  return scans;
}

block::NewCameraOptions NewCameraCommand::Options() const {
  block::NewCameraOptions options;
  options.name = name_.empty() ? fs::path(out_).stem().string() : name_;
  options.principal_distance_mm = principal_distance_mm_;
  if (!frame_mm_.empty()) options.frame_mm = Eigen::Vector2d(frame_mm_[0], frame_mm_[1]);
  if (!positions_.empty()) options.positions = ReadPositions(positions_);
  if (!distances_.empty()) options.distances = ReadDistances(distances_);
  options.pixel_size_um = scan_.pixel_size_um;
  options.orientation = scan_.orientation.value_or(ScanOrientation::kR0);
  options.polarity = scan_.polarity.value_or(Polarity::kPositive);
  options.photogrammetric = scanner_ == "photogrammetric";
  options.template_radius_mm = template_radius_mm_;
  return options;
}

std::vector<std::string> NewCameraCommand::Inputs() const {
  std::vector<std::string> inputs = scans_;
  Append({positions_, distances_}, &inputs);
  Append(MeasurementFiles(measurements_.folder), &inputs);
  return inputs;
}

ExitCode NewCameraCommand::Run(std::ostream& out) const {
  constexpr double kLargestFrame_mm = 320;
  const std::string overview = PathBeside(out_, ".marks.png");
  RequireFolderOf(out_);
  RefuseToReplaceInputs({out_, overview}, Inputs());
  RefuseToOverwrite({out_, overview}, overwrite_);
  const block::NewCameraOptions options = Options();
  const std::vector<block::ClickedScan> scans = Scans();
  block::NewCamera made = MakeCamera(scans, options);
  NamePictures(out_, &made);
  RefuseToReplaceInputs(PicturePaths(made), Inputs());
  RefuseToOverwrite(PicturePaths(made), overwrite_);
  WritePictures(made);
  WriteCameraFile(out_, made.file);
  RequireReadable(out_);
  WriteOverview(overview, made, scans.front(), options.polarity == Polarity::kNegative);
  Print(made, options.distances, out);
  out << "\nscale     " << Fixed(made.pixel_size_um, 2) << " um a pixel on " << scans.front().photo
      << ", from " << made.scale_from << "\ncamera    " << out_ << "\npicture   " << overview
      << ": every outline should lie on its mark\n";
  // Desktop scanners and prints differ by some tenths of a percent.
  constexpr double kAlike = 0.005;
  if (options.distances.empty() && made.scale_difference > kAlike)
    out << fmt::format(
        "The scans' own scales differ by up to {:.1f} % from their median, which the camera has: "
        "give --distances or --positions.\n",
        100 * made.scale_difference);
  const Eigen::Vector2d& frame = made.file.camera.frame_mm;
  if (!options.frame_mm)
    out << "The frame is taken to end at the marks (" << Fixed(frame.x(), 1) << " x "
        << Fixed(frame.y(), 1) << " mm); give --frame-mm if not.\n";
  if (frame.maxCoeff() > kLargestFrame_mm)
    out << "Hardly any aerial camera has a frame that large: check the scale and the positions' "
           "origin.\n";
  if (!made.origin_known)
    out << "No two pairs of marks lie opposite each other: the origin is the marks' mean, not the "
           "principal point. Give --positions, or correct principal_point_mm in the file.\n";
  if (AllAreDark(made.file))
    out << "All marks are drawn darker than their surroundings on the positive: is the scan a "
           "negative (--polarity negative)?\n";
  return ExitCode::kAllDone;
}

}  // namespace orient
