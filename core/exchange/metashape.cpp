#include "core/exchange/metashape.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/column_names.h"
#include "core/base/csv_cell.h"
#include "core/base/error.h"
#include "core/exchange/text_lines.h"
#include "core/exchange/xml_elements.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr const char* kLocalReference =
    "LOCAL_CS[&quot;Local Coordinates (m)&quot;,LOCAL_DATUM[&quot;Local Datum&quot;,0],"
    "UNIT[&quot;metre&quot;,1,AUTHORITY[&quot;EPSG&quot;,&quot;9001&quot;]]]";

std::string Numbers(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(ExactNumber(value));
  return fmt::format("{}", fmt::join(texts, " "));
}

std::string Label(const std::string& image) { return BareImageName(image); }

std::string SensorText(const ExchangeCamera& camera, std::size_t id) {
  const std::string size =
      fmt::format(R"(<resolution width="{}" height="{}"/>)", camera.width, camera.height);
  const Eigen::Vector2d& f = camera.focal_px;
  std::string text = fmt::format(R"(      <sensor id="{}" label="{}" type="frame">
        {}
        <property name="pixel_width" value="{}"/>
        <property name="pixel_height" value="{}"/>
        <property name="focal_length" value="{}"/>
        <calibration type="frame" class="adjusted">
          {}
)",
                                 id, XmlEscaped(camera.name), size, ExactNumber(camera.pixel_mm),
                                 ExactNumber(camera.pixel_mm * f.x() / f.y()),
                                 ExactNumber(f.x() * camera.pixel_mm), size);
  const std::pair<const char*, double> elements[] = {
      {"f", f.y()},
      {"cx", camera.principal_px.x() - 0.5 * camera.width},
      {"cy", camera.principal_px.y() - 0.5 * camera.height},
      {"b1", f.x() - f.y()},
      {"k1", camera.k[0]},
      {"k2", camera.k[1]},
      {"k3", camera.k[2]},
      {"p1", camera.p[0]},
      {"p2", camera.p[1]}};
  for (const auto& [name, value] : elements)
    text += fmt::format("          <{0}>{1}</{0}>\n", name, ExactNumber(value));
  return text + "        </calibration>\n      </sensor>\n";
}

std::string CameraText(const ExchangePhoto& photo, std::size_t id) {
  const Eigen::Matrix3d r = GroundFromCamera(photo);
  const Eigen::Vector3d& t = photo.centre;
  return fmt::format(R"(      <camera id="{}" sensor_id="{}" label="{}" enabled="1">
        <transform>{}</transform>
      </camera>
)",
                     id, photo.camera, XmlEscaped(Label(photo.image)),
                     Numbers({r(0, 0), r(0, 1), r(0, 2), t[0], r(1, 0), r(1, 1), r(1, 2), t[1],  //
                              r(2, 0), r(2, 1), r(2, 2), t[2], 0, 0, 0, 1}));
}

std::string DocumentText(const ExchangeBlock& block) {
  std::string sensors, cameras;
  for (std::size_t i = 0; i < block.cameras.size(); ++i) sensors += SensorText(block.cameras[i], i);
  for (std::size_t i = 0; i < block.photos.size(); ++i) cameras += CameraText(block.photos[i], i);
  return fmt::format(R"(<?xml version="1.0" encoding="UTF-8"?>
<document version="1.5.0">
  <chunk label="orient" enabled="true">
    <sensors next_id="{}">
{}    </sensors>
    <cameras next_id="{}" next_group_id="0">
{}    </cameras>
    <reference>{}</reference>
    <transform>
      <rotation locked="1">1 0 0 0 1 0 0 0 1</rotation>
      <translation locked="1">{}</translation>
      <scale locked="1">1</scale>
    </transform>
  </chunk>
</document>
)",
                     block.cameras.size(), sensors, block.photos.size(), cameras, kLocalReference,
                     Numbers({block.origin[0], block.origin[1], block.origin[2]}));
}

std::string ReferenceTable(const ExchangeBlock& block) {
  std::string text = "#Label,X,Y,Z,Omega,Phi,Kappa\n";
  for (const ExchangePhoto& photo : block.photos) {
    const Eigen::Vector3d opk = OpkFromRotation(photo.ground_from_photo);
    const Eigen::Vector3d centre = photo.centre + block.origin;
    const std::string label = Label(photo.image);
    text += label.find_first_of(",\"\n") == std::string::npos ? label : CsvCell(label);
    for (const double value : {centre.x(), centre.y(), centre.z(), DegFromRad(opk[0]),
                               DegFromRad(opk[1]), DegFromRad(opk[2])})
      text += ',' + ExactNumber(value);
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

int AttributeCount(const XmlElement& element, const char* key) {
  return WholeNumber(AttributeNumber(element, key), element.Where(), key);
}

// PhotoScan's older calibrations: two focal lengths, the principal point as a pixel of the image
// (its upper-left corner is 0), and a skew.
void ReadFocalLengths(const XmlElement& calibration, MetashapeSensor* sensor) {
  const double fx = calibration.At("fx").Number();
  sensor->f = calibration.At("fy").Number();
  sensor->b1 = fx - sensor->f;
  if (Of(calibration, "skew") != 0)
    throw InputError(calibration.Where() + ": skew is not 0, which is not supported");
  // PhotoScan's releases differ in the order of p1 and p2.
  if (sensor->p1 != 0 || sensor->p2 != 0)
    throw InputError(calibration.Where() +
                     ": p1 and p2 beside fx and fy, whose order PhotoScan has changed, are not " +
                     "supported; export the cameras with a newer release");
  sensor->cx = calibration.At("cx").Number() - 0.5 * sensor->width;
  sensor->cy = calibration.At("cy").Number() - 0.5 * sensor->height;
  constexpr double kMost = 0.25;  // of the image
  if (!(std::abs(sensor->cx) <= kMost * sensor->width &&
        std::abs(sensor->cy) <= kMost * sensor->height))
    throw InputError(
        calibration.Where() +
        ": cx and cy beside fx and fy are a pixel of the image, but lie far from its " + "middle");
}

MetashapeSensor ReadSensor(const XmlElement& element) {
  MetashapeSensor sensor;
  sensor.id = AttributeCount(element, "id");
  const auto label = element.attributes.find("label");
  if (label != element.attributes.end()) sensor.label = label->second;
  const auto calibrations = element.All("calibration");
  if (calibrations.empty()) throw InputError(element.Where() + " has no <calibration>");
  // The adjusted calibration is used, even if there is an initial one, too.
  const XmlElement* calibration = calibrations.front();
  for (const XmlElement* c : calibrations) {
    const auto of = c->attributes.find("class");
    if (of != c->attributes.end() && of->second == "adjusted") calibration = c;
  }
  const auto type = calibration->attributes.find("type");
  if (type != calibration->attributes.end() && type->second != "frame")
    throw InputError(fmt::format("{} is of type {}; only frame cameras are supported",
                                 calibration->Where(), type->second));
  const XmlElement* size = calibration->Find("resolution");
  if (size == nullptr) size = &element.At("resolution");
  sensor.width = AttributeCount(*size, "width");
  sensor.height = AttributeCount(*size, "height");
  sensor.cx = Of(*calibration, "cx");
  sensor.cy = Of(*calibration, "cy");
  sensor.k1 = Of(*calibration, "k1");
  sensor.k2 = Of(*calibration, "k2");
  sensor.k3 = Of(*calibration, "k3");
  sensor.p1 = Of(*calibration, "p1");
  sensor.p2 = Of(*calibration, "p2");
  sensor.b1 = Of(*calibration, "b1");
  sensor.b2 = Of(*calibration, "b2");
  if (calibration->Find("f") == nullptr && calibration->Find("fx") != nullptr)
    ReadFocalLengths(*calibration, &sensor);
  else
    sensor.f = calibration->At("f").Number();
  for (const char* other : {"k4", "p3", "p4"})
    if (Of(*calibration, other) != 0)
      throw InputError(
          fmt::format("{}: {} is not 0, which is not supported", calibration->Where(), other));
  for (const XmlElement* property : element.All("property"))
    if (property->Attribute("name") == "pixel_width")
      sensor.pixel_mm = AttributeNumber(*property, "value");
  return sensor;
}

void ReadChunkTransform(const XmlElement& element, MetashapeChunk* chunk) {
  chunk->placed = true;
  if (const XmlElement* rotation = element.Find("rotation"))
    chunk->rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>(rotation->Numbers(9).data());
  if (const XmlElement* translation = element.Find("translation"))
    chunk->translation = Eigen::Vector3d(translation->Numbers(3).data());
  if (const XmlElement* scale = element.Find("scale")) chunk->scale = scale->Number();
}

std::string AttributeOr(const XmlElement& element, const char* key, const std::string& otherwise) {
  const auto found = element.attributes.find(key);
  return found == element.attributes.end() ? otherwise : found->second;
}

bool IsEnabled(const XmlElement& element) {
  const std::string enabled = AttributeOr(element, "enabled", "1");
  return enabled != "0" && enabled != "false";
}

// Null if the chunk is not divided into components.
const XmlElement* ActiveComponent(const XmlElement& chunk) {
  const XmlElement* components = chunk.Find("components");
  if (components == nullptr) return nullptr;
  const auto all = components->All("component");
  const auto active = std::find_if(all.begin(), all.end(), [&](const XmlElement* component) {
    return component->attributes.contains("id") &&
           component->Attribute("id") == AttributeOr(*components, "active_id", "");
  });
  if (active != all.end()) return *active;
  return all.empty() ? nullptr : all.front();
}

std::optional<Eigen::Vector3d> ReadReference(const XmlElement& camera) {
  const XmlElement* reference = camera.Find("reference");
  if (reference == nullptr || !IsEnabled(*reference)) return std::nullopt;
  for (const char* key : {"x", "y", "z"})
    if (!reference->attributes.contains(key)) return std::nullopt;
  return Eigen::Vector3d(AttributeNumber(*reference, "x"), AttributeNumber(*reference, "y"),
                         AttributeNumber(*reference, "z"));
}

// `component`: the active one's id.
void CollectCameras(const XmlElement& element, const std::string& component,
                    MetashapeChunk* chunk) {
  for (const XmlElement& child : element.children) {
    if (child.name == "group") CollectCameras(child, component, chunk);
    if (child.name != "camera") continue;
    const XmlElement* transform = child.Find("transform");
    if (!IsEnabled(child)) {
      ++chunk->disabled;
    } else if (transform == nullptr) {
      ++chunk->not_aligned;
    } else if (AttributeOr(child, "component_id", component) != component) {
      ++chunk->of_other_components;
    } else {
      MetashapeCamera camera;
      camera.label = child.Attribute("label");
      camera.sensor = AttributeCount(child, "sensor_id");
      camera.transform =
          Eigen::Matrix<double, 4, 4, Eigen::RowMajor>(transform->Numbers(16).data());
      camera.reference = ReadReference(child);
      chunk->cameras.push_back(camera);
    }
  }
}

double ReadAccuracy(const XmlElement& chunk) {
  const XmlElement* settings = chunk.Find("settings");
  if (settings == nullptr) return 0;
  for (const XmlElement* property : settings->All("property"))
    if (AttributeOr(*property, "name", "") == "accuracy_cameras")
      return AttributeNumber(*property, "value");
  return 0;
}

std::size_t OtherChunks(const XmlElement& root) {
  std::size_t chunks = root.All("chunk").size();
  if (const XmlElement* all = root.Find("chunks")) chunks += all->All("chunk").size();
  return chunks > 0 ? chunks - 1 : 0;
}

void ReadGround(const XmlElement& element, const XmlElement* component, MetashapeChunk* chunk) {
  const XmlElement* transform = component == nullptr ? nullptr : component->Find("transform");
  if (transform == nullptr) transform = element.Find("transform");
  if (transform != nullptr) ReadChunkTransform(*transform, chunk);
  if (const XmlElement* reference = element.Find("reference")) chunk->reference = reference->text;
  chunk->accuracy_m = ReadAccuracy(element);
}

}  // namespace

void WriteMetashape(const std::string& directory, const ExchangeBlock& block) {
  WriteFileAtomically((fs::path(directory) / "cameras.xml").string(), DocumentText(block));
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
  const XmlElement* component = ActiveComponent(*element);
  CollectCameras(element->At("cameras"),
                 component == nullptr ? "" : AttributeOr(*component, "id", ""), &chunk);
  if (chunk.cameras.empty())
    throw InputError(
        fmt::format("{} holds no camera with a <transform> that is enabled ({} are "
                    "disabled, {} not aligned); align them in Metashape",
                    file, chunk.disabled, chunk.not_aligned));
  chunk.other_chunks = OtherChunks(root);
  ReadGround(*element, component, &chunk);
  for (const MetashapeCamera& camera : chunk.cameras)
    if (std::none_of(chunk.sensors.begin(), chunk.sensors.end(),
                     [&](const MetashapeSensor& s) { return s.id == camera.sensor; }))
      throw InputError(fmt::format("{}: camera \"{}\" names sensor {}, which has no calibration",
                                   file, camera.label, camera.sensor));
  return chunk;
}

bool IsGeocentric(const MetashapeChunk& chunk) {
  return !chunk.reference.empty() && !chunk.reference.starts_with("LOCAL_CS");
}

ExchangeBlock ExchangeFromMetashape(const MetashapeChunk& chunk) {
  ExchangeBlock block;
  for (const MetashapeSensor& s : chunk.sensors) {
    if (s.b2 != 0)
      throw InputError("sensor \"" + s.label + "\": b2 (skew) is not 0, which is not supported");
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
