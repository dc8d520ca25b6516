#include "core/files/exchange/metashape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "core/files/atomic_write.h"
#include "core/files/exchange/text_lines.h"
#include "core/files/exchange/xml_elements.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr const char* kLocalReference =
    "LOCAL_CS[&quot;Local Coordinates (m)&quot;,LOCAL_DATUM[&quot;Local Datum&quot;,0],"
    "UNIT[&quot;metre&quot;,1,AUTHORITY[&quot;EPSG&quot;,&quot;9001&quot;]]]";

std::string Numbers(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) {
    if (!text.empty()) text += ' ';
    text += ExactNumber(value);
  }
  return text;
}

std::string Label(const std::string& image) { return fs::path(image).stem().string(); }

void Element(const std::string& name, double value, std::string* text) {
  *text += "          <" + name + ">" + ExactNumber(value) + "</" + name + ">\n";
}

std::string SizeText(const ExchangeCamera& camera) {
  return "<resolution width=\"" + std::to_string(camera.width) + "\" height=\"" +
         std::to_string(camera.height) + "\"/>\n";
}

std::string SensorText(const ExchangeCamera& camera, std::size_t id) {
  std::string text = "      <sensor id=\"" + std::to_string(id) + "\" label=\"";
  text += XmlEscaped(camera.name) + "\" type=\"frame\">\n        " + SizeText(camera);
  const double pixel_y = camera.pixel_mm * camera.focal_px.x() / camera.focal_px.y();
  text += "        <property name=\"pixel_width\" value=\"" + ExactNumber(camera.pixel_mm) +
          "\"/>\n        <property name=\"pixel_height\" value=\"" + ExactNumber(pixel_y) +
          "\"/>\n        <property name=\"focal_length\" value=\"" +
          ExactNumber(camera.focal_px.x() * camera.pixel_mm) + "\"/>\n";
  text += "        <calibration type=\"frame\" class=\"adjusted\">\n          " + SizeText(camera);
  Element("f", camera.focal_px.y(), &text);
  Element("cx", camera.principal_px.x() - 0.5 * camera.width, &text);
  Element("cy", camera.principal_px.y() - 0.5 * camera.height, &text);
  Element("b1", camera.focal_px.x() - camera.focal_px.y(), &text);
  Element("k1", camera.k[0], &text);
  Element("k2", camera.k[1], &text);
  Element("k3", camera.k[2], &text);
  Element("p1", camera.p[0], &text);
  Element("p2", camera.p[1], &text);
  return text + "        </calibration>\n      </sensor>\n";
}

std::string CameraText(const ExchangePhoto& photo, std::size_t id) {
  const Eigen::Matrix3d r = GroundFromCamera(photo);
  const Eigen::Vector3d& t = photo.centre;
  std::string text = "      <camera id=\"" + std::to_string(id) + "\" sensor_id=\"" +
                     std::to_string(photo.camera) + "\" label=\"";
  text += XmlEscaped(Label(photo.image)) + "\" enabled=\"1\">\n        <transform>";
  text += Numbers({r(0, 0), r(0, 1), r(0, 2), t[0], r(1, 0), r(1, 1), r(1, 2), t[1],  //
                   r(2, 0), r(2, 1), r(2, 2), t[2], 0, 0, 0, 1});
  return text + "</transform>\n      </camera>\n";
}

std::string ChunkTransformText(const Eigen::Vector3d& translation) {
  return "    <transform>\n      <rotation locked=\"1\">1 0 0 0 1 0 0 0 1</rotation>\n"
         "      <translation locked=\"1\">" +
         Numbers({translation[0], translation[1], translation[2]}) +
         "</translation>\n      <scale locked=\"1\">1</scale>\n    </transform>\n";
}

std::string ReferenceTable(const ExchangeBlock& block) {
  std::string text = "#Label,X,Y,Z,Omega,Phi,Kappa\n";
  for (const ExchangePhoto& photo : block.photos) {
    const Eigen::Vector3d opk = OpkFromRotation(photo.ground_from_photo);
    const Eigen::Vector3d centre = photo.centre + block.origin;
    text += Label(photo.image);
    for (const double value : {centre.x(), centre.y(), centre.z(), DegFromRad(opk[0]),
                               DegFromRad(opk[1]), DegFromRad(opk[2])}) {
      text += ',';
      text += ExactNumber(value);
    }
    text += '\n';
  }
  return text;
}

double Of(const XmlElement& calibration, const char* name) {
  const XmlElement* found = calibration.Find(name);
  return found == nullptr ? 0 : found->Number();
}

double AttributeNumber(const XmlElement& element, const char* key) {
  return ParseNumber(element.Attribute(key), element.Where(), key);
}

MetashapeSensor ReadSensor(const XmlElement& element) {
  MetashapeSensor sensor;
  sensor.id = static_cast<int>(AttributeNumber(element, "id"));
  const auto label = element.attributes.find("label");
  if (label != element.attributes.end()) sensor.label = label->second;
  const auto calibrations = element.All("calibration");
  if (calibrations.empty()) throw InputError(element.Where() + " has no <calibration>");
  // The adjusted one counts, where there is an initial one too.
  const XmlElement* calibration = calibrations.front();
  for (const XmlElement* c : calibrations) {
    const auto of = c->attributes.find("class");
    if (of != c->attributes.end() && of->second == "adjusted") calibration = c;
  }
  const auto type = calibration->attributes.find("type");
  if (type != calibration->attributes.end() && type->second != "frame")
    throw InputError(calibration->Where() + " is of type " + type->second +
                     "; only frame cameras can be held");
  const XmlElement* size = calibration->Find("resolution");
  if (size == nullptr) size = &element.At("resolution");
  sensor.width = static_cast<int>(AttributeNumber(*size, "width"));
  sensor.height = static_cast<int>(AttributeNumber(*size, "height"));
  sensor.f = calibration->At("f").Number();
  sensor.cx = Of(*calibration, "cx");
  sensor.cy = Of(*calibration, "cy");
  sensor.k1 = Of(*calibration, "k1");
  sensor.k2 = Of(*calibration, "k2");
  sensor.k3 = Of(*calibration, "k3");
  sensor.p1 = Of(*calibration, "p1");
  sensor.p2 = Of(*calibration, "p2");
  sensor.b1 = Of(*calibration, "b1");
  sensor.b2 = Of(*calibration, "b2");
  for (const char* other : {"k4", "p3", "p4"})
    if (Of(*calibration, other) != 0)
      throw InputError(calibration->Where() + ": " + other + " is not 0 and cannot be held");
  for (const XmlElement* property : element.All("property"))
    if (property->Attribute("name") == "pixel_width")
      sensor.pixel_mm = AttributeNumber(*property, "value");
  return sensor;
}

void ReadChunkTransform(const XmlElement& element, MetashapeChunk* chunk) {
  if (const XmlElement* rotation = element.Find("rotation"))
    chunk->rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>(rotation->Numbers(9).data());
  if (const XmlElement* translation = element.Find("translation"))
    chunk->translation = Eigen::Vector3d(translation->Numbers(3).data());
  if (const XmlElement* scale = element.Find("scale")) chunk->scale = scale->Number();
}

void CollectCameras(const XmlElement& element, MetashapeChunk* chunk) {
  for (const XmlElement& child : element.children) {
    if (child.name == "group") CollectCameras(child, chunk);
    if (child.name != "camera") continue;
    const XmlElement* transform = child.Find("transform");
    if (transform == nullptr) continue;  // not aligned
    MetashapeCamera camera;
    camera.label = child.Attribute("label");
    camera.sensor = static_cast<int>(AttributeNumber(child, "sensor_id"));
    camera.transform = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>(transform->Numbers(16).data());
    chunk->cameras.push_back(camera);
  }
}

}  // namespace

void WriteMetashape(const std::string& directory, const ExchangeBlock& block) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"1.5.0\">\n"
      "  <chunk label=\"orient\" enabled=\"true\">\n    <sensors next_id=\"" +
      std::to_string(block.cameras.size()) + "\">\n";
  for (std::size_t i = 0; i < block.cameras.size(); ++i) text += SensorText(block.cameras[i], i);
  text += "    </sensors>\n    <cameras next_id=\"" + std::to_string(block.photos.size()) +
          "\" next_group_id=\"0\">\n";
  for (std::size_t i = 0; i < block.photos.size(); ++i) text += CameraText(block.photos[i], i);
  text += "    </cameras>\n    <reference>";
  text += kLocalReference;
  text += "</reference>\n" + ChunkTransformText(block.origin) + "  </chunk>\n</document>\n";
  WriteFileAtomically((fs::path(directory) / "cameras.xml").string(), text);
  WriteFileAtomically((fs::path(directory) / "reference.txt").string(), ReferenceTable(block));
}

MetashapeChunk ReadMetashape(const std::string& path) {
  const std::string file =
      fs::is_directory(path) ? (fs::path(path) / "cameras.xml").string() : path;
  const XmlElement root = ReadXml(file);
  const XmlElement* element = root.name == "chunk" ? &root : root.Below("chunk");
  if (element == nullptr) throw InputError(file + " holds no <chunk>");
  MetashapeChunk chunk;
  for (const XmlElement* sensor : element->At("sensors").All("sensor"))
    if (sensor->Find("calibration") != nullptr) chunk.sensors.push_back(ReadSensor(*sensor));
  CollectCameras(element->At("cameras"), &chunk);
  if (chunk.cameras.empty()) throw InputError(file + " holds no camera with a <transform>");
  if (const XmlElement* transform = element->Find("transform"))
    ReadChunkTransform(*transform, &chunk);
  if (const XmlElement* reference = element->Find("reference")) chunk.reference = reference->text;
  for (const MetashapeCamera& camera : chunk.cameras)
    if (std::none_of(chunk.sensors.begin(), chunk.sensors.end(),
                     [&](const MetashapeSensor& s) { return s.id == camera.sensor; }))
      throw InputError(file + ": camera \"" + camera.label + "\" names sensor " +
                       std::to_string(camera.sensor) + ", which has no calibration");
  return chunk;
}

bool IsGeocentric(const MetashapeChunk& chunk) {
  return !chunk.reference.empty() && !chunk.reference.starts_with("LOCAL_CS");
}

ExchangeBlock ExchangeFromMetashape(const MetashapeChunk& chunk) {
  ExchangeBlock block;
  for (const MetashapeSensor& s : chunk.sensors) {
    if (s.b2 != 0)
      throw InputError("sensor \"" + s.label + "\": b2 (skew) is not 0 and cannot be held");
    ExchangeCamera camera;
    camera.name = s.label;
    camera.width = s.width;
    camera.height = s.height;
    camera.pixel_mm = s.pixel_mm;
    camera.focal_px = {s.f + s.b1, s.f};
    camera.principal_px = {0.5 * s.width + s.cx, 0.5 * s.height + s.cy};
    camera.k = {s.k1, s.k2, s.k3};
    camera.p = {s.p1, s.p2};
    block.cameras.push_back(camera);
  }
  for (const MetashapeCamera& camera : chunk.cameras) {
    ExchangePhoto photo;
    photo.image = camera.label;
    const auto sensor =
        std::find_if(chunk.sensors.begin(), chunk.sensors.end(),
                     [&](const MetashapeSensor& s) { return s.id == camera.sensor; });
    photo.camera = static_cast<std::size_t>(sensor - chunk.sensors.begin());
    const Eigen::Vector3d local = camera.transform.block<3, 1>(0, 3);
    photo.centre = chunk.scale * (chunk.rotation * local) + chunk.translation;
    SetGroundFromCamera(chunk.rotation * camera.transform.block<3, 3>(0, 0), &photo);
    block.photos.push_back(photo);
  }
  return block;
}

}  // namespace orient
