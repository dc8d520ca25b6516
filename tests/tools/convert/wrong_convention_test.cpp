// Exports that somebody changed to another convention: what is named, and what is not.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/exchange/colmap.h"
#include "tests/support/shared_data.h"
#include "tests/tools/convert/two_photos.h"
#include "tools/convert/check_exports.h"
#include "tools/convert/export_record.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

class WrongConvention : public testing::Test {
 protected:
  // The export of one format, its file changed by `change`.
  ExportCheck Changed(ExchangeFormat format, const std::string& file,
                      const std::function<std::string(const std::string&)>& change) {
    const auto written = WriteExports(TwoPhotos(), {{format}, folder_.Path(), 0, {}}).front();
    const std::string path = (fs::path(written.directory) / file).string();
    const std::string text = ReadFile(path), changed = change(text);
    EXPECT_NE(text, changed) << "the change found nothing to change";
    WriteFileAtomically(path, changed);
    return CheckExport(written.directory, std::nullopt, "");
  }
  static void ExpectNamed(const ExportCheck& check, const std::string& what) {
    EXPECT_FALSE(check.ok);
    ASSERT_TRUE(check.fits) << Verdict(check);
    EXPECT_EQ(check.fits->reading.Count(), 1) << Verdict(check);
    EXPECT_NE(Verdict(check).find(what), std::string::npos) << Verdict(check);
  }

  TemporaryFolder folder_;
};

// A file's lines, changed one after another as words.
std::string ByWords(const std::string& text,
                    const std::function<void(std::vector<std::string>*)>& change) {
  std::istringstream lines(text);
  std::string line, changed;
  while (std::getline(lines, line)) {
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    change(&words);
    for (std::size_t i = 0; i < words.size(); ++i) changed += (i > 0 ? " " : "") + words[i];
    changed += "\n";
  }
  return changed;
}

// Not wrong: PAT-B files have it in either unit.
TEST_F(WrongConvention, APrincipalDistanceInMicrometresIsUnderstood) {
  const ExportCheck check = Changed(ExchangeFormat::kPatb, "patb.ori", [](const std::string& text) {
    return ByWords(text, [](std::vector<std::string>* words) {
      if (words->size() == 5 && words->front().find('.') == std::string::npos)
        words->at(1) = std::to_string(std::stod(words->at(1)) * 1000);
    });
  });
  EXPECT_TRUE(check.ok) << Verdict(check);
}

TEST_F(WrongConvention, AnglesInDegreesForGon) {
  ExpectNamed(Changed(ExchangeFormat::kBingo, "itera.dat",
                      [](const std::string& text) {
                        return ByWords(text, [](std::vector<std::string>* words) {
                          for (std::size_t i = 5; i < words->size(); ++i)
                            (*words)[i] = ExactNumber(std::stod((*words)[i]) * 0.9);
                        });
                      }),
              "other unit");
}

TEST_F(WrongConvention, AngleOrder) {
  // The angles of the same rotations in the order phi, omega, kappa.
  const ConvertSource source = TwoPhotos();
  ExpectNamed(Changed(ExchangeFormat::kBingo, "itera.dat",
                      [&](const std::string& text) {
                        std::size_t photo = 0;
                        return ByWords(text, [&](std::vector<std::string>* words) {
                          const Eigen::Matrix3d r = source.block.photos[photo++].ground_from_photo;
                          const double omega = std::asin(-r(1, 2));
                          const double phi = std::atan2(r(0, 2), r(2, 2));
                          const double kappa = std::atan2(r(1, 0), r(1, 1));
                          const double gon = 200 / 3.14159265358979323846;
                          (*words)[5] = ExactNumber(omega * gon);
                          (*words)[6] = ExactNumber(phi * gon);
                          (*words)[7] = ExactNumber(kappa * gon);
                        });
                      }),
              "phi, omega, kappa");
}

TEST_F(WrongConvention, TransposedRotation) {
  ExpectNamed(Changed(ExchangeFormat::kPatb, "patb.ori",
                      [](const std::string& text) {
                        std::istringstream stream(text);
                        std::vector<std::string> w;
                        for (std::string word; stream >> word;) w.push_back(word);
                        std::string changed;
                        for (std::size_t i = 0; i + 13 < w.size(); i += 14) {
                          // Number, principal distance, X Y Z, then a11 ... a33.
                          for (std::size_t j = 0; j < 5; ++j) changed += w[i + j] + " ";
                          changed += "\n";
                          for (const std::size_t j : {0, 3, 6, 1, 4}) changed += w[i + 5 + j] + " ";
                          changed += "\n";
                          for (const std::size_t j : {7, 2, 5, 8}) changed += w[i + 5 + j] + " ";
                          changed += "\n";
                        }
                        return changed;
                      }),
              "transposed");
}

TEST_F(WrongConvention, CornerForCentre) {
  ExpectNamed(Changed(ExchangeFormat::kColmap, "cameras.txt",
                      [](const std::string& text) {
                        return ByWords(text, [](std::vector<std::string>* words) {
                          if ((*words)[0] == "#") return;
                          for (const std::size_t i : {6, 7})
                            (*words)[i] = ExactNumber(std::stod((*words)[i]) - 0.5);
                        });
                      }),
              "half a pixel too small");
}

TEST_F(WrongConvention, PrincipalPointsSign) {
  ExpectNamed(Changed(ExchangeFormat::kOpensfm, "reconstruction.json",
                      [](const std::string& text) {
                        return ByWords(text, [](std::vector<std::string>* words) {
                          if ((*words)[0] != "\"c_x\":" && (*words)[0] != "\"c_y\":") return;
                          (*words)[1] = ExactNumber(-std::stod((*words)[1])) + ",";
                        });
                      }),
              "other sign");
}

// Metashape's transform as a program writes it whose cameras look along -z, y up.
TEST_F(WrongConvention, CamerasAxesUp) {
  ExpectNamed(Changed(ExchangeFormat::kMetashape, "cameras.xml",
                      [](const std::string& text) {
                        return ByWords(text, [](std::vector<std::string>* words) {
                          const std::string tag = "<transform>";
                          if (words->size() != 16 || !words->front().starts_with(tag)) return;
                          for (const std::size_t i : {1, 2, 5, 6, 9, 10})
                            (*words)[i] = ExactNumber(-std::stod((*words)[i]));
                        });
                      }),
              "y up");
}

TEST_F(WrongConvention, RowsForColumns) {
  const auto written =
      WriteExports(TwoPhotos(), {{ExchangeFormat::kMicmac}, folder_.Path(), 0, {}}).front();
  const std::string path = (fs::path(written.directory) / "verification.csv").string();
  auto rows = ReadVerification(path);
  for (VerificationRow& row : rows) std::swap(row.pixel.x(), row.pixel.y());
  WriteVerification(written.directory, rows);
  ExpectNamed(CheckExport(written.directory, std::nullopt, ""), "rows and columns");
}

TEST_F(WrongConvention, AnotherPoseIsNoConvention) {
  const ExportCheck check =
      Changed(ExchangeFormat::kBingo, "itera.dat", [](const std::string& text) {
        return ByWords(text, [](std::vector<std::string>* words) {
          (*words)[5] = ExactNumber(std::stod((*words)[5]) + 0.3);
        });
      });
  EXPECT_FALSE(check.ok);
  EXPECT_FALSE(check.fits) << Verdict(check);
  EXPECT_NE(Verdict(check).find("no known convention"), std::string::npos) << Verdict(check);
}

// Files without verification points: COLMAP's own, of photos whose points were measured.
TEST(OwnMeasurements, ImagesWhosePosesDoNotFitAreNamed) {
  const TemporaryFolder folder;
  ConvertSource source = TwoPhotos();
  source.block.points.clear();
  for (int i = 0; i < 30; ++i) {
    ExchangePoint point{
        std::to_string(i), false, {500300.0 + 20 * i, 5000200.0 + 15 * (i % 7), 310.0 + i}, {}};
    for (const std::size_t photo : {0u, 1u})
      if (const auto pixel = PixelFromGround(source.block, photo, point.ground))
        point.observations.push_back({photo, *pixel});
    source.block.points.push_back(point);
  }
  ExchangePhoto idle = source.block.photos[0];
  idle.image = "4713.tif";
  source.block.photos.push_back(idle);
  WriteColmap(folder.Path(), source.block);
  const ExportCheck good = CheckExport(folder.Path(), ExchangeFormat::kColmap, "");
  EXPECT_TRUE(good.ok) << Verdict(good);
  EXPECT_EQ(good.unchecked, std::vector<std::string>{"4713.tif"}) << Verdict(good);
  source.block.photos[1].centre.x() += 30;
  WriteColmap(folder.Path(), source.block);
  const ExportCheck bad = CheckExport(folder.Path(), ExchangeFormat::kColmap, "");
  EXPECT_FALSE(bad.ok) << Verdict(bad);
  EXPECT_EQ(bad.off, std::vector<std::string>{"4712.tif"}) << Verdict(bad);
}

}  // namespace
}  // namespace orient
