#include "block/block_by_measurements.h"

#include <set>

#include "block/held_to_control.h"
#include "block/inputs/approximations.h"

namespace orient::block {

PosesKnown ReadPosesKnown(const BlockFile& block, const Measurements& measured) {
  PosesKnown known;
  std::set<std::string> photos;
  for (const ImagePointMeasurement& point : measured.image_points) photos.insert(point.photo);
  std::set<std::string> with_strips = photos;  // those listed in strips are reported separately
  for (const FlightStrip& strip : block.flight.strips)
    with_strips.insert(strip.photos.begin(), strip.photos.end());
  const auto name_others = [&](const std::vector<OrientationRow>& rows, const std::string& path) {
    NameOtherPhotos(rows, path, with_strips, &known.remarks, &known.not_there);
  };
  if (!block.approximations.empty()) {
    OrientationTable table = ReadApproximations(block.approximations, block.crs);
    RequireCrs(block.crs, table, block.approximations);
    RequireOneCamera(table, block.approximations, photos);
    known.remarks = RemarksOn(table, block.approximations);
    name_others(table.rows, block.approximations);
    known.approximations = std::move(table.rows);
  }
  const std::vector<OrientationRow> gnss = ReadGnss(block, &known.remarks);
  RefuseExchangedAxes(block, known.approximations, gnss);
  name_others(gnss, block.gnss.positions);
  NameAbsentOfStrips(block.flight, photos, &known.remarks);
  known.observed =
      ObservationsOf(block, StatedApproximations(block, known.approximations, {}), gnss);
  AddGnssPositions(gnss, &known.approximations);
  return known;
}

JudgedBlock OrientByMeasurements(const MeasuredBlockInputs& inputs) {
  JudgedBlock judged = AdjustMeasurements(inputs);
  if (inputs.known.Empty()) return judged;
  MeasuredBlockInputs without = inputs;
  without.known = {};
  return HeldToControl(std::move(judged), AdjustMeasurements(without));
}

}  // namespace orient::block
