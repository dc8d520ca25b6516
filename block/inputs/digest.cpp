#include "block/inputs/digest.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal_priv.h>

#include <filesystem>
#include <memory>
#include <set>

#include "core/base/atomic_write.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"

namespace orient::block {
namespace {

struct CloseFile {
  void operator()(VSILFILE* file) const { VSIFCloseL(file); }
};

// A raster's files and, through those that are rasters themselves, theirs.
void CollectFiles(const std::string& path, std::set<std::string>* files) {
  const GDALDatasetUniquePtr dataset = OpenRasterDataset(path);
  if (!dataset) return;
  const CPLStringList list(dataset->GetFileList());
  const bool made_of_others = dataset->GetDriverName() == std::string("VRT");
  for (int i = 0; i < list.size(); ++i) {
    const std::string file = list[i];
    // Statistics and overviews that a GIS leaves beside a DEM do not change its heights.
    if (file.ends_with(".aux.xml") || file.ends_with(".ovr")) continue;
    if (files->insert(file).second && made_of_others && file != path) CollectFiles(file, files);
  }
}

template <class T>
std::string OrNone(const std::optional<T>& value) {
  return value ? std::to_string(static_cast<int>(*value)) : "-";
}

}  // namespace

void DigestOfPieces::Add(std::string_view piece) {
  for (const char c : piece) hash_ = (hash_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
}

std::string DigestOfPieces::Digits() const { return fmt::format("{:016x}", hash_); }

std::string Digest(const std::string& text) {
  DigestOfPieces digest;
  digest.Add(text);
  return digest.Digits();
}

std::string DigestOf(const Inputs& inputs) {
  std::string text;
  for (const auto& [name, value] : inputs) text.append(name).append("=").append(value).append("\n");
  return Digest(text);
}

std::string DigestOfFile(const std::string& path) {
  if (IsPipe(path)) return "";
  RegisterGdalDrivers();
  const QuietGdal quiet;
  const std::unique_ptr<VSILFILE, CloseFile> file(VSIFOpenL(path.c_str(), "rb"));
  quiet.ThrowFaults();
  if (!file || VSIFSeekL(file.get(), 0, SEEK_END) != 0) return "";
  const vsi_l_offset length = VSIFTellL(file.get());
  std::string seen = std::to_string(length);
  constexpr vsi_l_offset kPiece = 1 << 16;
  std::string piece(kPiece, '\0');
  const vsi_l_offset last = length > kPiece ? length - kPiece : 0;
  for (const vsi_l_offset from : {vsi_l_offset{0}, last / 2, last}) {
    if (VSIFSeekL(file.get(), from, SEEK_SET) != 0) return "";
    seen.append(piece, 0, VSIFReadL(piece.data(), 1, kPiece, file.get()));
  }
  quiet.ThrowFaults();
  return Digest(seen);
}

std::string DigestOfContents(const std::string& path) {
  return std::filesystem::exists(path) ? Digest(ReadFile(path)) : "";
}

std::string DigestOfRaster(const std::string& path) {
  RegisterGdalDrivers();
  std::set<std::string> files;
  const QuietGdal quiet;
  CollectFiles(path, &files);
  if (files.empty()) return "";
  std::string seen;
  for (const std::string& file : files) {
    VSIStatBufL status{};
    seen += DigestOfFile(file);
    if (VSIStatL(file.c_str(), &status) == 0) seen += " " + std::to_string(status.st_mtime);
    seen += '\n';
  }
  return Digest(seen);
}

std::string DigestOfCamera(const CameraFile& camera) {
  Inputs parts = {{"file", Digest(CameraFileText(camera, "/"))}};
  for (const auto& [name, drawing] : camera.marks)
    if (drawing.image) parts["picture of " + name] = DigestOfFile(drawing.image->path);
  return DigestOf(parts);
}

std::string TextOf(const OrientationRow* row) {
  if (row == nullptr) return "";
  std::string text = row->attitude_known ? "" : "position alone ";
  const Vector6d sigma = row->sigma.value_or(Vector6d::Zero());
  for (int i = 0; i < 6; ++i)
    // Rounded: what is read from a file is not what was written to the last bit.
    text += fmt::format("{:.9f} {:.9f} ", row->pose.AsVector()[i], sigma[i]);
  if (!row->sigma && row->least_height_sigma_m > 0)
    text += fmt::format("height {:.9f} ", row->least_height_sigma_m);
  return text;
}

std::string DigestOfOptions(const interior::InteriorOptions& options) {
  std::string text = options.pixel_size_um ? fmt::format("{:.9g}", *options.pixel_size_um) : "-";
  text += OrNone(options.polarity) + OrNone(options.orientation);
  text += OrNone(options.scanner) + OrNone(options.locator);
  if (options.assignment == interior::AssignmentMethod::kSoftassign) text += " softassign";
  return Digest(text);
}

}  // namespace orient::block
