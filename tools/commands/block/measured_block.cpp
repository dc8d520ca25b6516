#include "tools/commands/block/measured_block.h"

#include <fmt/format.h>

#include <filesystem>
#include <ostream>
#include <set>

#include "block/block.h"
#include "block/block_by_measurements.h"
#include "block/inputs/block_files.h"
#include "block/verdict/adjustment_summary.h"
#include "block/verdict/calibrated_camera.h"
#include "block/verdict/point_table.h"
#include "block/verdict/pose_covariance.h"
#include "core/base/error.h"
#include "core/terrain/earth_effects.h"
#include "core/terrain/map_scale.h"
#include "tools/commands/block_outputs.h"
#include "tools/commands/exterior_summary.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/summary_table.h"
#include "tools/report/gis/block_project.h"

namespace orient {
namespace {

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

// What the run may write, of photos and as a whole.
std::vector<std::string> ResultsOf(const std::string& directory, const Measurements& measured) {
  std::set<std::string> photos;
  for (const ImagePointMeasurement& point : measured.image_points) photos.insert(point.photo);
  std::vector<std::string> results;
  for (const std::string& photo : photos) results.push_back(ExteriorResultPath(directory, photo));
  Append(block::BlockFiles(directory), &results);
  return results;
}

std::vector<RunInput> RecordedInputs(const BlockFile& block, const std::string& block_path) {
  std::vector<RunInput> inputs = {FileInput("block file", block_path),
                                  FileInput("camera", block.camera),
                                  FileInput("approximations", block.approximations),
                                  FileInput("GNSS positions", block.gnss.positions)};
  for (const std::string& file : MeasurementFiles(block.measurements))
    if (std::filesystem::exists(file)) inputs.push_back(FileInput("measurements", file));
  return inputs;
}

// Writes what the adjustment alone gives.
block::OrientedBlock OrientedFrom(const BlockFile& block, const CameraFile& camera,
                                  const block::PosesKnown& known, block::JudgedBlock done) {
  const std::string& directory = block.output_directory;
  const block::BlockResult& adjusted = done.adjusted.result;
  block::OrientedBlock oriented;
  oriented.camera = camera;
  oriented.not_there = known.not_there;
  oriented.findings = done.findings;
  oriented.findings.insert(oriented.findings.end(), known.remarks.begin(), known.remarks.end());
  if (adjusted.converged && !adjusted.cameras.empty())
    oriented.camera.camera = adjusted.cameras.front();
  block::WriteCalibratedCamera(directory, camera, adjusted);
  if (!block::WritePoseCovariance(directory, block.adjustment.pose_covariance, done.adjusted,
                                  done.results))
    oriented.findings.push_back(block::NoPoseCovariance());
  const block::PointTable points =
      block::TableOfPoints(done.adjusted.surveyed, done.adjusted.block, adjusted);
  block::WritePointTable(directory, points);
  oriented.control_points = TextOf(points);
  oriented.adjusted = block::SummaryOf(done.adjusted, oriented.findings);
  oriented.results = std::move(done.results);
  return oriented;
}

}  // namespace

ExitCode AdjustMeasuredBlock(const BlockFile& block, const MeasuredBlockRun& run,
                             std::ostream& out) {
  const std::string& directory = block.output_directory;
  const bool resume = !run.overwrite && (run.resume || block::IsUnfinished(directory));
  if (!block.formats.empty())
    throw InputError(run.block_path +
                     ": output.formats is for blocks of photos; export this one with 'orient "
                     "convert'");
  CameraFile camera = ReadCameraFile(block.camera);
  const Measurements measured = ReadMeasurements(block.measurements);
  RefuseToOverwrite(ResultsOf(directory, measured), run.overwrite || resume, "--resume");
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
  const std::size_t photos = block::RequireAdjustable(inputs);
  if (run.plan) {
    out << fmt::format("adjust   {} photos, {} image points, {} ground points; all results anew\n",
                       photos, measured.image_points.size(), measured.points.size());
    return ExitCode::kAllDone;
  }
  const block::BlockFolder folder(directory, resume);
  block::JudgedBlock done = block::OrientByMeasurements(inputs);
  camera = OverTheEarth(block, camera, done);
  if (camera.camera.earth_k1 != 0) done = block::OrientByMeasurements(inputs);
  const std::string summary =
      fmt::format("\nblock   {} photos, {} ties, sigma0 {}, redundancy {:.0f}\n",
                  done.adjusted.block.photos.size(), done.adjusted.ties,
                  Fixed(done.adjusted.result.sigma0, 2), done.adjusted.result.redundancy);
  block::OrientedBlock oriented = OrientedFrom(block, camera, known, std::move(done));
  RecordRun(run.invoked, directory, "block", RecordedInputs(block, run.block_path));
  WriteBlockOutputs(block, false, &oriented);
  PrintExteriorSummary(oriented.results, out);
  out << summary;
  for (const std::string& line : oriented.control_points) out << line << "\n";
  for (const std::string& message : Sentences(oriented.findings))
    out << "note    " << message << "\n";
  WriteBlockProject(directory);
  folder.Finish();
  return AllOriented(oriented.results) && known.not_there.empty() ? ExitCode::kAllDone
                                                                  : ExitCode::kSomeNotOriented;
}

}  // namespace orient
