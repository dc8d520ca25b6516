// A photo's whole geometry: film, lens, earth and pose between scan and ground.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <string>

#include "block/inputs/block_camera.h"
#include "block/inputs/block_photos.h"
#include "block/inputs/camera_library.h"
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
using Path = std::filesystem::path;  // str, bytes or os.PathLike

// Of a photo of a folder that `orient block` or `orient exterior` wrote.
PhotoView OfResult(const Path& folder_path, const std::string& photo, const Path& interior) {
  const std::string folder = folder_path.string();
  const CameraFile camera = ReadCameraFile(block::BlockCameraPath(folder));
  const bool film = camera.camera.kind == CameraKind::kFilm;
  const block::BlockPhotoFile read =
      block::ReadBlockPhoto(photo, ExteriorResultPath(folder, photo), camera,
                            film ? block::LoadMarkShapes(camera) : interior::MarkShapes(),
                            interior.empty() ? folder : interior.string());
  if (!read.HasPose())
    throw InputError(photo + " has no pose: " + JoinedSentences(read.exterior.findings));
  return read.ViewOfResult(camera.camera);
}

std::string ShapeText(const Array& array) {
  return py::str(array.attr("shape")).cast<std::string>();
}

// Of a digital camera, by its file or a name of the camera library: all that there is to know is
// the camera and the pose.
PhotoView OfPose(const Path& path_or_name, const py::object& numbers) {
  const std::string path = block::FindCameraFile(path_or_name.string(), "");
  const Camera camera = ReadCameraFile(path).camera;
  if (camera.kind != CameraKind::kDigital)
    throw InputError(path + " is a film camera: its photos need their interior orientation");
  const Array pose = Numbers(numbers, "pose");
  if (pose.size() != 6 || pose.ndim() > 2 || pose.shape(pose.ndim() - 1) != 6)
    throw py::value_error("pose has the shape " + ShapeText(pose) +
                          "; it must be one pose: the six numbers x, y, z (metres), omega, phi, "
                          "kappa (radians)");
  return {camera, DigitalPhotoFromPixel(camera), Pose::FromVector(ToRows<6>(pose, "pose").front())};
}

// Outside the camera's frame the lens is not known: NaN there, and behind the camera. The frame's
// corners belong to it, whatever rounding makes of them.
constexpr double kRounding_mm = 1e-6;

bool Shows(const PhotoView& view, const Eigen::Vector2d& photo_mm) {
  return view.camera.InFrame(photo_mm, kRounding_mm);
}

Array PixelsOf(const PhotoView& view, const py::object& ground) {
  std::vector<std::optional<Eigen::Vector2d>> pixels;
  for (const Eigen::Vector3d& point : ToRows<3>(ground, "ground points")) {
    const auto photo_mm = PhotoFromGround(view.camera, view.pose, point);
    const bool shown = photo_mm && Shows(view, *photo_mm);
    pixels.push_back(shown ? std::optional(view.PixelFromPhoto(*photo_mm)) : std::nullopt);
  }
  return Rows<2>(pixels);
}

Array PhotoFromPixels(const PhotoView& view, const py::object& pixels) {
  std::vector<std::optional<Eigen::Vector2d>> photo_mm;
  for (const Eigen::Vector2d& pixel : ToRows<2>(pixels, "pixels"))
    photo_mm.emplace_back(view.PhotoFromPixel(pixel));
  return Rows<2>(photo_mm);
}

Array RaysOf(const PhotoView& view, const py::object& pixels) {
  std::vector<std::optional<Eigen::Vector3d>> directions;
  for (const Eigen::Vector2d& pixel : ToRows<2>(pixels, "pixels")) {
    const Eigen::Vector2d photo_mm = view.PhotoFromPixel(pixel);
    const auto ray =
        Shows(view, photo_mm) ? GroundRayFromPhoto(view.camera, view.pose, photo_mm) : std::nullopt;
    directions.push_back(ray ? std::optional(ray->direction) : std::nullopt);
  }
  return Rows<3>(directions);
}

Array GroundOf(const PhotoView& view, const py::object& pixels, const GroundSurface& surface) {
  std::vector<std::optional<Eigen::Vector3d>> ground;
  for (const Eigen::Vector2d& pixel : ToRows<2>(pixels, "pixels"))
    ground.push_back(Shows(view, view.PhotoFromPixel(pixel)) ? view.GroundFromPixel(pixel, surface)
                                                             : std::nullopt);
  return Rows<3>(ground);
}

Array HeightsAt(const GroundSurface& surface, const py::object& places) {
  const auto rows = ToRows<2>(places, "places");
  Eigen::VectorXd heights(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    heights[static_cast<Eigen::Index>(i)] = OrNan(surface.HeightAt(rows[i].x(), rows[i].y()));
  return FromVector(heights);
}

// What a call with other arguments is told: pybind11 would print the arrays that were given. Its
// first look for an overload converts nothing, so what this stands beside takes any object.
template <typename... Before>
auto Expects(const std::string& words) {
  return [words](const Before&..., const py::args&, const py::kwargs&) -> py::object {
    throw py::type_error(words);
  };
}

}  // namespace

void AddGeometry(py::module_& m) {
  using Surface = GroundSurface;
  using View = PhotoView;
  py::class_<Surface>(m, "Surface")
      .def(py::init([](const Path& path, const std::string& crs) {
             return Surface::FromFile(path.string(), Crs::Parse(crs, "crs"));
           }),
           py::arg("path"), py::arg("crs"))
      .def("heights", &HeightsAt, py::arg("places"))
      .def("heights", Expects<Surface>("heights(places): places is an array of numbers, (n, 2)"));
  py::class_<View>(m, "PhotoGeometry")
      .def_static("of_result", &OfResult, py::arg("folder"), py::arg("photo"),
                  py::arg("interior") = "")
      .def_static("of_pose", &OfPose, py::arg("camera"), py::arg("pose"))
      .def_static("of_pose", Expects<>("of_pose(camera, pose): camera is a file or a name of the "
                                       "camera library, pose six numbers: x, y, z (metres), omega, "
                                       "phi, kappa (radians)"))
      .def_property_readonly("pose", [](const View& v) { return FromVector(v.pose.AsVector()); })
      .def_property_readonly("principal_distance_mm",
                             [](const View& v) { return v.camera.principal_distance_mm; })
      .def("pixels", &PixelsOf, py::arg("ground"))
      .def("pixels", Expects<View>("pixels(ground): ground is an array of numbers, (n, 3)"))
      .def("photo_mm", &PhotoFromPixels, py::arg("pixels"))
      .def("photo_mm", Expects<View>("photo_mm(pixels): pixels is an array of numbers, (n, 2)"))
      .def("rays", &RaysOf, py::arg("pixels"))
      .def("rays", Expects<View>("rays(pixels): pixels is an array of numbers, (n, 2)"))
      .def("ground", &GroundOf, py::arg("pixels"), py::arg("surface"))
      .def("ground", Expects<View>("ground(pixels, surface): pixels is an array of numbers, (n, "
                                   "2), surface an orient.Surface"));
}

}  // namespace orient::python
