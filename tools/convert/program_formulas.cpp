#include "tools/convert/program_formulas.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/base/column_names.h"
#include "core/base/error.h"
#include "core/exchange/asp_pinhole.h"
#include "core/exchange/colmap.h"
#include "core/exchange/frame_adjustments.h"
#include "core/exchange/metashape.h"
#include "core/exchange/micmac_orientation.h"
#include "core/exchange/opensfm.h"
#include "core/files/orientation_table.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Seen = std::optional<Vector2d>;

// The matrix as written, or the other way round.
Matrix3d Turned(const Matrix3d& written, const Reading& reading) {
  return reading.transposed ? Matrix3d(written.transpose()) : written;
}

Vector3d CameraAxes(const Vector3d& point, const Reading& reading) {
  return reading.turned_axes ? Vector3d(point.x(), -point.y(), -point.z()) : point;
}

// The principal point's offset from `middle` with its sign.
Vector2d Principal(const Vector2d& principal, const Vector2d& middle, const Reading& reading) {
  return reading.mirrored_principal ? Vector2d(2 * middle - principal) : principal;
}

// To Orient's pixels from those whose upper-left centre is `centre`.
Vector2d Counted(Vector2d pixel, double centre, const Reading& reading) {
  if (reading.swapped) std::swap(pixel.x(), pixel.y());
  return pixel + Vector2d::Constant(0.5 - centre + 0.5 * reading.half_pixels);
}

template <typename Photo>
const Photo& PhotoOf(const std::map<std::string, Photo>& photos, const std::string& image) {
  auto found = photos.find(image);
  for (const std::string& name :  // without the folder, and without the ending
       {fs::path(image).filename().string(), BareImageName(image)})
    if (found == photos.end()) found = photos.find(name);
  if (found == photos.end()) throw InputError("the files hold no image " + image);
  return found->second;
}

// ---- COLMAP: src/colmap/sensor/models.h --------------------------------------------------------

class ColmapFiles : public ProgramFiles {
 public:
  explicit ColmapFiles(const std::string& directory) : model_(ReadColmap(directory)) {
    for (const ColmapImage& image : model_.images) images_[image.name] = image;
  }
  ReadingChoices Choices() const override { return {false, true, true}; }
  Seen Project(const std::string& name, const Vector3d& ground, double /*c*/,
               const Reading& reading) const override {
    const ColmapImage& image = PhotoOf(images_, name);
    const ColmapCamera& camera = model_.cameras.at(image.camera);
    const double w = image.qvec[0], x = image.qvec[1], y = image.qvec[2], z = image.qvec[3];
    Matrix3d r;
    r << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
    // The other way round q and t are the camera's pose.
    const Vector3d p = reading.transposed ? Vector3d(r.transpose() * (ground - image.tvec))
                                          : Vector3d(r * ground + image.tvec);
    return Image(camera, CameraAxes(p, reading), reading);
  }

 private:
  static Seen Image(const ColmapCamera& camera, const Vector3d& p, const Reading& reading) {
    if (!(p.z() > 0)) return std::nullopt;
    const std::vector<double>& v = camera.params;
    const double u = p.x() / p.z(), w = p.y() / p.z(), r2 = u * u + w * w;
    const bool one_focal = camera.model.starts_with("SIMPLE") || camera.model == "RADIAL";
    const std::size_t c = one_focal ? 1 : 2;
    double du = 0, dw = 0;
    if (camera.model.ends_with("RADIAL")) {
      const double radial = v[3] * r2 + (v.size() > 4 ? v[4] * r2 * r2 : 0);
      du = u * radial;
      dw = w * radial;
    } else if (camera.model.ends_with("OPENCV")) {
      const double k3 = v.size() > 8 ? v[8] : 0;
      const double radial = v[4] * r2 + v[5] * r2 * r2 + k3 * r2 * r2 * r2;
      du = u * radial + 2 * v[6] * u * w + v[7] * (r2 + 2 * u * u);
      dw = w * radial + 2 * v[7] * u * w + v[6] * (r2 + 2 * w * w);
    }
    const Vector2d principal =
        Principal({v[c], v[c + 1]}, 0.5 * Vector2d(camera.width, camera.height), reading);
    return Counted({v[0] * (u + du) + principal.x(), v[c - 1] * (w + dw) + principal.y()}, 0.5,
                   reading);
  }

  ColmapModel model_;
  std::map<std::string, ColmapImage> images_;
};

// ---- OpenSfM: opensfm/src/geometry -------------------------------------------------------------

class OpensfmFiles : public ProgramFiles {
 public:
  explicit OpensfmFiles(const std::string& directory) : reconstruction_(ReadOpensfm(directory)) {
    for (const OpensfmShot& shot : reconstruction_.shots) shots_[shot.image] = shot;
  }
  ReadingChoices Choices() const override { return {false, true, true}; }
  Seen Project(const std::string& image, const Vector3d& ground, double /*c*/,
               const Reading& reading) const override {
    const OpensfmShot& shot = PhotoOf(shots_, image);
    // Rodrigues' formula; the other way round rotation and translation are the camera's pose.
    const auto rotated = [&](const Vector3d& p, double sign) -> Vector3d {
      const double angle = shot.rotation.norm();
      if (angle == 0) return p;
      const Vector3d axis = sign * shot.rotation / angle;
      return p * std::cos(angle) + axis.cross(p) * std::sin(angle) +
             axis * axis.dot(p) * (1 - std::cos(angle));
    };
    const Vector3d seen = reading.transposed ? rotated(ground - shot.translation, -1)
                                             : Vector3d(rotated(ground, 1) + shot.translation);
    const Vector3d p = CameraAxes(seen, reading);
    if (!(p.z() > 0)) return std::nullopt;
    const OpensfmCamera& c = reconstruction_.cameras.at(shot.camera);
    const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
    const double d = 1 + c.k1 * r2 + c.k2 * r2 * r2 + c.k3 * r2 * r2 * r2;
    const Vector2d principal = Principal({c.c_x, c.c_y}, Vector2d::Zero(), reading);
    const double u = c.focal_x * (d * x + 2 * c.p1 * x * y + c.p2 * (r2 + 2 * x * x));
    const double v = c.focal_y * (d * y + 2 * c.p2 * x * y + c.p1 * (r2 + 2 * y * y));
    // Pixel coordinates (whole numbers at the centres) = max(w, h) u + (w - 1) / 2.
    const double side = std::max(c.width, c.height);
    return Counted({side * (u + principal.x()) + 0.5 * (c.width - 1),
                    side * (v + principal.y()) + 0.5 * (c.height - 1)},
                   0, reading);
  }

 private:
  OpensfmReconstruction reconstruction_;
  std::map<std::string, OpensfmShot> shots_;
};

// ---- MicMac: phgr_ebner_brown_dist.cpp ---------------------------------------------------------

class MicmacFiles : public ProgramFiles {
 public:
  explicit MicmacFiles(const std::string& directory) : folder_(ReadMicmacOrientation(directory)) {
    for (const MicmacOrientation& o : folder_.orientations) photos_[o.image] = o;
  }
  ReadingChoices Choices() const override { return {false, true, true}; }
  Seen Project(const std::string& image, const Vector3d& ground, double /*c*/,
               const Reading& reading) const override {
    const MicmacOrientation& photo = PhotoOf(photos_, image);
    const MicmacCalibration& calibration = folder_.calibrations[photo.calibration];
    // The columns of the matrix are the camera's axes: L1 L2 L3 its rows.
    const Matrix3d r = Turned(photo.rotation, reading);
    const Vector3d from_centre = ground - photo.centre;
    const Vector3d p = CameraAxes(
        {r.col(0).dot(from_centre), r.col(1).dot(from_centre), r.col(2).dot(from_centre)}, reading);
    if (!(p.z() > 0)) return std::nullopt;
    const Vector2d middle = 0.5 * (calibration.size.cast<double>() - Vector2d::Ones());
    const Vector2d pp = Principal(calibration.pp, middle, reading);
    const Vector2d centre = Principal(calibration.centre, middle, reading);
    Vector2d m = pp + calibration.f * p.head<2>() / p.z();
    const Vector2d d = m - centre;
    const double r2 = d.squaredNorm();
    double radial = 0, power = 1;
    for (const double coefficient : calibration.radial) radial += coefficient * (power *= r2);
    m += radial * d;
    m.x() += (2 * d.x() * d.x() + r2) * calibration.p1 + 2 * d.x() * d.y() * calibration.p2;
    m.y() += (2 * d.y() * d.y() + r2) * calibration.p2 + 2 * d.x() * d.y() * calibration.p1;
    return Counted(m, 0, reading);
  }

 private:
  MicmacFolder folder_;
  std::map<std::string, MicmacOrientation> photos_;
};

// ---- Metashape: manual, appendix "Camera models" -----------------------------------------------

class MetashapeFiles : public ProgramFiles {
 public:
  explicit MetashapeFiles(const std::string& directory) : chunk_(ReadMetashape(directory)) {
    for (const MetashapeCamera& camera : chunk_.cameras) cameras_[camera.label] = camera;
  }
  ReadingChoices Choices() const override { return {false, true, true}; }
  Seen Project(const std::string& image, const Vector3d& ground, double /*c*/,
               const Reading& reading) const override {
    const MetashapeCamera& camera = PhotoOf(cameras_, image);
    const auto sensor = std::find_if(chunk_.sensors.begin(), chunk_.sensors.end(),
                                     [&](const auto& s) { return s.id == camera.sensor; });
    // World to chunk, chunk to camera.
    const Vector3d local =
        chunk_.rotation.transpose() * (ground - chunk_.translation) / chunk_.scale;
    const Matrix3d r = Turned(camera.transform.block<3, 3>(0, 0), reading);
    const Vector3d t = camera.transform.block<3, 1>(0, 3);
    const Vector3d p = CameraAxes(r.inverse() * (local - t), reading);
    if (!(p.z() > 0)) return std::nullopt;
    const MetashapeSensor& s = *sensor;
    const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
    const double radial = 1 + s.k1 * r2 + s.k2 * r2 * r2 + s.k3 * r2 * r2 * r2;
    const double xd = x * radial + s.p1 * (r2 + 2 * x * x) + 2 * s.p2 * x * y;
    const double yd = y * radial + s.p2 * (r2 + 2 * y * y) + 2 * s.p1 * x * y;
    const Vector2d c = Principal({s.cx, s.cy}, Vector2d::Zero(), reading);
    return Counted({0.5 * s.width + c.x() + xd * s.f + xd * s.b1 + yd * s.b2,
                    0.5 * s.height + c.y() + yd * s.f},
                   0.5, reading);
  }

 private:
  MetashapeChunk chunk_;
  std::map<std::string, MetashapeCamera> cameras_;
};

// ---- Ames Stereo Pipeline: "How the pinhole model is applied" ----------------------------------

class AspFiles : public ProgramFiles {
 public:
  explicit AspFiles(const std::string& directory) {
    for (const AspPinhole& photo : ReadAsp(directory)) photos_[photo.image] = photo;
  }
  ReadingChoices Choices() const override { return {false, true, true}; }
  Seen Project(const std::string& image, const Vector3d& ground, double /*c*/,
               const Reading& reading) const override {
    const AspPinhole& a = PhotoOf(photos_, image);
    const Vector3d q0 = Turned(a.r, reading).inverse() * (ground - a.c);
    const Vector3d q = CameraAxes({a.uvw[0].dot(q0), a.uvw[1].dot(q0), a.uvw[2].dot(q0)}, reading);
    if (!(q.z() > 0)) return std::nullopt;
    const double x = q.x() / q.z(), y = q.y() / q.z(), r2 = x * x + y * y;
    const double radial = 1 + a.k1 * r2 + a.k2 * r2 * r2 + a.k3 * r2 * r2 * r2;
    const double xd = x * radial + 2 * a.p1 * x * y + a.p2 * (r2 + 2 * x * x);
    const double yd = y * radial + a.p1 * (r2 + 2 * y * y) + 2 * a.p2 * x * y;
    // The image's size is unknown to the file: the sign of the principal point's offset cannot
    // fail.
    return Counted({(a.fu * xd + a.cu) / a.pitch, (a.fv * yd + a.cv) / a.pitch}, 0, reading);
  }

 private:
  std::map<std::string, AspPinhole> photos_;
};

// ---- Photos known by their principal distance: x = -c d0/d2 ------------------------------------

Seen Reduced(const Matrix3d& ground_from_photo, const Vector3d& centre, const Vector3d& ground,
             double c, const Reading& reading) {
  const Vector3d d =
      CameraAxes(Turned(ground_from_photo, reading).transpose() * (ground - centre), reading);
  if (!(d.z() < 0)) return std::nullopt;
  Vector2d photo = -c * d.head<2>() / d.z();
  if (reading.swapped) std::swap(photo.x(), photo.y());
  return photo;
}

// From angles about the axes in their order, without Orient's own formula.
Matrix3d FromAngles(const Vector3d& opk_rad, const Reading& reading) {
  const auto about = [](int axis, double angle) {
    return Eigen::AngleAxisd(angle, Vector3d::Unit(axis)).toRotationMatrix();
  };
  const Matrix3d first = about(0, opk_rad[0]) * about(1, opk_rad[1]);
  const Matrix3d other = about(1, opk_rad[1]) * about(0, opk_rad[0]);
  return (reading.phi_omega_kappa ? other : first) * about(2, opk_rad[2]);
}

class PatbFiles : public ProgramFiles {
 public:
  explicit PatbFiles(const std::string& directory) {
    const auto names = ReadPhotoNumbers(directory);
    for (const PatbPhoto& photo : ReadPatb(directory)) {
      const auto name = names.find(photo.number);
      photos_[name == names.end() ? photo.number : name->second] = photo;
    }
  }
  ReadingChoices Choices() const override { return {false, true, false}; }
  Seen Project(const std::string& image, const Vector3d& ground, double c,
               const Reading& reading) const override {
    const PatbPhoto& photo = PhotoOf(photos_, image);
    const double own = photo.principal_distance_mm;
    return Reduced(photo.matrix, photo.centre, ground, own > 0 ? own : c, reading);
  }

 private:
  std::map<std::string, PatbPhoto> photos_;
};

// BINGO's ORIA lines (gon) and OPK tables (degrees).
class AngleFiles : public ProgramFiles {
 public:
  struct Photo {
    Vector3d centre, angles;  // the latter as written
  };
  AngleFiles(std::map<std::string, Photo> photos, double per_turn, double other_per_turn)
      : photos_(std::move(photos)), per_turn_(per_turn), other_per_turn_(other_per_turn) {}
  ReadingChoices Choices() const override { return {true, true, false}; }
  Seen Project(const std::string& image, const Vector3d& ground, double c,
               const Reading& reading) const override {
    const Photo& photo = PhotoOf(photos_, image);
    const double turn = reading.other_unit ? other_per_turn_ : per_turn_;
    const double full = 2 * 3.14159265358979323846;
    return Reduced(FromAngles(photo.angles * (full / turn), reading), photo.centre, ground, c,
                   reading);
  }

 private:
  std::map<std::string, Photo> photos_;
  double per_turn_, other_per_turn_;
};

std::unique_ptr<ProgramFiles> OpenBingo(const std::string& directory) {
  const auto names = ReadPhotoNumbers(directory);
  std::map<std::string, AngleFiles::Photo> photos;
  for (const BingoPhoto& photo : ReadBingo(directory)) {
    const auto name = names.find(photo.number);
    photos[name == names.end() ? photo.number : name->second] = {photo.centre, photo.opk_gon};
  }
  return std::make_unique<AngleFiles>(std::move(photos), 400, 360);
}

std::unique_ptr<ProgramFiles> OpenOri(const std::string& directory) {
  std::map<std::string, AngleFiles::Photo> photos;
  for (const OriPhoto& photo : ReadOri(directory))
    photos[photo.name] = {photo.centre, photo.opk_deg};
  return std::make_unique<AngleFiles>(std::move(photos), 360, 400);
}

std::unique_ptr<ProgramFiles> OpenOpk(const std::string& directory) {
  std::map<std::string, AngleFiles::Photo> photos;
  const std::string path =
      fs::is_directory(directory) ? (fs::path(directory) / "orientation.csv").string() : directory;
  for (const OrientationRow& row : ReadOrientationTable(path).rows)
    photos[row.photo] = {row.pose.position_m, row.pose.opk_rad * DegFromRad(1)};
  return std::make_unique<AngleFiles>(std::move(photos), 360, 400);
}

}  // namespace

int Reading::Count() const {
  return static_cast<int>(transposed) + static_cast<int>(phi_omega_kappa) +
         static_cast<int>(other_unit) + static_cast<int>(turned_axes) +
         static_cast<int>(mirrored_principal) + static_cast<int>(swapped) +
         static_cast<int>(half_pixels != 0);
}

std::string Describe(const Reading& reading) {
  std::string text;
  const auto add = [&](bool differs, const char* what) {
    if (differs) text += std::string(text.empty() ? "" : ", ") + what;
  };
  add(reading.transposed, "the rotation is transposed");
  add(reading.phi_omega_kappa, "the angles are in the order phi, omega, kappa");
  add(reading.other_unit, "the angles are in the other unit (degrees, gon)");
  add(reading.turned_axes, "the camera's y and z axes are flipped (y up or down)");
  add(reading.mirrored_principal, "the principal point's offset has the other sign");
  add(reading.swapped, "rows and columns are exchanged");
  add(reading.half_pixels > 0,
      "columns and rows are half a pixel too small (where the first pixel's centre lies)");
  add(reading.half_pixels < 0,
      "columns and rows are half a pixel too large (where the first pixel's centre lies)");
  return text.empty() ? "as declared" : text;
}

std::unique_ptr<ProgramFiles> OpenProgramFiles(ExchangeFormat format,
                                               const std::string& directory) {
  switch (format) {
    case ExchangeFormat::kOpk:
      return OpenOpk(directory);
    case ExchangeFormat::kOri:
      return OpenOri(directory);
    case ExchangeFormat::kPatb:
      return std::make_unique<PatbFiles>(directory);
    case ExchangeFormat::kBingo:
      return OpenBingo(directory);
    case ExchangeFormat::kMicmac:
      return std::make_unique<MicmacFiles>(directory);
    case ExchangeFormat::kMetashape:
      return std::make_unique<MetashapeFiles>(directory);
    case ExchangeFormat::kColmap:
      return std::make_unique<ColmapFiles>(directory);
    case ExchangeFormat::kOpensfm:
      return std::make_unique<OpensfmFiles>(directory);
    case ExchangeFormat::kAsp:
      return std::make_unique<AspFiles>(directory);
  }
  throw InputError("unknown format");
}

}  // namespace orient
