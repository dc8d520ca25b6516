#include "core/exchange/metashape_markers.h"

#include <fmt/format.h>

#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/column_names.h"
#include "core/exchange/xml_elements.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string CameraText(const ExchangePhoto& photo, std::size_t id) {
  return fmt::format("      <camera id=\"{}\" label=\"{}\"/>\n", id,
                     XmlEscaped(BareImageName(photo.image)));
}

std::string MarkerText(const ExchangePoint& point, std::size_t id, const Eigen::Vector3d& origin) {
  const std::string begin =
      fmt::format("      <marker id=\"{}\" label=\"{}\"", id, XmlEscaped(point.name));
  if (!point.control) return begin + "/>\n";
  const Eigen::Vector3d world = point.ground + origin;
  return fmt::format(R"({}>
        <reference x="{}" y="{}" z="{}" enabled="1"/>
      </marker>
)",
                     begin, ExactNumber(world.x()), ExactNumber(world.y()), ExactNumber(world.z()));
}

std::string ProjectionsText(const ExchangePoint& point, std::size_t id) {
  std::string text = fmt::format("          <marker marker_id=\"{}\">\n", id);
  for (const ExchangeObservation& seen : point.observations)
    text += fmt::format("            <location camera_id=\"{}\" pinned=\"1\" x=\"{}\" y=\"{}\"/>\n",
                        seen.photo, ExactNumber(seen.pixel.x()), ExactNumber(seen.pixel.y()));
  return text + "          </marker>\n";
}

}  // namespace

void WriteMetashapeMarkers(const std::string& directory, const ExchangeBlock& block) {
  std::string cameras, markers, projections;
  for (std::size_t i = 0; i < block.photos.size(); ++i) cameras += CameraText(block.photos[i], i);
  for (std::size_t i = 0; i < block.points.size(); ++i) {
    markers += MarkerText(block.points[i], i, block.origin);
    projections += ProjectionsText(block.points[i], i);
  }
  const std::string text = fmt::format(R"(<?xml version="1.0" encoding="UTF-8"?>
<document version="1.5.0">
  <chunk label="orient" enabled="true">
    <cameras>
{}    </cameras>
    <markers next_id="{}" next_group_id="0">
{}    </markers>
    <frames next_id="1">
      <frame id="0">
        <markers>
{}        </markers>
      </frame>
    </frames>
  </chunk>
</document>
)",
                                       cameras, block.points.size(), markers, projections);
  WriteFileAtomically((fs::path(directory) / "markers.xml").string(), text);
}

}  // namespace orient
