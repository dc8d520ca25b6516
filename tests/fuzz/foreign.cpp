// Files of other programs.
#include <Eigen/Dense>
#include <filesystem>

#include "tests/fuzz/reader.h"
#include "tools/convert/foreign_block.h"

namespace orient::fuzz {
namespace {

// The parts of an input become the files of a folder, in this order; the last ones may be missing.
Reader ReaderOf(ExchangeFormat format, const std::vector<std::string>& files) {
  return [=](Input input) {
    const std::string folder = Name(format);
    const auto parts = Parts(input);
    for (std::size_t i = 0; i < files.size(); ++i) {
      const std::string path = FileWith(folder + "/" + files[i], i < parts.size() ? parts[i] : "");
      if (i >= parts.size()) std::filesystem::remove(path);
    }
    const ForeignBlock foreign = ReadForeignBlock(format, Folder() + "/" + folder, {}, {});
    for (const ExchangePhoto& photo : foreign.block.photos) {
      Require(photo.camera < foreign.block.cameras.size(), photo.image + " has a camera");
      Require(PoseOf(photo).AsVector().allFinite(), photo.image + " has a pose");
      const double determinant = photo.ground_from_photo.determinant();
      Require(std::abs(determinant - 1) < 1e-3, photo.image + " has a rotation");
    }
    for (const ExchangeCamera& camera : foreign.block.cameras) {
      Require(camera.focal_px.allFinite() && camera.principal_px.allFinite(), "a camera");
      if (camera.width > 0) Accepted([&] { return CameraOf(camera); });
    }
  };
}

const Register kOri("ori", ReaderOf(ExchangeFormat::kOri, {"orientation.ori"}));
const Register kPatb("patb", ReaderOf(ExchangeFormat::kPatb, {"patb.ori", "photo_numbers.txt"}));
const Register kBingo("bingo",
                      ReaderOf(ExchangeFormat::kBingo, {"itera.dat", "photo_numbers.txt"}));
const Register kMicmac("micmac", ReaderOf(ExchangeFormat::kMicmac,
                                          {"Orientation-1.tif.xml", "AutoCal_Foc-1000_Cam-A.xml",
                                           "Orientation-2.tif.xml"}));
const Register kMetashape("metashape", ReaderOf(ExchangeFormat::kMetashape, {"cameras.xml"}));
const Register kColmap("colmap", ReaderOf(ExchangeFormat::kColmap, {"images.txt", "cameras.txt"}));
const Register kOpensfm("opensfm", ReaderOf(ExchangeFormat::kOpensfm,
                                            {"reconstruction.json", "reference_lla.json"}));
const Register kAsp("asp", ReaderOf(ExchangeFormat::kAsp, {"1.tsai", "2.tsai"}));

}  // namespace
}  // namespace orient::fuzz
