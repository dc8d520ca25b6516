#include "core/files/micmac_measures.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "core/error.h"
#include "core/files/atomic_write.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else
      escaped += c;
  }
  return escaped;
}

std::string PointText(const Eigen::Vector2d& point) {
  std::array<char, 80> text;
  std::snprintf(text.data(), text.size(), "%.6f %.6f", point.x(), point.y());
  return text.data();
}

fs::path Folder(const std::string& directory) {
  const fs::path folder = fs::path(directory) / "Ori-InterneScan";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError("cannot make the folder " + folder.string() + ": " + error.message());
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
  std::string text = "<?xml version=\"1.0\" ?>\n<MesureAppuiFlottant1Im>\n  <NameIm>";
  text += Escaped(image) + "</NameIm>\n";
  for (const MicmacPoint& point : points) {
    text += "  <OneMesureAF1I>\n    <NamePt>" + Escaped(point.name) + "</NamePt>\n    <PtIm>";
    text += PointText(point.position) + "</PtIm>\n  </OneMesureAF1I>\n";
  }
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
