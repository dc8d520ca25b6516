// Orients one photo of a digital camera: where was it, and how precisely is that known?
//
//   orient_one_photo camera.toml dem.tif patches.gpkg approx.csv photo.tif
#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <string>

#include "core/base/error.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/raster/raster.h"
#include "core/terrain/ground_surface.h"
#include "exterior/orient_photo.h"
#include "exterior/steps/predict.h"
#include "patchdb/store/patch_database.h"

namespace {

using orient::DegFromRad;
using orient::patchdb::PatchDatabase;

// How well approximations are known where the table has no sigma columns.
constexpr double kPosition_m = 10, kAttitude_deg = 3;

orient::PosePrior Prior(const orient::OrientationRow& row) {
  orient::Vector6d sigma;  // x y z omega phi kappa, as everywhere
  sigma << Eigen::Vector3d::Constant(kPosition_m),
      Eigen::Vector3d::Constant(orient::RadFromDeg(kAttitude_deg));
  if (row.sigma) sigma = *row.sigma;
  return {row.pose, sigma.cwiseAbs2().asDiagonal()};
}

orient::ExteriorResult Orient(const std::string& camera_path, const std::string& dem_path,
                              const std::string& patches_path, const std::string& table_path,
                              const std::string& photo_path) {
  const PatchDatabase database = PatchDatabase::Open(patches_path, PatchDatabase::Mode::kRead);
  const auto surface = orient::GroundSurface::FromFile(dem_path, database.GroundCrs());
  const orient::OrientationTable table = orient::ReadOrientationTable(table_path);

  orient::exterior::PhotoToOrient photo;
  photo.name = orient::PhotoName(photo_path);
  photo.camera = orient::ReadCameraFile(camera_path).camera;
  // Of scanned film, what interior orientation found: InteriorResult::photo_from_pixel.
  photo.positions = {{orient::DigitalPhotoFromPixel(photo.camera), std::nullopt}};
  const orient::OrientationRow* row = table.Find(photo.name);
  if (row == nullptr) throw orient::InputError(table_path + ": has no row '" + photo.name + "'");
  photo.prior = Prior(*row);
  photo.surface = &surface;

  // The patches that it may show, wherever within three sigma its approximation is wrong.
  const auto patches = database.FindPatchesIn(orient::exterior::UncertainFootprint(
      photo.camera, photo.prior, surface.MinHeight(), surface.MaxHeight()));
  const orient::Raster raster = orient::Raster::Open(photo_path);
  const orient::exterior::PhotoImage image(raster, /*negative=*/false);
  return orient::exterior::OrientPhoto(photo, image, patches);
}

}  // namespace

int main(int count, char** words) try {
  if (count != 6) throw orient::UsageError("usage: camera, DEM, patch database, table and photo");
  const orient::ExteriorResult result = Orient(words[1], words[2], words[3], words[4], words[5]);
  std::printf("%s: %s\n", result.photo.c_str(), Name(result.status).data());
  for (const std::string& why : Sentences(result.findings)) std::printf("  %s\n", why.c_str());
  if (!result.pose) return 3;
  const char* const element[] = {"x [m]",       "y [m]",     "z [m]",
                                 "omega [deg]", "phi [deg]", "kappa [deg]"};
  for (int i = 0; i < 6; ++i) {
    const double value = result.pose->AsVector()[i], sigma = std::sqrt((*result.covariance)(i, i));
    std::printf("  %-11s %14.4f  +- %.4f\n", element[i], i < 3 ? value : DegFromRad(value),
                i < 3 ? sigma : DegFromRad(sigma));
  }
  return 0;
} catch (const std::exception& error) {  // InputError names the file and says what to do
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
