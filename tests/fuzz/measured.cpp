// Measurement files of other programs: accepted measurements can be written and read again.
#include <filesystem>

#include "core/exchange/measured_files.h"
#include "core/measurements/written_measurements.h"
#include "tests/fuzz/reader.h"

namespace orient::fuzz {
namespace {

Reader ReaderOf(MeasuredFormat format) {
  return [=](Input input) {
    GatheredMeasurements all;
    AddMeasuredFile(FileWith("measured/file", Text(input)), format, {.image = 0.5}, &all);
    const std::string folder = Folder() + "/written";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    WriteMeasurements(folder, all.All());
    const auto again = Accepted([&] { return ReadMeasurements(folder); });
    Require(again && again->image_points.size() == all.All().image_points.size() &&
                again->points.size() == all.All().points.size(),
            "measurements are as many again");
  };
}

const Register kMetashape("measured_metashape", ReaderOf(MeasuredFormat::kMetashape));
const Register kMicmac("measured_micmac", ReaderOf(MeasuredFormat::kMicmac));
const Register kPatb("measured_patb", ReaderOf(MeasuredFormat::kPatb));
const Register kBingo("measured_bingo", ReaderOf(MeasuredFormat::kBingo));
const Register kCsv("measured_csv", ReaderOf(MeasuredFormat::kCsv));

}  // namespace
}  // namespace orient::fuzz
