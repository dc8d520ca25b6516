#include "tools/commands/block/measured_block.h"

#include <fmt/format.h>

#include <ostream>

#include "block/block_by_measurements.h"
#include "block/inputs/block_camera.h"
#include "block/inputs/block_files.h"
#include "block/stages/exterior_stage.h"
#include "block/verdict/adjustment_summary.h"
#include "block/verdict/calibrated_camera.h"
#include "block/verdict/point_table.h"
#include "core/base/output_directory.h"
#include "core/files/adjustment_result.h"
#include "core/terrain/earth_effects.h"
#include "core/terrain/map_scale.h"
#include "tools/commands/exterior_summary.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

void WriteResults(const BlockFile& block, const CameraFile& camera, const block::JudgedBlock& done,
                  const block::PointTable& points) {
  const std::string& out = block.output_directory;
  for (const ExteriorResult& result : done.results) WriteExteriorResult(out, result);
  block::WritePoseTable(out, done.results, block.crs);
  block::WriteBlockCamera(out, camera);
  block::WriteCalibratedCamera(out, camera, done.adjusted.result);
  block::WritePointTable(out, points);
  WriteAdjustmentResult(out, block::SummaryOf(done.adjusted, done.findings));
}

// The camera with earth curvature and refraction, if they matter, for the ground of the block.
CameraFile OverTheEarth(const BlockFile& block, const CameraFile& camera,
                        const block::JudgedBlock& flat) {
  constexpr double kPixel_mm = 0.01;
  double height_m = 0, ground_m = 0;
  int photos = 0, points = 0;
  for (const ExteriorResult& result : flat.results)
    if (result.pose) {
      height_m += result.pose->position_m.z();
      ++photos;
    }
  for (const block::AdjustedPoint& point : flat.adjusted.result.points)
    if (point.adjusted) {
      ground_m += point.ground_m.z();
      ++points;
    }
  CameraFile over = camera;
  if (photos > 0 && points > 0)
    over.camera = WithEarthEffects(camera.camera, block.earth, height_m / photos, ground_m / points,
                                   kPixel_mm);
  return over;
}

// There is no DEM to say where the block lies: its known points and positions do.
void RefuseFalseScaleOf(const BlockFile& block, const block::MeasuredBlockInputs& inputs) {
  Bounds area = Bounds::OfNothing();
  for (const GroundPoint& point : inputs.measured.points)
    area.Include(point.ground_m.x(), point.ground_m.y());
  for (const OrientationRow& row : inputs.approximations)
    area.Include(row.pose.position_m.x(), row.pose.position_m.y());
  RefuseFalseScale(block.crs, area);
}

}  // namespace

ExitCode AdjustMeasuredBlock(const BlockFile& block, bool overwrite, std::ostream& out) {
  const std::string& directory = block.output_directory;
  RefuseToOverwrite(block::BlockFiles(directory), overwrite);
  CameraFile camera = ReadCameraFile(block.camera);
  const Measurements measured = ReadMeasurements(block.measurements);
  const block::PosesKnown known = block::ReadPosesKnown(block, measured);
  block::MeasuredBlockInputs inputs{.camera = camera,
                                    .measured = measured,
                                    .approximations = known.approximations,
                                    .known = known.observed};
  inputs.self_calibration = block.adjustment.self_calibration;
  inputs.sub_block_photos = block.adjustment.sub_block_photos;
  inputs.pose_covariance = block.adjustment.pose_covariance;
  inputs.target_m = block.target_m;
  RefuseFalseScaleOf(block, inputs);
  MakeOutputDirectory(directory);
  block::JudgedBlock done = block::OrientByMeasurements(inputs);
  camera = OverTheEarth(block, camera, done);
  if (camera.camera.earth_k1 != 0) done = block::OrientByMeasurements(inputs);
  done.findings.insert(done.findings.end(), known.remarks.begin(), known.remarks.end());
  const block::PointTable points =
      block::TableOfPoints(done.adjusted.surveyed, done.adjusted.block, done.adjusted.result);
  WriteResults(block, camera, done, points);
  PrintExteriorSummary(done.results, out);
  out << fmt::format("\nblock   {} photos, {} ties, sigma0 {}, redundancy {:.0f}\n",
                     done.adjusted.block.photos.size(), done.adjusted.ties,
                     Fixed(done.adjusted.result.sigma0, 2), done.adjusted.result.redundancy);
  for (const std::string& line : TextOf(points)) out << line << "\n";
  for (const std::string& message : Sentences(done.findings)) out << "note    " << message << "\n";
  return AllOriented(done.results) && known.not_there.empty() ? ExitCode::kAllDone
                                                              : ExitCode::kSomeNotOriented;
}

}  // namespace orient
