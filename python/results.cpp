// Result files and tables of orientations.
#include "core/files/results.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/files/finding.h"
#include "core/files/orientation_table.h"
#include "python/arrays.h"
#include "python/native.h"

namespace orient::python {
namespace {
namespace py = pybind11;
using Path = std::filesystem::path;  // str, bytes or os.PathLike

template <typename Value>
std::optional<std::string> NameOf(const std::optional<Value>& value) {
  if (!value) return std::nullopt;
  return std::string(Name(*value));
}

std::vector<std::string> NamesOf(const std::vector<ScanOrientation>& orientations) {
  std::vector<std::string> names;
  for (const ScanOrientation orientation : orientations) names.emplace_back(Name(orientation));
  return names;
}

// One array a field, a row an item.
template <int Size, typename Item>
Array Column(const std::vector<Item>& items,
             std::optional<Eigen::Matrix<double, Size, 1>> Item::*field) {
  std::vector<std::optional<Eigen::Matrix<double, Size, 1>>> rows;
  for (const Item& item : items) rows.push_back(item.*field);
  return Rows<Size>(rows);
}

template <typename Item>
Array Column(const std::vector<Item>& items, std::optional<double> Item::*field) {
  Eigen::VectorXd column(static_cast<Eigen::Index>(items.size()));
  Eigen::Index row = 0;
  for (const Item& item : items) column[row++] = OrNan(item.*field);
  return FromVector(column);
}

py::dict Patches(const ExteriorResult& result) {
  std::vector<std::int64_t> ids;
  std::vector<std::string> states;
  for (const PatchResult& patch : result.patches) {
    ids.push_back(patch.id);
    states.emplace_back(Name(patch.state));
  }
  return py::dict(
      py::arg("id") = py::array_t<std::int64_t>(static_cast<py::ssize_t>(ids.size()), ids.data()),
      py::arg("state") = states,
      py::arg("ground_m") = Column<3>(result.patches, &PatchResult::ground_m),
      py::arg("predicted_px") = Column<2>(result.patches, &PatchResult::predicted),
      py::arg("pixel") = Column<2>(result.patches, &PatchResult::pixel),
      py::arg("sigma_px") = Column<2>(result.patches, &PatchResult::sigma_px),
      py::arg("residual_px") = Column<2>(result.patches, &PatchResult::residual_px),
      py::arg("ncc") = Column(result.patches, &PatchResult::ncc));
}

py::dict Marks(const InteriorResult& result) {
  std::vector<std::string> ids, states;
  for (const MarkResult& mark : result.marks) {
    ids.push_back(mark.id);
    states.emplace_back(Name(mark.state));
  }
  return py::dict(py::arg("id") = ids, py::arg("state") = states,
                  py::arg("pixel") = Column<2>(result.marks, &MarkResult::pixel),
                  py::arg("sigma_px") = Column<2>(result.marks, &MarkResult::sigma_px),
                  py::arg("residual_um") = Column<2>(result.marks, &MarkResult::residual_um),
                  py::arg("score") = Column(result.marks, &MarkResult::score));
}

Array Footprint(const ExteriorResult& result) {
  std::vector<std::optional<Eigen::Vector3d>> corners(result.footprint_m.begin(),
                                                      result.footprint_m.end());
  return Rows<3>(corners);
}

// 2 x 3: linear part and translation.
std::optional<Array> Affine(const InteriorResult& result) {
  if (!result.photo_from_pixel) return std::nullopt;
  Eigen::Matrix<double, 2, 3> affine;
  affine << result.photo_from_pixel->A, result.photo_from_pixel->t;
  return FromMatrix(affine);
}

// Position and angles, NaN without a pose.
Array PoseOf(const ExteriorResult& result) {
  return FromVector(result.pose ? result.pose->AsVector() : Vector6d::Constant(kAbsent).eval());
}

Array CovarianceOf(const ExteriorResult& result) {
  return FromMatrix(result.covariance ? *result.covariance : Matrix6d::Constant(kAbsent).eval());
}

void AddFinding(py::module_& m) {
  py::class_<Finding>(m, "Finding")
      .def_property_readonly("code", [](const Finding& f) { return std::string(Code(f.reason)); })
      .def_property_readonly("at_best",
                             [](const Finding& f) { return std::string(Name(f.at_best)); })
      .def_readonly("value", &Finding::value)
      .def_readonly("limit", &Finding::limit)
      .def_readonly("where", &Finding::where)
      .def("__str__", &Sentence)
      .def("__repr__", [](const Finding& f) {
        return "<Finding " + std::string(Code(f.reason)) + ": " + Sentence(f) + ">";
      });
}

template <typename Result>
std::string Repr(const char* type, const Result& result) {
  return std::string("<") + type + " " + result.photo + ": " + std::string(Name(result.status)) +
         ">";
}

void AddInterior(py::module_& m) {
  using R = InteriorResult;
  py::class_<R>(m, "InteriorResult")
      .def_readonly("photo", &R::photo)
      .def_property_readonly("status", [](const R& r) { return std::string(Name(r.status)); })
      .def_readonly("findings", &R::findings)
      .def_readonly("width", &R::width)
      .def_readonly("height", &R::height)
      .def_readonly("pixel_size_um", &R::pixel_size_um)
      .def_property_readonly("polarity", [](const R& r) { return NameOf(r.polarity); })
      .def_property_readonly("scan_orientation", [](const R& r) { return NameOf(r.orientation); })
      .def_property_readonly("possible_orientations",
                             [](const R& r) { return NamesOf(r.possible_orientations); })
      .def_property_readonly("photo_from_pixel", &Affine)
      .def_readonly("sigma0_um", &R::sigma0_um)
      .def_property_readonly("marks", &Marks)
      .def_readonly("cameras", &R::cameras)
      .def("__repr__", [](const R& r) { return Repr("InteriorResult", r); });
  m.def(
      "read_interior", [](const Path& path) { return ReadInteriorResult(path.string()); },
      py::arg("path"));
}

void AddExterior(py::module_& m) {
  using R = ExteriorResult;
  py::class_<R>(m, "ExteriorResult")
      .def_readonly("photo", &R::photo)
      .def_property_readonly("status", [](const R& r) { return std::string(Name(r.status)); })
      .def_readonly("findings", &R::findings)
      .def_readonly("width", &R::width)
      .def_readonly("height", &R::height)
      .def_property_readonly("pose", &PoseOf)
      .def_property_readonly("covariance", &CovarianceOf)
      .def_readonly("sigma0_px", &R::sigma0_px)
      .def_property_readonly("projection_sigma",
                             [](const R& r) -> std::optional<std::pair<double, double>> {
                               if (!r.projection_sigma) return std::nullopt;
                               return std::pair(r.projection_sigma->px, r.projection_sigma->m);
                             })
      .def_readonly("target_m", &R::target_m)
      .def_property_readonly("scan_orientation", [](const R& r) { return NameOf(r.orientation); })
      .def_property_readonly("footprint_m", &Footprint)
      .def_property_readonly("patches", &Patches)
      .def("__repr__", [](const R& r) { return Repr("ExteriorResult", r); });
  m.def(
      "read_exterior", [](const Path& path) { return ReadExteriorResult(path.string()); },
      py::arg("path"));
}

// Names, poses (n, 6), sigmas (n, 6), and the CRS as WKT.
py::dict ReadPoses(const Path& path) {
  const OrientationTable table = ReadOrientationTable(path.string());
  std::vector<std::string> photos;
  std::vector<std::optional<Vector6d>> poses, sigmas;
  for (const OrientationRow& row : table.rows) {
    photos.push_back(row.photo);
    poses.emplace_back(row.pose.AsVector());
    sigmas.push_back(row.sigma);
  }
  std::optional<std::string> crs;
  if (table.crs) crs = table.crs->Wkt();
  return py::dict(py::arg("photos") = photos, py::arg("poses") = Rows<6>(poses),
                  py::arg("sigmas") = Rows<6>(sigmas), py::arg("crs") = crs);
}

}  // namespace

void AddResults(py::module_& m) {
  AddFinding(m);
  AddInterior(m);
  AddExterior(m);
  m.def("read_poses", &ReadPoses, py::arg("path"));
}

}  // namespace orient::python
