// Faults of false_ok: each falsifies one of a trial's inputs.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/raster/raster.h"
#include "core/raster/resample.h"
#include "core/terrain/ground_surface.h"
#include "tools/bench/false_ok_world.h"
#include "tools/simulate/geotiff.h"

namespace orient::false_ok {

// --- Approximations

inline void StartsFarOff(World& world, Trial& trial) {
  Chance& chance = world.Random();
  const double sigmas = chance.Scale(3, 60);
  for (OrientationRow& row : trial.approximations.rows) {
    Vector6d pose = row.pose.AsVector();
    for (int i = 0; i < 4; ++i) pose[i % 3] += sigmas * World::kSigma[i % 3] * chance.Normal() / 2;
    pose[5] += sigmas * World::kSigma[5] * chance.Normal() / 4;
    row.pose = Pose::FromVector(pose);
  }
}
inline void KappaUnknown(World& world, Trial& trial) {
  for (OrientationRow& row : trial.approximations.rows) {
    row.pose.opk_rad[2] = world.Random().Between(-std::numbers::pi, std::numbers::pi);
    (*row.sigma)[5] = std::numbers::pi;
  }
}
inline void HeightsOfStartsWrong(World& world, Trial& trial) {
  const double height = world.Random().Signed(50, 600);
  for (OrientationRow& row : trial.approximations.rows) row.pose.position_m.z() += height;
}
inline void StartsExchanged(World&, Trial& trial) {
  auto& rows = trial.approximations.rows;
  std::swap(rows.front().pose, rows.back().pose);
}

// --- The camera

inline void ChangeCamera(Trial& trial, const std::function<void(CameraFile&)>& change) {
  CameraFile camera = ReadCameraFile(trial.camera);
  change(camera);
  trial.camera = trial.folder + "/camera.toml";
  WriteCameraFile(trial.camera, camera);
}
inline void WrongPrincipalDistance(World& world, Trial& trial) {
  const double factor = 1 + world.Random().Signed(0.003, 0.4);
  ChangeCamera(trial, [&](CameraFile& file) { file.camera.principal_distance_mm *= factor; });
}
inline void WrongPrincipalPoint(World& world, Trial& trial) {
  const Eigen::Vector2d shift(world.Random().Signed(0.05, 5), world.Random().Signed(0.05, 5));
  ChangeCamera(trial, [&](CameraFile& file) { file.camera.principal_point_mm += shift; });
}
inline void WrongLens(World& world, Trial& trial) {
  const double at_corner_mm = world.Random().Signed(0.02, 1);
  ChangeCamera(trial, [&](CameraFile& file) {
    const double r = file.camera.FrameRadius();
    file.camera.lens = WithRadial(file.camera.lens, {at_corner_mm / (r * r * r), 0, 0}, r);
  });
}
inline void WrongMarks(World& world, Trial& trial) {
  const double scale = 1 + world.Random().Signed(0.002, 0.2);
  const bool all = world.Random().Happens(0.5);
  const Eigen::Vector2d shift(world.Random().Signed(0.05, 3), world.Random().Signed(0.05, 3));
  trial.marks_are_wrong = true;
  ChangeCamera(trial, [&](CameraFile& file) {
    if (file.fiducials.empty()) return;
    if (!all) file.fiducials[1].position_mm += shift;
    for (Fiducial& mark : file.fiducials)
      if (all) mark.position_mm *= scale;
  });
}

// --- The terrain

inline void ChangeDem(
    World& world, Trial& trial,
    const std::function<void(std::vector<float>&, simulation::GeoReference&)>& change) {
  const Raster dem = Raster::Open(trial.dem);
  std::vector<float> heights = dem.ReadGrey().image.values;
  const auto g = dem.GeoTransform().value();
  simulation::GeoReference reference{g[0], g[3], g[1], Crs::Parse(world.Options().crs, "false_ok")};
  change(heights, reference);
  trial.dem = trial.folder + "/dem.tif";
  simulation::WriteFloatTiff(trial.dem, dem.Width(), dem.Height(), heights, reference);
}
inline void DemRaised(World& world, Trial& trial) {
  const auto height = static_cast<float>(world.Random().Signed(5, 300));
  ChangeDem(world, trial, [&](std::vector<float>& heights, auto&) {
    for (float& h : heights) h += height;
  });
}
inline void DemShifted(World& world, Trial& trial) {
  const double east = world.Random().Signed(20, 500), north = world.Random().Signed(20, 500);
  ChangeDem(world, trial, [&](auto&, simulation::GeoReference& reference) {
    reference.west_m += east;
    reference.north_m += north;
  });
}
inline void DemLevel(World& world, Trial& trial) {
  ChangeDem(world, trial, [](std::vector<float>& heights, auto&) {
    const float middle = heights[heights.size() / 2];
    std::fill(heights.begin(), heights.end(), middle);
  });
}

// --- The photos

// Position in the changed image of a pixel of the original, which is `width` wide.
using PixelIn = std::function<Eigen::Vector2d(const Eigen::Vector2d&, int width)>;

// Changes the image of every photo; `moved` gives the new positions of its pixels.
inline void ChangePhotos(World& world, Trial& trial,
                         const std::function<Image(const Image&)>& change, const PixelIn& moved) {
  // Another fault may have written its photos there, and these are made from them.
  std::string folder = trial.folder + "/photos";
  while (fs::exists(folder)) folder += "_again";
  fs::create_directories(folder);
  for (auto& [name, path] : trial.photos) {
    const Image before = Raster::Open(path).ReadGrey().image;
    const Image image = change(before);
    std::vector<std::uint16_t> values;
    for (const float value : image.values)
      values.push_back(static_cast<std::uint16_t>(std::clamp(value, 0.0f, 255.0f)));
    path = fmt::format("{}/{}.tif", folder, name);
    simulation::WriteGreyTiff(path, image.width, image.height, values, 8,
                              *world.Options().pixel_size_um / 1000, std::nullopt);
    if (!moved) continue;
    trial.shows[name].moved = [first = trial.shows[name].moved, moved,
                               width = before.width](const Eigen::Vector2d& pixel) {
      return moved(first(pixel), width);
    };
  }
}
inline int SideOf(const Trial& trial) { return Raster::Open(trial.photos.begin()->second).Width(); }
inline void PhotosMirrored(World& world, Trial& trial) {
  ChangePhotos(
      world, trial, [](const Image& image) { return Mirrored(image); },
      [](const Eigen::Vector2d& pixel, int width) {
        return Eigen::Vector2d(width - pixel.x(), pixel.y());
      });
}
// Shifted within an unchanged frame, like a crop that was put back in the wrong place.
inline void PhotosShifted(World& world, Trial& trial) {
  const int side = SideOf(trial) / 4;
  const int right = static_cast<int>(world.Random().Signed(2, side));
  const int down = static_cast<int>(world.Random().Signed(2, side));
  ChangePhotos(
      world, trial,
      [=](const Image& image) {
        Image shifted(image.width, image.height);
        for (int row = std::max(0, down); row < image.height + std::min(0, down); ++row)
          for (int col = std::max(0, right); col < image.width + std::min(0, right); ++col)
            shifted.At(col, row) = image.At(col - right, row - down);
        return shifted;
      },
      [=](const Eigen::Vector2d& pixel, int) {
        return Eigen::Vector2d(pixel + Eigen::Vector2d(right, down));
      });
}
inline void PhotosScaled(World& world, Trial& trial) {
  const double factor = world.Random().Scale(1.01, 1.6);
  const bool digital = world.Digital();  // keeps the size of its file
  ChangePhotos(
      world, trial,
      [=](const Image& image) {
        const Image reduced = ReduceBy(image, factor);
        if (!digital) return reduced;
        Image framed(image.width, image.height);
        for (int row = 0; row < reduced.height; ++row)
          std::copy_n(reduced.Row(row), reduced.width, framed.Row(row));
        return framed;
      },
      [=](const Eigen::Vector2d& pixel, int) { return Eigen::Vector2d(pixel / factor); });
}
inline void PhotosInverted(World& world, Trial& trial) {
  ChangePhotos(world, trial,
               [](Image image) {
                 for (float& value : image.values) value = 255 - value;
                 return image;
               },
               {});
}
// Clouds, glare, a torn print: most of every photo does not show the ground.
inline void PhotosCovered(World& world, Trial& trial) {
  const double share = world.Random().Between(0.5, 0.97);
  Chance noise(world.Random().Number());
  ChangePhotos(world, trial,
               [&](Image image) {
                 const int most = static_cast<int>(share * image.width);
                 for (int row = image.height / 12; row < image.height * 11 / 12; ++row)
                   for (int col = image.width / 12; col < std::min(most, image.width * 11 / 12);
                        ++col)
                     image.At(col, row) = static_cast<float>(200 + 15 * noise.Normal());
                 return image;
               },
               {});
}
inline void PhotosExchanged(World&, Trial& trial) {
  std::swap(trial.photos.begin()->second, trial.photos.rbegin()->second);
  std::swap(trial.shows.begin()->second, trial.shows.rbegin()->second);
}
inline void PhotosOfElsewhere(World& world, Trial& trial) {
  for (auto& [name, path] : trial.photos) path = world.Elsewhere() + "/scans/" + name + ".tif";
  for (auto& [name, shown] : trial.shows) shown = {world.Elsewhere(), name};
  trial.unrelated = true;
}

// --- What is stated about the photos

inline void WrongPolarity(World& world, Trial& trial) {
  const bool negative = world.Options().polarity == Polarity::kNegative;
  trial.interior_words.insert(trial.interior_words.end(),
                              {"--polarity", negative ? "positive" : "negative"});
}
inline void WrongPixelSize(World& world, Trial& trial) {
  const double size = *world.Options().pixel_size_um * world.Random().Scale(0.5, 2);
  trial.interior_words.insert(trial.interior_words.end(),
                              {"--pixel-size-um", std::to_string(size)});
}
inline void WrongScanOrientation(World& world, Trial& trial) {
  constexpr std::array kAll = {"r0", "r90", "r180", "r270", "m0", "m90", "m180", "m270"};
  trial.interior_words.insert(trial.interior_words.end(),
                              {"--orientation", world.Random().OneOf(kAll)});
}

// --- The patches

inline void ChangePatches(World& world, Trial& trial,
                          const std::function<void(std::vector<patchdb::Patch>&)>& change) {
  using patchdb::PatchDatabase;
  std::vector<patchdb::Patch> patches =
      PatchDatabase::Open(trial.patchdb, PatchDatabase::Mode::kRead)
          .ListPatches(0, std::numeric_limits<int>::max());
  change(patches);
  trial.patchdb = trial.folder + "/patches.gpkg";
  fs::remove(trial.patchdb);
  PatchDatabase changed =
      PatchDatabase::Create(trial.patchdb, Crs::Parse(world.Options().crs, "false_ok"));
  patchdb::PatchSource source{
      0, patchdb::SourceKind::kPhoto, "old", {}, world.Options().gsd_m, {}, {}, {}};
  changed.AddSource(source, patches);
}
inline void Shuffle(std::vector<patchdb::Patch>& patches, Chance& chance) {
  for (std::size_t i = patches.size(); i > 1; --i)
    std::swap(patches[i - 1], patches[chance.Number() % i]);
}
inline void PatchesFew(World& world, Trial& trial) {
  const double count = world.Random().Scale(6, 60);
  ChangePatches(world, trial, [&](std::vector<patchdb::Patch>& patches) {
    Shuffle(patches, world.Random());
    patches.resize(std::min(patches.size(), static_cast<std::size_t>(count)));
  });
}
inline void PatchesExchanged(World& world, Trial& trial) {
  trial.unrelated = true;
  ChangePatches(world, trial, [&](std::vector<patchdb::Patch>& patches) {
    const std::vector<patchdb::Patch> all = patches;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const patchdb::Patch& from = all[(i + all.size() / 3) % all.size()];
      patches[i].chip = from.chip;
      patches[i].heights = from.heights;
    }
  });
}
inline void PatchesMoved(World& world, Trial& trial) {
  const double metres = world.Random().Scale(2, 100);
  ChangePatches(world, trial, [&](std::vector<patchdb::Patch>& patches) {
    for (patchdb::Patch& patch : patches)
      patch.ground_m.head<2>() +=
          metres * Eigen::Vector2d(world.Random().Normal(), world.Random().Normal());
  });
}
// Patches of another area, some or all.
inline void PatchesOfElsewhere(World& world, Trial& trial) {
  if (world.Random().Happens(0.5)) {
    trial.patchdb = world.Elsewhere() + "/patches.gpkg";
    trial.unrelated = true;
    return;
  }
  const double share = world.Random().Between(0.3, 0.95);
  const auto strange = patchdb::PatchDatabase::Open(world.Elsewhere() + "/patches.gpkg",
                                                    patchdb::PatchDatabase::Mode::kRead)
                           .ListPatches(0, std::numeric_limits<int>::max());
  ChangePatches(world, trial, [&](std::vector<patchdb::Patch>& patches) {
    Shuffle(patches, world.Random());
    const auto own = static_cast<std::size_t>((1 - share) * static_cast<double>(patches.size()));
    patches.resize(own);
    patches.insert(patches.end(), strange.begin(), strange.end());
  });
}

struct Fault {
  const char* name;
  void (*falsify)(World&, Trial&);
  bool of_film = false;  // digital cameras have no such input
};
inline constexpr Fault kFaults[] = {
    {"starts_far_off", StartsFarOff},
    {"kappa_unknown", KappaUnknown},
    {"heights_of_starts_wrong", HeightsOfStartsWrong},
    {"starts_exchanged", StartsExchanged},
    {"wrong_principal_distance", WrongPrincipalDistance},
    {"wrong_principal_point", WrongPrincipalPoint},
    {"wrong_lens", WrongLens},
    {"wrong_marks", WrongMarks, true},
    {"dem_raised", DemRaised},
    {"dem_shifted", DemShifted},
    {"dem_level", DemLevel},
    {"photos_mirrored", PhotosMirrored},
    {"photos_shifted", PhotosShifted},
    {"photos_scaled", PhotosScaled},
    {"photos_inverted", PhotosInverted},
    {"photos_covered", PhotosCovered},
    {"photos_exchanged", PhotosExchanged},
    {"photos_of_elsewhere", PhotosOfElsewhere},
    {"wrong_polarity", WrongPolarity, true},
    {"wrong_pixel_size", WrongPixelSize, true},
    {"wrong_scan_orientation", WrongScanOrientation, true},
    {"patches_few", PatchesFew},
    {"patches_exchanged", PatchesExchanged},
    {"patches_moved", PatchesMoved},
    {"patches_of_elsewhere", PatchesOfElsewhere},
};

}  // namespace orient::false_ok
