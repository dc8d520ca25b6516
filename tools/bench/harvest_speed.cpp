// Patches per second harvested from one large photo, and the memory needed.
//
//   harvest_speed FOLDER [SIDE]
//
// Makes a digital frame of SIDE x SIDE pixels (9200) with synthetic texture in FOLDER, once, as
// tiled TIFF; then harvests it, each time in a separate process: with the default of about 800
// patches, and with one every 60 pixels. Prints the number of patches, elapsed and processor time,
// patches per second of either, processor time as a multiple of that for reading the photo once,
// and the peak resident memory. On a busy machine, processor time counts: two cores give twice its
// patches per second.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <random>

#include "patchdb/harvest/harvest.h"
#include "tools/simulate/geotiff.h"

namespace orient {
namespace {
using Clock = std::chrono::steady_clock;

// Grey values interpolated between random nodes `step` apart, for several steps: multi-scale
// texture.
class Texture {
 public:
  explicit Texture(int side) {
    std::mt19937 random(1);
    for (const int step : {6, 17, 60, 250}) {
      const int nodes = side / step + 2;
      std::vector<float> values(static_cast<std::size_t>(nodes) * static_cast<std::size_t>(nodes));
      for (float& value : values) value = static_cast<float>(random() % 64);
      layers_.push_back({step, nodes, std::move(values)});
    }
  }
  float At(int col, int row) const {
    float sum = 0;
    for (const Layer& layer : layers_) {
      const int c = col / layer.step, r = row / layer.step;
      const float u = float(col % layer.step) / float(layer.step);
      const float v = float(row % layer.step) / float(layer.step);
      const float* node = layer.values.data() + std::ptrdiff_t(r) * layer.nodes + c;
      sum += (1 - v) * ((1 - u) * node[0] + u * node[1]) +
             v * ((1 - u) * node[layer.nodes] + u * node[layer.nodes + 1]);
    }
    return sum;
  }

 private:
  struct Layer {
    int step, nodes;
    std::vector<float> values;
  };
  std::vector<Layer> layers_;
};

void MakePhoto(const std::string& path, int side) {
  constexpr int kRows = 256;
  simulation::SparseTiff file(path, {side, side, 1, 8}, 0.01);
  const Texture texture(side);
  for (int row = 0; row < side; row += kRows) {
    const int rows = std::min(kRows, side - row);
    std::vector<std::uint16_t> values;
    for (int r = 0; r < rows; ++r)
      for (int col = 0; col < side; ++col)
        values.push_back(static_cast<std::uint16_t>(texture.At(col, row + r)));
    file.Write({0, row}, {side, rows}, values);
  }
  file.Finish();
}

// Near-vertical view of gentle hills, GSD 0.25 m.
PhotoView View(int side) {
  PhotoView view;
  view.camera.kind = CameraKind::kDigital;
  view.camera.principal_distance_mm = 100;
  view.camera.image_px = Eigen::Vector2i(side, side);
  view.camera.frame_mm = Eigen::Vector2d::Constant(0.01 * side);
  view.photo_from_pixel = DigitalPhotoFromPixel(view.camera);
  view.pose = {{500000, 5000000, 2700}, {0.01, -0.01, 0.3}};
  return view;
}

GroundSurface Hills() {
  Eigen::MatrixXf heights(900, 900);
  for (int row = 0; row < 900; ++row)
    for (int col = 0; col < 900; ++col)
      heights(row, col) =
          static_cast<float>(200 + 20 * std::sin(0.03 * col) * std::cos(0.02 * row));
  return GroundSurface::FromGrid(heights, 497750, 5002250, 5);
}

struct Time {
  double elapsed = 0, processor = 0;
};

template <typename Work>
Time Measure(const Work& work) {
  const auto start = Clock::now();
  const std::clock_t processor = std::clock();
  work();
  return {std::chrono::duration<double>(Clock::now() - start).count(),
          double(std::clock() - processor) / CLOCKS_PER_SEC};
}

void Report(const std::string& path, int side, const std::optional<double>& spacing_px) {
  const Raster photo = Raster::Open(path);
  const Time reading = Measure([&] {
    for (int row = 0; row < side; row += 256)
      photo.ReadGrey({0, row, side, std::min(256, side - row)});
  });
  patchdb::HarvestOptions options;
  options.spacing_px = spacing_px;
  std::size_t patches = 0;
  const GroundSurface surface = Hills();
  const Time harvest = Measure([&] {
    patches =
        patchdb::HarvestPhoto(photo, View(side), std::nullopt, surface, options).patches.size();
  });
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "%-10s %6zu patches, %.1f s elapsed, %.1f s processor (%.1f x reading): %.0f a second, "
      "%.0f a second of processor time, peak %.0f MB\n",
      spacing_px ? "every 60" : "default", patches, harvest.elapsed, harvest.processor,
      harvest.processor / reading.processor, double(patches) / harvest.elapsed,
      double(patches) / harvest.processor, double(usage.ru_maxrss) / 1024);
}

}  // namespace
}  // namespace orient

int main(int count, char** words) {
  if (count < 2) {
    std::cerr << "usage: harvest_speed FOLDER [SIDE]\n";
    return 1;
  }
  const int side = count > 2 ? std::atoi(words[2]) : 9200;
  const std::string path = std::string(words[1]) + "/harvest_" + std::to_string(side) + ".tif";
  if (!std::filesystem::exists(path)) orient::MakePhoto(path, side);
  for (const std::optional<double> spacing : {std::optional<double>(), std::optional<double>(60)}) {
    const pid_t child = fork();
    if (child == 0) {
      orient::Report(path, side, spacing);
      std::fflush(stdout);
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
  }
  return 0;
}
