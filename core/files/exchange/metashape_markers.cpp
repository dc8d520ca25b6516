#include "core/files/exchange/metashape_markers.h"

#include <filesystem>

#include "core/files/atomic_write.h"
#include "core/files/exchange/xml_elements.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string Attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + XmlEscaped(value) + "\"";
}
std::string Attribute(const char* name, double value) {
  return Attribute(name, ExactNumber(value));
}

std::string CamerasText(const ExchangeBlock& block) {
  std::string text = "    <cameras>\n";
  for (std::size_t i = 0; i < block.photos.size(); ++i)
    text += "      <camera" + Attribute("id", std::to_string(i)) +
            Attribute("label", fs::path(block.photos[i].image).stem().string()) + "/>\n";
  return text + "    </cameras>\n";
}

std::string MarkerText(const ExchangePoint& point, std::size_t id, const Eigen::Vector3d& origin) {
  std::string text = "      <marker" + Attribute("id", std::to_string(id));
  text += Attribute("label", point.name);
  if (!point.control) return text + "/>\n";
  const Eigen::Vector3d world = point.ground + origin;
  text += ">\n        <reference" + Attribute("x", world.x()) + Attribute("y", world.y());
  return text + Attribute("z", world.z()) + " enabled=\"1\"/>\n      </marker>\n";
}

std::string ProjectionsText(const ExchangePoint& point, std::size_t id) {
  std::string text = "          <marker" + Attribute("marker_id", std::to_string(id)) + ">\n";
  for (const ExchangeObservation& seen : point.observations) {
    text += "            <location" + Attribute("camera_id", std::to_string(seen.photo));
    text += " pinned=\"1\"" + Attribute("x", seen.pixel.x()) + Attribute("y", seen.pixel.y());
    text += "/>\n";
  }
  return text + "          </marker>\n";
}

}  // namespace

void WriteMetashapeMarkers(const std::string& directory, const ExchangeBlock& block) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"1.5.0\">\n"
      "  <chunk label=\"orient\" enabled=\"true\">\n" +
      CamerasText(block) + "    <markers next_id=\"" + std::to_string(block.points.size()) +
      "\" next_group_id=\"0\">\n";
  for (std::size_t i = 0; i < block.points.size(); ++i)
    text += MarkerText(block.points[i], i, block.origin);
  text += "    </markers>\n    <frames next_id=\"1\">\n      <frame id=\"0\">\n        <markers>\n";
  for (std::size_t i = 0; i < block.points.size(); ++i) text += ProjectionsText(block.points[i], i);
  text += "        </markers>\n      </frame>\n    </frames>\n  </chunk>\n</document>\n";
  WriteFileAtomically((fs::path(directory) / "markers.xml").string(), text);
}

}  // namespace orient
