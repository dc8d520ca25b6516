// A photo's whole geometry: film, lens, earth and pose between scan and ground.
#include <pybind11/stl.h>

#include <filesystem>
#include <memory>
#include <string>

#include "block/inputs/block_camera.h"
#include "block/inputs/block_photos.h"
#include "block/inputs/mark_shapes.h"
#include "core/base/error.h"
#include "core/files/camera_file.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"
#include "python/arrays.h"
#include "python/native.h"

namespace orient::python {
namespace {
namespace py = pybind11;

// Of a photo of a folder that `orient block` or `orient exterior` wrote.
PhotoView OfResult(const std::string& folder, const std::string& photo,
                   const std::string& interior) {
  const CameraFile camera = ReadCameraFile(block::BlockCameraPath(folder));
  const bool film = camera.camera.kind == CameraKind::kFilm;
  const block::BlockPhotoFile read =
      block::ReadBlockPhoto(photo, ExteriorResultPath(folder, photo), camera,
                            film ? block::LoadMarkShapes(camera) : interior::MarkShapes(),
                            interior.empty() ? folder : interior);
  if (!read.HasPose())
    throw InputError(photo + " has no pose: " + JoinedSentences(read.exterior.findings));
  return read.ViewOfResult(camera.camera);
}

// Of a digital camera: all that there is to know is the camera and the pose.
PhotoView OfPose(const std::string& camera_path, const Array& pose) {
  const Camera camera = ReadCameraFile(camera_path).camera;
  if (camera.kind != CameraKind::kDigital)
    throw InputError(camera_path + " is a film camera: its photos need their interior orientation");
  const auto rows = ToRows<6>(pose, "pose");
  if (rows.size() != 1) throw py::value_error("pose must be one pose: six numbers");
  return {camera, DigitalPhotoFromPixel(camera), Pose::FromVector(rows.front())};
}

// Outside the camera's frame the lens is not known: NaN there, and behind the camera. The frame's
// corners belong to it, whatever rounding makes of them.
constexpr double kRounding_mm = 1e-6;

bool Shows(const PhotoView& view, const Eigen::Vector2d& photo_mm) {
  return view.camera.InFrame(photo_mm, kRounding_mm);
}

Array PixelsOf(const PhotoView& view, const Array& ground) {
  std::vector<std::optional<Eigen::Vector2d>> pixels;
  for (const Eigen::Vector3d& point : ToRows<3>(ground, "ground points")) {
    const auto photo_mm = PhotoFromGround(view.camera, view.pose, point);
    const bool shown = photo_mm && Shows(view, *photo_mm);
    pixels.push_back(shown ? std::optional(view.PixelFromPhoto(*photo_mm)) : std::nullopt);
  }
  return Rows<2>(pixels);
}

Array PhotoFromPixels(const PhotoView& view, const Array& pixels) {
  std::vector<std::optional<Eigen::Vector2d>> photo_mm;
  for (const Eigen::Vector2d& pixel : ToRows<2>(pixels, "pixels"))
    photo_mm.emplace_back(view.PhotoFromPixel(pixel));
  return Rows<2>(photo_mm);
}

Array RaysOf(const PhotoView& view, const Array& pixels) {
  std::vector<std::optional<Eigen::Vector3d>> directions;
  for (const Eigen::Vector2d& pixel : ToRows<2>(pixels, "pixels")) {
    const Eigen::Vector2d photo_mm = view.PhotoFromPixel(pixel);
    const auto ray =
        Shows(view, photo_mm) ? GroundRayFromPhoto(view.camera, view.pose, photo_mm) : std::nullopt;
    directions.push_back(ray ? std::optional(ray->direction) : std::nullopt);
  }
  return Rows<3>(directions);
}

Array GroundOf(const PhotoView& view, const Array& pixels, const GroundSurface& surface) {
  std::vector<std::optional<Eigen::Vector3d>> ground;
  for (const Eigen::Vector2d& pixel : ToRows<2>(pixels, "pixels"))
    ground.push_back(Shows(view, view.PhotoFromPixel(pixel)) ? view.GroundFromPixel(pixel, surface)
                                                             : std::nullopt);
  return Rows<3>(ground);
}

Array HeightsAt(const GroundSurface& surface, const Array& places) {
  const auto rows = ToRows<2>(places, "places");
  Eigen::VectorXd heights(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    heights[static_cast<Eigen::Index>(i)] = OrNan(surface.HeightAt(rows[i].x(), rows[i].y()));
  return FromVector(heights);
}

}  // namespace

void AddGeometry(py::module_& m) {
  py::class_<GroundSurface>(m, "Surface")
      .def(py::init([](const std::string& path, const std::string& crs) {
             return GroundSurface::FromFile(path, Crs::Parse(crs, "crs"));
           }),
           py::arg("path"), py::arg("crs"))
      .def("heights", &HeightsAt, py::arg("places"));
  py::class_<PhotoView>(m, "PhotoGeometry")
      .def_static("of_result", &OfResult, py::arg("folder"), py::arg("photo"),
                  py::arg("interior") = "")
      .def_static("of_pose", &OfPose, py::arg("camera"), py::arg("pose"))
      .def_property_readonly("pose",
                             [](const PhotoView& v) { return FromVector(v.pose.AsVector()); })
      .def_property_readonly("principal_distance_mm",
                             [](const PhotoView& v) { return v.camera.principal_distance_mm; })
      .def("pixels", &PixelsOf, py::arg("ground"))
      .def("photo_mm", &PhotoFromPixels, py::arg("pixels"))
      .def("rays", &RaysOf, py::arg("pixels"))
      .def("ground", &GroundOf, py::arg("pixels"), py::arg("surface"));
}

}  // namespace orient::python
