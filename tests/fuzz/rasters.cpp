// Rasters: scans, DEMs, templates of marks, chips of patches.
#include <gdal_priv.h>
#include <libdeflate.h>

#include <array>
#include <cmath>

#include "block/inputs/exposure_date.h"
#include "block/inputs/mark_shapes.h"
#include "block/inputs/photo_metadata.h"
#include "core/raster/colour_raster.h"
#include "core/raster/png_bands.h"
#include "core/raster/raster.h"
#include "core/terrain/ground_surface.h"
#include "tests/fuzz/reader.h"
#include "tools/report/picture.h"

namespace orient::fuzz {
namespace {

bool Same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

// The pixels of a window must be those of the whole image.
void RequirePartOf(const Image& whole, const PixelWindow& part, const Image& seen) {
  for (int row = 0; row < seen.height; ++row)
    for (int col = 0; col < seen.width; ++col) {
      const int c = col + part.col, r = row + part.row;
      const bool inside = c >= 0 && r >= 0 && c < whole.width && r < whole.height;
      Require(Same(seen.At(col, row), inside ? whole.At(c, r) : kNoData), "a window of an image");
    }
}

// The first bytes select the window and the reduction to be read from the file that follows.
const Register kRaster("raster", [](Input input) {
  constexpr int kSmall = 1 << 16;
  Values values(input);
  const PixelWindow window{values.Take<std::int16_t>(), values.Take<std::int16_t>(),
                           1 + values.Take<std::uint8_t>() % 64,
                           1 + values.Take<std::uint8_t>() % 64};
  const double reduction = 1 + values.Take<std::uint8_t>() / 16.0;
  const std::string path = MemoryFileWith("photo.tif", values.Rest());
  block::ReadPhotoMetadata(path);
  block::ExposureDate(path, CameraKind::kDigital);
  const Raster raster = Raster::OpenScan(path);
  raster.BitsPerSample();
  raster.GeoTransform();
  raster.CrsWkt();
  raster.DpiTag();
  Accepted([&] { return raster.ReadGrey(window, reduction); });
  if (std::int64_t{raster.Width()} * raster.Height() <= kSmall)
    if (const auto whole = Accepted([&] { return raster.ReadGrey(); }))
      RequirePartOf(whole->image, window, raster.ReadGrey(window).image);
  if (const auto colour = ColourRaster::Open(path)) colour->Read(window);
});

// An Arc/Info ASCII grid or any other format: GDAL inspects the content. The CRS is beside it.
const Register kDem("dem", [](Input input) {
  static const Crs crs = Crs::Parse("EPSG:32635", "the fuzzer");
  static const std::string wkt = crs.Wkt1();
  MemoryFileWith("dem.prj", {reinterpret_cast<const std::uint8_t*>(wkt.data()), wkt.size()});
  const std::string path = MemoryFileWith("dem.asc", input);
  const Bounds bounds = {499000, 4999000, 502000, 5002000};
  for (const std::optional<Bounds>& part : {std::optional<Bounds>(), std::optional(bounds)})
    Accepted([&] {
      const GroundSurface surface = GroundSurface::FromFile(path, crs, part);
      const Bounds extent = surface.Extent();
      const Eigen::Vector3d centre((extent.min_x + extent.max_x) / 2,
                                   (extent.min_y + extent.max_y) / 2, surface.MaxHeight() + 1000);
      const auto height = surface.HeightAt(centre.x(), centre.y());
      Require(!height ||
                  (*height >= surface.MinHeight() - 0.01 && *height <= surface.MaxHeight() + 0.01),
              "a height between the lowest and the highest");
      surface.Intersect({centre, Eigen::Vector3d(0.3, 0.2, -1).normalized()});
      return true;
    });
});

const Register kPicture("picture", [](Input input) {
  const std::string path = MemoryFileWith("mark.png", input);
  CameraFile camera;
  camera.marks["picture"].image = MarkImage{path, 0.02, Eigen::Vector2d(2, 2)};
  const auto shapes = Accepted([&] { return block::LoadMarkShapes(camera); });
  if (shapes) {
    interior::RenderOptions options;
    interior::RenderMark(shapes->at("picture"), Eigen::Vector2d(50, -50).asDiagonal(), options);
  }
  LoadPicture(path);
});

// A PNG chunk: length, type, data, checksum.
void AddChunk(const char* type, Input data, std::vector<unsigned char>* png) {
  const auto add = [png](std::uint32_t number) {
    for (int shift = 24; shift >= 0; shift -= 8)
      png->push_back(static_cast<unsigned char>(number >> shift));
  };
  add(static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = png->size();
  png->insert(png->end(), type, type + 4);
  png->insert(png->end(), data.begin(), data.end());
  add(libdeflate_crc32(0, png->data() + begin, png->size() - begin));
}

// A PNG with correct checksums around an arbitrary header and rows.
std::vector<unsigned char> Wrapped(Values values) {
  std::vector<unsigned char> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const bool small = values.Below(8) != 0;
  std::array<std::uint8_t, 13> header{};
  const Input given = values.Bytes(header.size());
  std::copy(given.begin(), given.end(), header.begin());
  if (small)
    for (const std::size_t byte : {0, 1, 2, 4, 5, 6, 10, 11, 12}) header[byte] = 0;
  AddChunk("IHDR", header, &png);
  const std::size_t pieces = 1 + values.Below(3), packing = values.Below(13);
  const Input rows = values.Rest();
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> packer(
      libdeflate_alloc_compressor(static_cast<int>(packing)), libdeflate_free_compressor);
  std::vector<std::uint8_t> packed(libdeflate_zlib_compress_bound(packer.get(), rows.size()));
  packed.resize(libdeflate_zlib_compress(packer.get(), rows.data(), rows.size(), packed.data(),
                                         packed.size()));
  for (std::size_t i = 0; i < pieces; ++i) {
    const std::size_t begin = packed.size() * i / pieces, end = packed.size() * (i + 1) / pieces;
    AddChunk("IDAT", Input(packed).subspan(begin, end - begin), &png);
  }
  AddChunk("IEND", {}, &png);
  return png;
}

// GDAL, hence libpng, must read the same values if both read the file.
void RequireAsGdalReads(const std::vector<unsigned char>& png, const std::vector<Image>& bands) {
  GDALAllRegister();
  CPLErrorHandlerPusher quiet(CPLQuietErrorHandler);
  const std::string path = MemoryFileWith("chip.png", png);
  const char* const formats[] = {"PNG", nullptr};
  const GDALDatasetUniquePtr gdal(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER, formats));
  if (gdal == nullptr || gdal->GetRasterCount() < static_cast<int>(bands.size())) return;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    Image other(bands[i].width, bands[i].height);
    CPLErrorReset();
    if (gdal->GetRasterBand(static_cast<int>(i) + 1)
                ->RasterIO(GF_Read, 0, 0, other.width, other.height, other.values.data(),
                           other.width, other.height, GDT_Float32, 0, 0) != CE_None ||
        CPLGetLastErrorType() != CE_None)
      return;
    Require(other.values == bands[i].values, "a PNG's values");
  }
}

// The first byte determines whether the rest is a PNG or is to be packed as one.
const Register kPng("png", [](Input input) {
  Values values(input);
  const bool as_it_is = values.Below(2) == 0;
  const std::vector<unsigned char> png =
      as_it_is ? std::vector<unsigned char>(values.Rest().begin(), values.Rest().end())
               : Wrapped(values);
  const std::vector<Image> bands = DecodePngBands(png);
  RequireAsGdalReads(png, bands);
});

}  // namespace
}  // namespace orient::fuzz
