// How often a photo is `ok` but wrong: random worlds, cameras, faults and wrong inputs.
//
//   false_ok FOLDER WORLDS [FIRST] [ONLY]
//
// WORLDS worlds from number FIRST (1) on: a small simulated block of two photos with random camera,
// scan, terrain and season (false_ok_world.h), oriented first with true inputs, then five times
// with one or two inputs falsified (false_ok_faults.h; ONLY: by that fault alone). A world is
// determined by its number. Every photo of every trial is a line of FOLDER/photos.csv; worlds
// already in it are not repeated, so that a run may be interrupted and continued. The folder of a
// world with a false `ok` is kept, with the commands in a file `again`.
//
// Interior orientation is wrong if the RMS difference of its transform from the true one over the
// whole film exceeds a pixel, beyond what the film deformation explains. Exterior orientation is
// wrong if pose, film transform and camera together project the check points with an RMS error of
// more than a pixel (or the stated target accuracy, if larger), and always if the patches are not
// of the photo's ground. Prints how the photos end, how many of those that are ok are wrong, and
// the upper bound of the rate of wrong photos at 95 % confidence (Clopper and Pearson 1934).
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "block/inputs/block_photos.h"
#include "block/inputs/mark_shapes.h"
#include "block/inputs/photo_interior.h"
#include "core/base/atomic_write.h"
#include "core/base/binomial.h"
#include "interior/interior.h"
#include "tools/bench/false_ok_faults.h"

namespace orient::false_ok {
namespace {

constexpr double kWrong_px = 1;
constexpr int kTrials = 5;
constexpr const char* kHeader =
    "world,faults,photo,camera,interior,interior_px,exterior,exterior_px,limit_px,false_interior,"
    "false_exterior";

struct Outcome {
  std::string faults, photo;
  int camera = 0;
  std::string interior = "none", exterior = "none";  // a status; none: no result
  double interior_px = 0, exterior_px = 0, limit_px = kWrong_px;
  bool false_interior = false, false_exterior = false;

  std::string Row(std::uint32_t world) const {
    return fmt::format("{},{},{},{},{},{:.3f},{},{:.3f},{:.3f},{:d},{:d}\n", world, faults, photo,
                       camera, interior, interior_px, exterior, exterior_px, limit_px,
                       false_interior, false_exterior);
  }
};

nlohmann::json TruthOf(const Shown& shown) {
  return nlohmann::json::parse(ReadFile(shown.folder + "/truth.json"));
}
nlohmann::json PhotoOf(const nlohmann::json& truth, const std::string& name) {
  for (const auto& photo : truth.at("photos"))
    if (photo.at("photo") == name) return photo;
  throw InputError("truth.json lacks " + name);
}

// RMS difference of a transform to the photo system from the true one, px, less film deformation.
double FilmError(const InteriorResult& found, const Shown& shown) {
  const InteriorResult truth =
      ReadInteriorResult(InteriorResultPath(shown.folder + "/truth/interior", shown.photo));
  const auto correction = block::CorrectionOf(found);
  constexpr int kGrid = 6;
  double sum = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const int row = i / kGrid, col = i % kGrid;
    const Eigen::Vector2d pixel((col + 0.5) / kGrid * truth.width,
                                (row + 0.5) / kGrid * truth.height);
    const Eigen::Vector2d photo_mm =
        PhotoFromPixel(*found.photo_from_pixel, correction.get(), shown.moved(pixel));
    sum += (photo_mm - *truth.photo_from_pixel * pixel).squaredNorm();
  }
  const double bend_mm =
      1e-3 * PhotoOf(TruthOf(shown), shown.photo).at("bend_rms_um").get<double>();
  const double rms_mm = std::max(0.0, std::sqrt(sum / (kGrid * kGrid)) - 2 * bend_mm);
  return rms_mm / std::sqrt(std::abs(truth.photo_from_pixel->A.determinant()));
}

// The smallest error among the possible scan orientations; exterior orientation decides on one.
double FilmErrorOfAny(const InteriorResult& found, const CameraFile& camera,
                      const interior::MarkShapes& marks, const Shown& shown) {
  double best = FilmError(found, shown);
  for (const ScanOrientation orientation : found.possible_orientations)
    if (const auto turned = interior::InOrientation(found, camera, marks, orientation))
      best = std::min(best, FilmError(*turned, shown));
  return best;
}

// RMS error at the check points, pixels.
double PoseError(const PhotoView& view, const Shown& shown) {
  const nlohmann::json truth = TruthOf(shown), photo = PhotoOf(truth, shown.photo);
  double sum = 0;
  int count = 0;
  for (const auto& check : photo.at("check")) {
    const auto& point = truth.at("check_points").at(check.at("point").get<std::size_t>());
    const Eigen::Vector2d pixel(check.at("pixel").at(0).get<double>(),
                                check.at("pixel").at(1).get<double>());
    const auto found = view.PixelFromGround(
        {point.at(0).get<double>(), point.at(1).get<double>(), point.at(2).get<double>()});
    sum += found ? (*found - shown.moved(pixel)).squaredNorm() : 1e12;
    ++count;
  }
  if (count == 0) throw InputError(shown.folder + ": no check point lies in " + shown.photo);
  return std::sqrt(sum / count);
}

class TrialRun {
 public:
  TrialRun(const World& world, const Trial& trial, std::string faults)
      : world_(world), trial_(trial), faults_(std::move(faults)), folder_(trial.folder) {
    fs::create_directories(folder_ + "/given");
    for (const auto& [name, path] : trial.photos)
      fs::create_symlink(fs::absolute(path), Given(name));
    WriteOrientationTable(folder_ + "/given/start.csv", trial.approximations);
  }

  std::vector<Outcome> Outcomes() {
    const bool film = !world_.Digital();
    if (film) Command("interior", Interior());
    Command("exterior", Exterior(film));
    std::vector<Outcome> outcomes;
    for (const auto& [name, path] : trial_.photos) outcomes.push_back(OutcomeOf(name, film));
    return outcomes;
  }
  const std::string& Commands() const { return commands_; }

 private:
  std::string Given(const std::string& name) const { return folder_ + "/given/" + name + ".tif"; }
  std::vector<std::string> Interior() const {
    return {folder_ + "/given/*.tif", "--camera", trial_.camera, "--out", folder_ + "/interior"};
  }
  std::vector<std::string> Exterior(bool film) const {
    std::vector<std::string> words = {folder_ + "/given/*.tif",
                                      "--camera",
                                      trial_.camera,
                                      "--approximations",
                                      folder_ + "/given/start.csv",
                                      "--dem",
                                      trial_.dem,
                                      "--patchdb",
                                      trial_.patchdb,
                                      "--no-feedback",
                                      "--jobs",
                                      "1",
                                      "--out",
                                      folder_ + "/exterior"};
    if (film) words.insert(words.end(), {"--interior", folder_ + "/interior"});
    return words;
  }
  void Command(const std::string& command, std::vector<std::string> words) {
    const auto& more = command == "interior" ? trial_.interior_words : trial_.exterior_words;
    words.insert(words.begin(), command);
    words.insert(words.end(), more.begin(), more.end());
    commands_ += fmt::format("orient {}\n", fmt::join(words, " "));
    std::string said;
    const int code = Run(words, &said);
    if (code < 0 || code > 3)
      throw std::runtime_error(fmt::format("{}: exit {}: {}", commands_, code, said));
  }

  Outcome OutcomeOf(const std::string& name, bool film) const {
    Outcome outcome{faults_, name, static_cast<int>(world_.Options().camera)};
    const CameraFile camera = ReadCameraFile(trial_.camera);
    const interior::MarkShapes marks = block::LoadMarkShapes(camera);
    const Shown& shown = trial_.shows.at(name);
    const std::string interior = InteriorResultPath(folder_ + "/interior", name);
    if (film && fs::exists(interior)) {
      const InteriorResult result = ReadInteriorResult(interior);
      outcome.interior = Name(result.status);
      if (result.photo_from_pixel)
        outcome.interior_px = FilmErrorOfAny(result, camera, marks, shown);
      outcome.false_interior = result.status == Status::kOk && !trial_.marks_are_wrong &&
                               !(outcome.interior_px <= kWrong_px);
    }
    const std::string exterior = ExteriorResultPath(folder_ + "/exterior", name);
    if (!fs::exists(exterior)) return outcome;
    const ExteriorResult result = ReadExteriorResult(exterior);
    outcome.exterior = Name(result.status);
    if (!result.pose) return outcome;
    // By the name it is given under, which is that of its results.
    outcome.exterior_px =
        PoseError(block::ReadBlockPhoto(Given(name), exterior, camera, marks, folder_ + "/interior")
                      .View(camera.camera),
                  shown);
    outcome.limit_px = std::max(kWrong_px, result.target_m.value_or(0) / world_.Options().gsd_m);
    outcome.false_exterior = result.status == Status::kOk &&
                             (trial_.unrelated || !(outcome.exterior_px <= outcome.limit_px));
    return outcome;
  }

  const World& world_;
  const Trial& trial_;
  std::string faults_, folder_, commands_;
};

// Applies one or two faults; returns their names.
std::string Falsify(World& world, Trial& trial, const std::string& only) {
  std::string names;
  const int count = only.empty() && world.Random().Happens(0.3) ? 2 : 1;
  for (int i = 0; i < count;) {
    const Fault& fault = world.Random().OneOf(kFaults);
    if (!only.empty() ? fault.name != only : fault.of_film && world.Digital()) continue;
    fault.falsify(world, trial);
    names += (names.empty() ? "" : "+") + std::string(fault.name);
    ++i;
  }
  return names;
}

// Runs a world; returns its rows.
std::string RowsOf(const std::string& folder, std::uint32_t number, const std::string& only) {
  World world(folder + "/world_" + std::to_string(number), number);
  std::string rows, again;
  for (int i = 0; i <= kTrials; ++i) {
    Trial trial = world.True(i);
    const std::string faults = i == 0 ? "none" : Falsify(world, trial, only);
    TrialRun run(world, trial, faults);
    for (const Outcome& outcome : run.Outcomes()) {
      rows += outcome.Row(number);
      if (outcome.false_interior || outcome.false_exterior)
        again += outcome.Row(number) + run.Commands();
    }
  }
  if (again.empty())
    world.Remove();
  else
    WriteFileAtomically(world.Folder() + "/again", again);
  return rows;
}

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

struct Count {
  int photos = 0, interior_ok = 0, interior_false = 0, ok = 0, weak = 0, failed = 0, wrong = 0;

  void Add(const std::vector<std::string>& cells) {
    ++photos;
    interior_ok += cells[4] == "ok";
    ok += cells[6] == "ok";
    weak += cells[6] == "weak";
    failed += cells[6] == "failed";
    interior_false += cells[9] == "1";
    wrong += cells[10] == "1";
  }
  void Print(const std::string& name) const {
    std::printf("%-28s %7d | %6d %4d | %6d %6d %6d %4d\n", name.c_str(), photos, interior_ok,
                interior_false, ok, weak, failed, wrong);
  }
};

void Report(const std::string& table) {
  std::map<std::string, Count> counts;
  Count all;
  std::ifstream file(table);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    const auto cells = Cells(line);
    all.Add(cells);
    std::istringstream faults(cells[1]);
    for (std::string fault; std::getline(faults, fault, '+');) counts[fault].Add(cells);
  }
  std::printf("%-28s %7s | interior ok, false | exterior ok, weak, failed, false\n", "fault",
              "photos");
  for (const auto& [fault, count] : counts) count.Print(fault);
  all.Print("all photos (two faults: once)");
  std::printf("false ok at most %.2g of the photos that are ok, interior %.2g (95 %%)\n",
              UpperBoundOfRate(all.wrong, all.ok, 0.05),
              UpperBoundOfRate(all.interior_false, all.interior_ok, 0.05));
}

int Main(const std::string& folder, std::uint32_t worlds, std::uint32_t first,
         const std::string& only) {
  fs::create_directories(folder);
  const std::string table = folder + "/photos.csv";
  if (!fs::exists(table)) std::ofstream(table) << kHeader << "\n";
  std::set<std::string> done;
  std::ifstream file(table);
  for (std::string line; std::getline(file, line);) done.insert(line.substr(0, line.find(',')));
  for (std::uint32_t number = first; number < first + worlds; ++number) {
    if (done.contains(std::to_string(number))) continue;
    try {
      const std::string rows = RowsOf(folder, number, only);
      std::ofstream(table, std::ios::app) << rows << std::flush;
      std::printf("\rworld %u ", number);
    } catch (const UsageError& error) {  // terrain that the simulator refuses: no photos
      std::printf("\rworld %u is none: %s\n", number, error.what());
    }
    std::fflush(stdout);
  }
  std::printf("\n");
  Report(table);
  return 0;
}

}  // namespace
}  // namespace orient::false_ok

int main(int argc, char** argv) {
  const auto word = [&](int i, const char* otherwise) { return argc > i ? argv[i] : otherwise; };
  if (argc < 3) {
    std::fprintf(stderr, "usage: false_ok FOLDER WORLDS [FIRST] [ONLY]\n");
    return 1;
  }
  try {
    return orient::false_ok::Main(argv[1], static_cast<std::uint32_t>(std::atoi(argv[2])),
                                  static_cast<std::uint32_t>(std::atoi(word(3, "1"))), word(4, ""));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "false_ok: %s\n", error.what());
    return 2;
  }
}
