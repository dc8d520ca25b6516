#include "block/inputs/photo_metadata.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include "block/inputs/block_approximations.h"
#include "core/base/atomic_write.h"
#include "core/files/block_file.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

TEST(PhotoMetadata, DegreesComeInUpToThreeParts) {
  EXPECT_NEAR(*DegreesOfTag("(51) (30) (36)"), 51.51, 1e-12);
  EXPECT_NEAR(*DegreesOfTag("(51) (30.6) (0)"), 51.51, 1e-12);
  EXPECT_NEAR(*DegreesOfTag("51.51"), 51.51, 1e-12);
  for (const char* tag : {"", "(51) (30) (36) (1)", "north", "(-51)", "(181)"})
    EXPECT_FALSE(DegreesOfTag(tag)) << tag;
}

// A JPEG whose EXIF is written here, byte by byte, as cameras do.
class ExifOfJpeg {
 public:
  void Add(int directory, int tag, int type, const std::string& value, int count) {
    entries_[directory].push_back({tag, type, count, value});
  }
  static std::string Rationals(const std::vector<double>& values) {
    std::string text;
    for (const double value : values)
      text += Bytes(static_cast<unsigned>(value * 1000 + 0.5), 4) + Bytes(1000, 4);
    return text;
  }
  static std::string Bytes(unsigned value, int count) {  // big-endian
    std::string text;
    for (int i = count - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i) & 0xff);
    return text;
  }

  void Write(const std::string& path) {
    const std::string plain = path + ".plain.jpg";
    GDALAllRegister();
    auto* memory = GetGDALDriverManager()->GetDriverByName("MEM");
    const GDALDatasetUniquePtr image(memory->Create("", 16, 16, 1, GDT_Byte, nullptr));
    GDALDatasetUniquePtr(GetGDALDriverManager()->GetDriverByName("JPEG")->CreateCopy(
        plain.c_str(), image.get(), 0, nullptr, nullptr, nullptr));
    const std::string tiff = Tiff();
    const std::string jpeg = ReadFile(plain);
    WriteFileAtomically(path, jpeg.substr(0, 2) + "\xff\xe1" +
                                  Bytes(static_cast<unsigned>(tiff.size()) + 8, 2) +
                                  std::string("Exif\0\0", 6) + tiff + jpeg.substr(2));
  }

 private:
  struct Entry {
    int tag, type, count;
    std::string value;
  };

  // Directory 0 with pointers to the EXIF and the GPS directory behind it.
  std::string Tiff() {
    Add(0, 0x8769, 4, Bytes(8 + 2 + 24 + 4, 4), 1);
    const std::string exif = Directory(entries_[1], 8 + 2 + 24 + 4);
    Add(0, 0x8825, 4, Bytes(static_cast<unsigned>(8 + 2 + 24 + 4 + exif.size()), 4), 1);
    const std::string gps = Directory(entries_[2], 8 + 2 + 24 + 4 + exif.size());
    return std::string("MM\0*\0\0\0\x08", 8) + Directory(entries_[0], 8) + exif + gps;
  }

  static std::string Directory(const std::vector<Entry>& entries, std::size_t at) {
    std::string table = Bytes(static_cast<unsigned>(entries.size()), 2), data;
    const std::size_t behind = at + 2 + 12 * entries.size() + 4;
    for (const Entry& entry : entries) {
      table += Bytes(static_cast<unsigned>(entry.tag), 2) +
               Bytes(static_cast<unsigned>(entry.type), 2) +
               Bytes(static_cast<unsigned>(entry.count), 4);
      if (entry.value.size() <= 4) {
        table += (entry.value + std::string(4, '\0')).substr(0, 4);
      } else {
        table += Bytes(static_cast<unsigned>(behind + data.size()), 4);
        data += entry.value;
      }
    }
    return table + Bytes(0, 4) + data;
  }

  std::vector<Entry> entries_[3];
};

TEST(PhotoMetadata, OfAPhotoIsItsExif) {
  const TemporaryFolder folder;
  ExifOfJpeg exif;
  exif.Add(1, 0x920a, 5, ExifOfJpeg::Rationals({100.5}), 1);  // focal length
  exif.Add(2, 1, 2, std::string("S\0", 2), 2);                // latitude
  exif.Add(2, 2, 5, ExifOfJpeg::Rationals({22, 54, 36}), 3);
  exif.Add(2, 3, 2, std::string("E\0", 2), 2);  // longitude
  exif.Add(2, 4, 5, ExifOfJpeg::Rationals({27, 0, 0}), 3);
  exif.Add(2, 6, 5, ExifOfJpeg::Rationals({1823.5}), 1);  // altitude
  exif.Write(folder / "4711.jpg");
  const PhotoMetadata metadata = ReadPhotoMetadata(folder / "4711.jpg");
  ASSERT_TRUE(metadata.lon_lat_deg && metadata.altitude_m && metadata.focal_length_mm);
  EXPECT_NEAR(metadata.lon_lat_deg->x(), 27, 1e-6);
  EXPECT_NEAR(metadata.lon_lat_deg->y(), -22.91, 1e-6);
  EXPECT_NEAR(*metadata.altitude_m, 1823.5, 1e-3);
  EXPECT_NEAR(*metadata.focal_length_mm, 100.5, 1e-3);
  // The central meridian of zone 35.
  const auto row = LocatedByMetadata("4711", metadata, Crs::Parse("EPSG:32735", "test"));
  ASSERT_TRUE(row);
  EXPECT_NEAR(row->pose.position_m.x(), 500000, 0.1);
  EXPECT_NEAR(row->pose.position_m.z(), 1823.5, 1e-3);
  EXPECT_FALSE(row->attitude_known);
  EXPECT_GT((*row->sigma)[2], (*row->sigma)[0]) << "altitudes are of whatever datum";
}

std::string WithPosition(const TemporaryFolder& folder, const std::string& latitude_ref,
                         const std::string& longitude_ref, double latitude, double longitude,
                         const std::string& status = "A") {
  ExifOfJpeg exif;
  const auto text = [&](int tag, const std::string& value) {
    if (!value.empty()) exif.Add(2, tag, 2, value + std::string(1, '\0'), 2);
  };
  text(1, latitude_ref);
  exif.Add(2, 2, 5, ExifOfJpeg::Rationals({latitude, 0, 0}), 3);
  text(3, longitude_ref);
  exif.Add(2, 4, 5, ExifOfJpeg::Rationals({longitude, 0, 0}), 3);
  exif.Add(2, 6, 5, ExifOfJpeg::Rationals({1500}), 1);
  text(9, status);
  exif.Write(folder / "1.jpg");
  return folder / "1.jpg";
}

TEST(PhotoMetadata, PositionsThatAreNoneAreIgnored) {
  const TemporaryFolder folder;
  const auto has = [&](auto... position) {
    return ReadPhotoMetadata(WithPosition(folder, position...)).lon_lat_deg.has_value();
  };
  EXPECT_TRUE(has("S", "E", 22, 27));
  EXPECT_TRUE(has("N", "W", 0, 27));
  EXPECT_FALSE(has("", "E", 22, 27));
  EXPECT_FALSE(has("S", "", 22, 27));
  EXPECT_FALSE(has("N", "E", 0, 0));
  EXPECT_FALSE(has("S", "E", 22, 27, "V"));
}

TEST(BlockApproximations, FilmIsNotLocatedByTheDeviceThatReproducedIt) {
  const TemporaryFolder folder;
  for (const std::string name : {"patches.gpkg", "camera.toml", "dem.tif"})
    WriteFileAtomically(folder / name, "");
  WithPosition(folder, "S", "E", 22, 27);
  WriteFileAtomically(folder / "block.toml",
                      "crs = \"EPSG:32735\"\ndem = \"dem.tif\"\npatchdb = \"patches.gpkg\"\n"
                      "camera = \"camera.toml\"\nphotos = [\"1.jpg\"]\n");
  const BlockFile block = ReadBlockFile(folder / "block.toml");
  Camera camera;
  camera.principal_distance_mm = 100;
  camera.kind = CameraKind::kDigital;
  const BlockApproximations located(block, camera);
  EXPECT_EQ(located.Table().rows.size(), 1u);
  EXPECT_EQ(located.Remarks(), (Findings{{.reason = Reason::kLocatedByOwnFiles, .value = 1}}));
  camera.kind = CameraKind::kFilm;
  const BlockApproximations film(block, camera);
  EXPECT_TRUE(film.Table().rows.empty());
  EXPECT_TRUE(film.Remarks().empty());
}

TEST(BlockApproximations, AWeakPoseFarFromItsApproximationTeachesNothing) {
  OrientationRow before;
  before.sigma = Vector6d::Constant(10);
  ExteriorResult result;
  result.pose = before.pose;
  result.covariance = Matrix6d::Identity() * 0.01;
  result.status = Status::kWeak;
  EXPECT_TRUE(LocatesStrip(result, &before));
  EXPECT_FALSE(LocatesStrip(result, nullptr));
  result.pose->position_m.x() += 60;
  EXPECT_FALSE(LocatesStrip(result, &before));
  result.status = Status::kOk;
  EXPECT_TRUE(LocatesStrip(result, &before));
  result.pose.reset();
  EXPECT_FALSE(LocatesStrip(result, &before));
}

TEST(PhotoMetadata, OfAFileThatSaysNothingIsNothing) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "4711.tif", "no image");
  for (const char* name : {"4711.tif", "absent.tif"}) {
    const PhotoMetadata metadata = ReadPhotoMetadata(folder / name);
    EXPECT_FALSE(metadata.lon_lat_deg || metadata.altitude_m || metadata.focal_length_mm);
    EXPECT_FALSE(LocatedByMetadata("4711", metadata, Crs::Parse("EPSG:32735", "test")));
  }
}

}  // namespace
}  // namespace orient::block
