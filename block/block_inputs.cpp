#include "block/block_inputs.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

#include "block/inputs/approximations.h"
#include "block/inputs/digest.h"
#include "block/inputs/mark_shapes.h"
#include "core/terrain/earth_effects.h"

namespace orient::block {
namespace {

// To be raised where the method changes.
constexpr const char* kMethod = "block 4";

// Everything stated about the flight, as one text that changes when a statement does.
std::string FlightText(const FlightPlan& flight) {
  if (flight.Empty()) return "";
  std::string text = fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {}", flight.overlap, flight.side_lap,
                                 flight.flying_height_m.value_or(0), flight.scale.value_or(0),
                                 flight.back_and_forth ? 1 : 0);
  if (flight.next_strip)
    text += fmt::format(" {:g} {:g}", flight.next_strip->x(), flight.next_strip->y());
  text += fmt::format(" {:.9g}", flight.azimuth_rad.value_or(99));
  for (const FlightStrip& strip : flight.strips) {
    text += fmt::format("; {:.9g}", strip.azimuth_rad.value_or(99));
    for (const std::string& photo : strip.photos) text.append(" ").append(photo);
  }
  return text;
}

}  // namespace

BlockInputs::BlockInputs(BlockRunOptions options, Patches patches)
    : options_(std::move(options)), camera_(ReadCameraFile(options_.block.camera)) {
  if (!options_.block.measurements.empty())
    measurements_ = ReadMeasurements(options_.block.measurements);
  if (IsFilm()) marks_ = LoadMarkShapes(camera_);
  const BlockFile& block = options_.block;
  approximations_ = std::make_unique<BlockApproximations>(block, camera_.camera, measurements_);
  if (patches == Patches::kThere) RequireCrsOfPatches(block.patchdb, block.crs);
  DecideOnTheEarth();
  shared_ = {{"method", kMethod},
             {"camera", DigestOfCamera(camera_)},
             {"dem", DigestOfRaster(block.dem)},
             {"crs", Digest(block.crs.Wkt())},
             {"flight", Digest(FlightText(block.flight))},
             {"earth", Name(block.earth)}};
  if (patches == Patches::kThere) patches_ = Digest(PatchContentOfRun(Exterior("")));
}

// All stages use one camera; a change of a photo's height by metres must not make a different one.
void BlockInputs::DecideOnTheEarth() {
  char rounded[32];
  std::snprintf(rounded, sizeof rounded, "%.2e", EarthK1OfRun(Exterior("")));
  earth_k1_ = std::strtod(rounded, nullptr);
  camera_.camera = WithEarth(camera_.camera, *earth_k1_);
}

InteriorRunOptions BlockInputs::Interior() const {
  const BlockFile& block = options_.block;
  InteriorRunOptions options;
  options.photos = block.photos;
  options.camera = block.camera;
  options.out = block.output_directory;
  options.scan = {block.pixel_size_um, block.polarity, block.orientation};
  options.measurements = measurements_;
  options.resume = options_.resume;
  options.redo_changed = true;
  options.jobs = options_.jobs;
  return options;
}

ExteriorRunOptions BlockInputs::Exterior(const std::string& directory) const {
  const BlockFile& block = options_.block;
  ExteriorRunOptions options;
  options.photos = block.photos;
  options.camera = block.camera;
  options.approximations = block.approximations;
  options.table = approximations_->Table();
  options.measurements = measurements_;
  options.dem = block.dem;
  options.patchdb = block.patchdb;
  options.out = directory;
  options.pictures = block.output_directory;
  if (IsFilm()) options.interior = block.output_directory;
  options.crs = block.crs;
  options.position_sigma_m = block.position_sigma_m;
  options.attitude_sigma_rad = block.attitude_sigma_rad;
  options.date = block.date;
  options.target_m = block.target_m;
  options.earth = block.earth;
  options.earth_k1 = earth_k1_;
  options.inputs = shared_;
  options.inputs["patches"] = patches_;
  options.learn = options_.learn;
  options.jobs = options_.jobs;
  return options;
}

std::vector<std::size_t> NextPhotos(const BlockInputs& inputs,
                                    const std::vector<ExteriorResult>& so_far) {
  inputs.Approximations().Learn(so_far);
  std::vector<std::string> open;
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < so_far.size(); ++i) {
    if (!so_far[i].photo.empty()) continue;
    open.push_back(PhotoName(inputs.Block().photos[i]));
    index.push_back(i);
  }
  std::vector<std::size_t> next;
  for (const std::size_t i : inputs.Approximations().Next(open)) next.push_back(index[i]);
  return next;
}

}  // namespace orient::block
