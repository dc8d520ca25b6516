#include "core/exchange/micmac_measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "core/base/atomic_write.h"
#include "core/base/output_directory.h"
#include "core/exchange/xml_elements.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

fs::path Folder(const std::string& directory) {
  const fs::path folder = fs::path(directory) / "Ori-InterneScan";
  MakeOutputDirectory(folder.string());
  return folder;
}

}  // namespace

std::vector<MicmacPoint> MicmacCameraPoints(const std::vector<Fiducial>& fiducials) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double left = kInfinity, top = -kInfinity;
  for (const Fiducial& f : fiducials) {
    left = std::min(left, f.position_mm.x());
    top = std::max(top, f.position_mm.y());
  }
  std::vector<MicmacPoint> points;
  for (const Fiducial& f : fiducials)
    points.push_back({f.id, {f.position_mm.x() - left, top - f.position_mm.y()}});
  return points;
}

std::vector<MicmacPoint> MicmacImagePoints(const InteriorResult& result) {
  std::vector<MicmacPoint> points;
  for (const MarkResult& mark : result.marks)
    if (mark.state == MarkState::kUsed && mark.pixel)
      points.push_back({mark.id, *mark.pixel - Eigen::Vector2d(0.5, 0.5)});
  return points;
}

std::string MicmacMeasures(const std::string& image, const std::vector<MicmacPoint>& points) {
  std::string text = fmt::format(R"(<?xml version="1.0" ?>
<MesureAppuiFlottant1Im>
  <NameIm>{}</NameIm>
)",
                                 XmlEscaped(image));
  for (const MicmacPoint& point : points)
    text += fmt::format(R"(  <OneMesureAF1I>
    <NamePt>{}</NamePt>
    <PtIm>{:.6f} {:.6f}</PtIm>
  </OneMesureAF1I>
)",
                        XmlEscaped(point.name), point.position.x(), point.position.y());
  return text + "</MesureAppuiFlottant1Im>\n";
}

void WriteMicmacCamera(const std::string& directory, const std::vector<Fiducial>& fiducials) {
  WriteFileAtomically((Folder(directory) / "MeasuresCamera.xml").string(),
                      MicmacMeasures("Glob", MicmacCameraPoints(fiducials)));
}

void WriteMicmacImage(const std::string& directory, const std::string& image_path,
                      const InteriorResult& result) {
  const std::string image = fs::path(image_path).filename().string();
  const fs::path path = Folder(directory) / ("MeasuresIm-" + image + ".xml");
  if (result.photo_from_pixel) {
    WriteFileAtomically(path.string(), MicmacMeasures(image, MicmacImagePoints(result)));
    return;
  }
  std::error_code absent;
  fs::remove(path, absent);
}

}  // namespace orient
