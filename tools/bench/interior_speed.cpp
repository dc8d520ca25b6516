// Time and memory of the interior orientation of one scan, compared with reading its windows with
// GDAL alone.
//
//   interior_speed FOLDER [SCAN CAMERA.toml]
//
// Simulates a 23 cm film with 8 marks at 25 um in FOLDER (about two minutes, once), or takes the
// given scan; writes it as tiled JPEG, tiled LZW and striped uncompressed TIFF; then, in separate
// processes and alternately, reads the windows of 15 mm around the marks with GDAL and orients the
// scan. Prints medians of seven runs, their ratios and the peak resident memory. On one core,
// processor time is compared, which other programs do not affect; on all cores, elapsed time.
#include <gdal_priv.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <stdexcept>

#include "block/inputs/mark_shapes.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/files/camera_file.h"
#include "interior/constellation/layout.h"
#include "interior/interior.h"
#include "tools/commands/memory.h"
#include "tools/simulate/simulate.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kRepeats = 7;
constexpr double kWindowMm = 15;

struct Measured {
  double milliseconds = 0;  // elapsed
  double processor = 0;     // ms of processor time
  double peak_mb = 0;
};

double ProcessorMs() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

class Stopwatch {
 public:
  Measured Stop() const {
    const std::chrono::duration<double, std::milli> elapsed = Clock::now() - start_;
    return {elapsed.count(), ProcessorMs() - processor_, 0};
  }

 private:
  Clock::time_point start_ = Clock::now();
  double processor_ = ProcessorMs();
};

// Reads each window once in the file's own pixel type: the minimum for a program that knows where
// to look.
Measured TimeReading(const std::string& path, const CameraFile& camera) {
  GDALAllRegister();
  const Stopwatch watch;
  const GDALDatasetUniquePtr scan(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER));
  if (!scan) throw InputError(path + ": cannot be read");
  const Eigen::Vector2i size(scan->GetRasterXSize(), scan->GetRasterYSize());
  const char* resolution = scan->GetMetadataItem("TIFFTAG_XRESOLUTION");  // pixels per cm
  const double pixel_mm = 10 / std::atof(resolution);
  const interior::MarkRectangle rectangle = interior::RectangleOfMarks(camera.fiducials);
  const int side = static_cast<int>(std::ceil(kWindowMm / pixel_mm));
  std::vector<unsigned char> grey(static_cast<size_t>(side) * side);
  for (const Fiducial& mark : camera.fiducials) {
    const Eigen::Vector2d place =
        interior::PlaceOnScan(mark.position_mm, rectangle, ScanOrientation::kR0) / pixel_mm +
        0.5 * size.cast<double>();
    const int col = std::clamp(static_cast<int>(place.x()) - side / 2, 0, size.x() - side);
    const int row = std::clamp(static_cast<int>(place.y()) - side / 2, 0, size.y() - side);
    if (scan->GetRasterBand(1)->RasterIO(GF_Read, col, row, side, side, grey.data(), side, side,
                                         GDT_Byte, 0, 0, nullptr) != CE_None)
      throw InputError(path + ": cannot be read");
  }
  return watch.Stop();
}

Measured TimeOrienting(const std::string& path, const CameraFile& camera) {
  GDALAllRegister();
  const interior::MarkShapes shapes = block::LoadMarkShapes(camera);
  const Stopwatch watch;
  const InteriorResult result = interior::OrientInterior(Raster::Open(path), camera, shapes);
  const Measured time = watch.Stop();
  if (result.status != Status::kOk) {
    std::string messages;
    for (const std::string& message : Sentences(result.findings)) messages += "\n  " + message;
    throw InputError(path + " is not oriented:" + messages);
  }
  return time;
}

// Runs this program again with a command of its own, so that caches are not inherited. A child's
// peak memory starts from its parent's, so this process itself must stay small.
Measured InOwnProcess(const char* program, const std::vector<std::string>& arguments) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("pipe");
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    std::vector<char*> words = {const_cast<char*>(program)};
    for (const std::string& word : arguments) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    execv("/proc/self/exe", words.data());
    _exit(127);
  }
  close(ends[1]);
  std::string text;
  char buffer[256];
  for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<size_t>(n));
  close(ends[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) throw std::runtime_error("a run failed");
  Measured run;
  char* rest = nullptr;
  run.milliseconds = std::strtod(text.c_str(), &rest);
  run.processor = std::strtod(rest, nullptr);
  run.peak_mb = static_cast<double>(usage.ru_maxrss) / 1024;
  return run;
}

Measured Median(const std::vector<Measured>& runs) {
  std::vector<double> elapsed, processor;
  Measured median;
  for (const Measured& run : runs) {
    elapsed.push_back(run.milliseconds);
    processor.push_back(run.processor);
    median.peak_mb = std::max(median.peak_mb, run.peak_mb);
  }
  median.milliseconds = UpperMedian(std::move(elapsed));
  median.processor = UpperMedian(std::move(processor));
  return median;
}

void Copy(const std::string& from, const std::string& to, const char* const* settings) {
  GDALAllRegister();
  const GDALDatasetUniquePtr scan(GDALDataset::Open(from.c_str(), GDAL_OF_RASTER));
  GDALDriver* tiff = GetGDALDriverManager()->GetDriverByName("GTiff");
  if (!scan || tiff == nullptr) throw InputError(from + ": cannot be read");
  const GDALDatasetUniquePtr copy(
      tiff->CreateCopy(to.c_str(), scan.get(), 0, const_cast<char**>(settings), nullptr, nullptr));
  if (!copy) throw InputError(to + ": cannot be written");
}

constexpr const char* kForms[] = {"tiled_jpeg.tif", "tiled_lzw.tif", "striped_uncompressed.tif"};

void WriteScans(const std::string& scan, const fs::path& folder) {
  const char* const jpeg[] = {"TILED=YES", "COMPRESS=JPEG", "JPEG_QUALITY=90", nullptr};
  const char* const lzw[] = {"TILED=YES", "COMPRESS=LZW", nullptr};
  const char* const plain[] = {nullptr};
  const char* const* const settings[] = {jpeg, lzw, plain};
  for (std::size_t i = 0; i < std::size(kForms); ++i)
    if (const fs::path path = folder / kForms[i]; !fs::exists(path))
      Copy(scan, path.string(), settings[i]);
}

void SimulateFilm(const fs::path& folder) {
  SimulationOptions film;
  film.photos = 1;
  film.camera = CameraPreset::kRc30;
  film.pixel_size_um = 25;
  film.gsd_m = 0.3;
  film.relief_m = 10;
  film.dem_cell_m = 50;
  film.objects = false;
  film.old_gsd_ratio = 5;
  Simulate(film, folder.string());
}

void Compare(const char* program, const fs::path& folder, std::string scan, std::string camera) {
  fs::create_directories(folder);
  if (scan.empty()) {
    const fs::path block = folder / "simulated";
    camera = (block / "camera.toml").string();
    scan = (block / "scans" / "new_1_1.tif").string();
    if (!fs::exists(block / "truth.json")) InOwnProcess(program, {"--simulate", block.string()});
  }
  std::printf("%-26s %29s %29s %8s\n", "", "one core, processor ms", "all cores, elapsed ms",
              "peak");
  std::printf("%-26s %10s %10s %7s %10s %10s %7s %8s\n", "scan", "reading", "orienting", "ratio",
              "reading", "orienting", "ratio", "MB");
  InOwnProcess(program, {"--write-forms-of", scan, folder.string()});
  for (const char* form : kForms) {
    const std::string path = (folder / form).string();
    std::vector<Measured> reading, one, all;
    for (int i = 0; i < kRepeats; ++i) {
      reading.push_back(InOwnProcess(program, {"--read", path, camera}));
      one.push_back(InOwnProcess(program, {"--orient-on-one-core", path, camera}));
      all.push_back(InOwnProcess(program, {"--orient", path, camera}));
    }
    const Measured read = Median(reading), single = Median(one), every = Median(all);
    std::printf("%-26s %10.1f %10.1f %7.2f %10.1f %10.1f %7.2f %8.0f\n", form, read.processor,
                single.processor, single.processor / read.processor, read.milliseconds,
                every.milliseconds, every.milliseconds / read.milliseconds,
                std::max(single.peak_mb, every.peak_mb));
  }
}

int Run(const char* program, const std::vector<std::string>& words) {
  if (words.size() == 2 && words[0] == "--simulate") {
    SimulateFilm(words[1]);
    return 0;
  }
  if (words.size() == 3 && words[0] == "--write-forms-of") {
    WriteScans(words[1], words[2]);
    return 0;
  }
  if (words.size() == 3 && words[0].starts_with("--")) {
    const CameraFile camera = ReadCameraFile(words[2]);
    std::optional<tbb::global_control> limit;
    if (words[0] == "--orient-on-one-core")
      limit.emplace(tbb::global_control::max_allowed_parallelism, 1);
    const Measured time =
        words[0] == "--read" ? TimeReading(words[1], camera) : TimeOrienting(words[1], camera);
    std::printf("%.4f %.4f\n", time.milliseconds, time.processor);
    return 0;
  }
  if (words.size() != 1 && words.size() != 3) {
    std::cerr << "usage: interior_speed FOLDER [SCAN CAMERA.toml]\n";
    return 1;
  }
  Compare(program, words[0], words.size() == 3 ? words[1] : "", words.size() == 3 ? words[2] : "");
  return 0;
}

}  // namespace
}  // namespace orient

int main(int argc, char** argv) {
  orient::KeepReleasedMemory();
  try {
    return orient::Run(argv[0], {argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::cerr << "interior_speed: " << error.what() << "\n";
    return 2;
  }
}
