// Are marks found and measured equally well if their strokes are about one pixel wide, sharpened or
// faint?
//
//   interior_strokes SCANS [--read-as CAMERA] [--scanner plain|sharpened|faint] [--stroke PX]
//                    [CAMERA...]
//
// Simulates SCANS scans per case (always the same ones) of cameras in the library, by default all
// whose marks have strokes (not only dots, squares or notches), without reseaus and cameras known
// by their format only, which have similar marks elsewhere: strokes of 0.6 to 4 pixels; scanners
// that blur by 0.3 to 1 pixel, sharpen, or show the marks with a contrast of only three sigma of
// the grain. Prints the share of `ok` scans, how many of these are wrong (a mark off by more than
// 1.5 pixels, or wrong polarity), the share of marks used, their RMS error and normalised errors,
// and the share of coordinates off by more than three sigmas.
// --read-as: the scans are read with the file of another camera, whose marks look different or are
// in other positions.
#include <gdal_priv.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <map>
#include <random>
#include <set>

#include "block/inputs/camera_library.h"
#include "block/inputs/mark_shapes.h"
#include "core/base/error.h"
#include "core/base/side_by_side.h"
#include "core/files/mark_painting.h"
#include "core/raster/resample.h"
#include "interior/interior.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kStrokes_px[] = {0.6, 0.8, 1.0, 1.3, 2, 4};
constexpr double kGrain = 4, kDark = 18, kBright = 200;  // grey values
// Marks within the picture cover it; they are brighter than its mean by at most kInPicture.
constexpr double kPictureMean = 88, kInPicture = 50;
constexpr int kFine = 15;          // samples per pixel and axis: fewer cause noise at stroke edges
constexpr double kSeenMm = 11;     // rendered around a mark; the rest of the film is uniform
constexpr double kDarkMm = 6;      // dark around a mark outside the picture
constexpr double kWrong_px = 1.5;  // at a mark

struct Scanning {
  const char* name;
  double sharpening;  // of the difference from a Gaussian mean of one pixel
  double contrast;    // of the marks, grey values
};
constexpr Scanning kScannings[] = {
    {"plain", 0, kBright - kDark}, {"sharpened", 1, kBright - kDark}, {"faint", 0, 3 * kGrain}};

struct Case {
  const block::LibraryCamera* camera;
  const block::LibraryCamera* read_as;
  double stroke_px;
  Scanning scanning;
  double reach_mm = 0;  // of the largest mark
};

struct Tally {
  int scans = 0, ok = 0, wrong = 0, marks = 0, used = 0, coordinates = 0, beyond = 0;
  double squares = 0, normalised = 0;

  void Add(const Tally& other) {
    scans += other.scans;
    ok += other.ok;
    wrong += other.wrong;
    marks += other.marks;
    used += other.used;
    coordinates += other.coordinates;
    beyond += other.beyond;
    squares += other.squares;
    normalised += other.normalised;
  }
};

double Lattice(int x, int y, unsigned seed) {
  unsigned h = seed * 374761393u + static_cast<unsigned>(x) * 668265263u +
               static_cast<unsigned>(y) * 2246822519u;
  h = (h ^ (h >> 13)) * 1274126177u;
  return static_cast<double>((h ^ (h >> 16)) & 0xffffu) / 65535.0;
}

double SmoothNoise(const Vector2d& at, unsigned seed) {
  const Vector2d low = at.array().floor(), part = at - low;
  const int x = static_cast<int>(low.x()), y = static_cast<int>(low.y());
  const double top = (1 - part.x()) * Lattice(x, y, seed) + part.x() * Lattice(x + 1, y, seed);
  const double below =
      (1 - part.x()) * Lattice(x, y + 1, seed) + part.x() * Lattice(x + 1, y + 1, seed);
  return (1 - part.y()) * top + part.y() * below;
}

// Fields, and texture of 6 to 0.2 mm in them.
double Picture(const Vector2d& mm, unsigned seed) {
  double value = 40 + 30 * Lattice(static_cast<int>(std::floor(mm.x() / 2.3)),
                                   static_cast<int>(std::floor(mm.y() / 1.7)), seed + 991u);
  double amplitude = 20;
  for (double size = 6; size > 0.15; size /= 2, amplitude *= 0.75)
    value += amplitude * SmoothNoise(mm / size, seed++);
  return value;
}

// Share of each pixel around the mark that its strokes cover, through the scanner's optics. Samples
// are at random positions in their cells: a grid would render the edge of a stroke in steps.
Image Strokes(const MarkDrawing& drawing, const Matrix2d& mm_from_pixel, const Vector2d& mark,
              int size, double blur_px, std::mt19937* random) {
  std::uniform_real_distribution<double> in_cell(0, 1);
  Image fine(size * kFine, size * kFine);
  std::vector<Vector2d> points(static_cast<size_t>(fine.width));
  std::vector<float> values(points.size());
  for (int row = 0; row < fine.height; ++row) {
    for (int col = 0; col < fine.width; ++col)
      points[static_cast<size_t>(col)] =
          mm_from_pixel * (Vector2d(col + in_cell(*random), row + in_cell(*random)) / kFine - mark);
    std::fill(values.begin(), values.end(), 0.0f);
    for (const MarkElement& element : drawing.elements) Paint(element, points, &values);
    std::copy(values.begin(), values.end(), fine.Row(row));
  }
  return ReduceBy(GaussianBlur(fine, blur_px * kFine), kFine);
}

struct Film {
  Image scan;
  Affine2d pixel_from_photo;
  std::vector<Vector2d> marks;  // pixels
};

// Simulates the scanner: adds grain, and sharpens.
void Scan(const Scanning& scanning, std::mt19937* random, Image* window) {
  std::normal_distribution<float> grain(0, kGrain);
  for (float& value : window->values) value += grain(*random);
  if (scanning.sharpening == 0) return;
  const Image mean = GaussianBlur(*window, 1);
  for (size_t i = 0; i < mean.values.size(); ++i)
    window->values[i] +=
        static_cast<float>(scanning.sharpening) * (window->values[i] - mean.values[i]);
}

Image Window(const Case& what, const MarkDrawing& drawing, const Vector2d& mark_mm,
             const Affine2d& photo_from_pixel, const Vector2d& mark, int size, double blur_px,
             unsigned seed, std::mt19937* random) {
  const double pixel_mm = std::sqrt(std::abs(photo_from_pixel.A.determinant()));
  const int half = static_cast<int>(what.reach_mm / pixel_mm + 4 * blur_px) + 2;
  const Vector2d corner = mark.array().round() - half;
  const int left = static_cast<int>(corner.x()), top = static_cast<int>(corner.y());
  const Image strokes =
      Strokes(drawing, photo_from_pixel.A, mark - corner, 2 * half, blur_px, random);
  const bool in_picture = drawing.background == MarkBackground::kImage;
  const auto contrast =
      static_cast<float>(std::min(what.scanning.contrast, in_picture ? kInPicture : kBright));
  Image window(size, size);
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < size; ++col) {
      const Vector2d mm = photo_from_pixel.A * (Vector2d(col + 0.5, row + 0.5) - mark) + mark_mm;
      const bool dark =
          (!in_picture && (mm - mark_mm).norm() < kDarkMm) || !what.camera->file.camera.InFrame(mm);
      window.At(col, row) = static_cast<float>(dark ? kDark : Picture(mm, seed));
    }
  for (int row = 0; row < strokes.height; ++row)
    for (int col = 0; col < strokes.width; ++col) {
      float& value = window.At(col + left, row + top);
      const float full =
          in_picture ? static_cast<float>(kPictureMean) + contrast - value : contrast;
      value += strokes.At(col, row) * full;
    }
  return window;
}

Film MakeFilm(const Case& what, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.5, 0.5), turn(-0.01, 0.01), blur(0.3, 1);
  const CameraFile& camera = what.camera->file;
  double stroke_mm = 1;
  for (const auto& [name, shape] : what.camera->shapes)
    stroke_mm = std::min(stroke_mm, interior::ThinnestStroke(shape));
  const double pixel_mm = stroke_mm / what.stroke_px, blur_px = blur(random);
  const Vector2d size = (camera.camera.frame_mm + Vector2d(14, 14)) / pixel_mm;
  Film film{Image(static_cast<int>(size.x()), static_cast<int>(size.y()), kDark), {}, {}};
  film.pixel_from_photo.A = Eigen::Rotation2Dd(turn(random)).toRotationMatrix() *
                            Vector2d(1 / pixel_mm, -1 / pixel_mm).asDiagonal();
  film.pixel_from_photo.t = 0.5 * size + 6 * Vector2d(shift(random), shift(random)) -
                            film.pixel_from_photo.A * camera.camera.frame_centre_mm;
  for (const Fiducial& f : camera.fiducials) {
    film.marks.push_back(film.pixel_from_photo * f.position_mm);
    const Vector2d corner = (film.marks.back().array() - kSeenMm / pixel_mm).round();
    const int side = 2 * static_cast<int>(kSeenMm / pixel_mm);
    Image window =
        Window(what, camera.marks.at(f.mark), f.position_mm, film.pixel_from_photo.Inverse(),
               film.marks.back() - corner, side, blur_px, seed, &random);
    Scan(what.scanning, &random, &window);
    for (int row = 0; row < side; ++row)
      for (int col = 0; col < side; ++col) {
        const int c = col + static_cast<int>(corner.x()), r = row + static_cast<int>(corner.y());
        if (c >= 0 && r >= 0 && c < film.scan.width && r < film.scan.height)
          film.scan.At(c, r) = std::clamp(std::round(window.At(col, row)), 0.0f, 255.0f);
      }
  }
  return film;
}

std::string WriteInMemory(const Image& scan, unsigned number) {
  const std::string path = "/vsimem/scan_" + std::to_string(number) + ".tif";
  const std::vector<unsigned char> bytes(scan.values.begin(), scan.values.end());
  GDALDriver* tiff = GetGDALDriverManager()->GetDriverByName("GTiff");
  const GDALDatasetUniquePtr file(
      tiff->Create(path.c_str(), scan.width, scan.height, 1, GDT_Byte, nullptr));
  if (!file ||
      file->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, scan.width, scan.height,
                                       const_cast<unsigned char*>(bytes.data()), scan.width,
                                       scan.height, GDT_Byte, 0, 0, nullptr) != CE_None)
    throw InputError(path + ": cannot be written");
  return path;
}

// Largest error at a mark, px; the smallest over the possible scan orientations.
double TransformError(const Film& film, const InteriorResult& found, const Case& what) {
  double least = 1e9;
  for (const ScanOrientation way : found.possible_orientations) {
    const auto turned =
        interior::InOrientation(found, what.read_as->file, what.read_as->shapes, way);
    if (!turned) continue;
    const Affine2d pixel_from_photo = turned->photo_from_pixel->Inverse();
    double most = 0;
    for (size_t i = 0; i < film.marks.size(); ++i)
      most = std::max(
          most,
          (pixel_from_photo * what.camera->file.fiducials[i].position_mm - film.marks[i]).norm());
    least = std::min(least, most);
  }
  return least;
}

void CountMark(const MarkResult& mark, const Film& film, Tally* tally) {
  ++tally->marks;
  if (mark.state != MarkState::kUsed) return;
  ++tally->used;
  Vector2d error = Vector2d::Constant(1e9);
  for (const Vector2d& truth : film.marks)
    if ((*mark.pixel - truth).norm() < error.norm()) error = *mark.pixel - truth;
  const Vector2d normalised = error.cwiseQuotient(*mark.sigma_px);
  tally->coordinates += 2;
  tally->beyond += static_cast<int>((normalised.array().abs() > 3).count());
  tally->squares += error.squaredNorm();
  tally->normalised += normalised.squaredNorm();
}

Tally Orient(const Case& what, unsigned seed) {
  const Film film = MakeFilm(what, seed);
  const std::string path = WriteInMemory(film.scan, seed);
  interior::InteriorOptions options;
  options.pixel_size_um = 1e3 / std::sqrt(std::abs(film.pixel_from_photo.A.determinant()));
  const InteriorResult found = interior::OrientInterior(Raster::Open(path), what.read_as->file,
                                                        what.read_as->shapes, options);
  VSIUnlink(path.c_str());
  Tally tally;
  tally.scans = 1;
  if (std::getenv("ORIENT_VERBOSE") != nullptr && found.status != Status::kOk)
    for (const std::string& sentence : Sentences(found.findings))
      std::cout << "  " << seed << ": " << sentence << "\n";
  for (const MarkResult& mark : found.marks) CountMark(mark, film, &tally);
  if (found.status != Status::kOk) return tally;
  tally.ok = 1;
  tally.wrong =
      TransformError(film, found, what) > kWrong_px || found.polarity != Polarity::kPositive;
  return tally;
}

void Print(const std::string& camera, const std::string& scanning, double stroke_px,
           const Tally& t) {
  const double coordinates = std::max(t.coordinates, 1);
  std::printf("%-22s %-10s %6.1f %7.1f %6d %8.1f %8.4f %10.2f %9.2f\n", camera.c_str(),
              scanning.c_str(), stroke_px, 100.0 * t.ok / t.scans, t.wrong,
              100.0 * t.used / t.marks, std::sqrt(t.squares / coordinates),
              std::sqrt(t.normalised / coordinates), 100 * t.beyond / coordinates);
  std::fflush(stdout);
}

Tally OrientAll(const Case& what, int scans) {
  std::vector<Tally> each(static_cast<size_t>(scans));
  SideBySide(each.size(), [&](size_t i) { each[i] = Orient(what, static_cast<unsigned>(i + 1)); });
  Tally all;
  for (const Tally& one : each) all.Add(one);
  return all;
}

bool HasStrokes(const MarkElement& element) {
  return std::holds_alternative<CrossElement>(element) ||
         std::holds_alternative<CircleElement>(element) ||
         std::holds_alternative<LineElement>(element);
}

bool AllMarksHaveStrokes(const CameraFile& camera) {
  return std::all_of(camera.marks.begin(), camera.marks.end(), [](const auto& mark) {
    const auto& elements = mark.second.elements;
    return std::any_of(elements.begin(), elements.end(), HasStrokes);
  });
}

// Whether the camera was named or, without names, is one of the default ones.
bool IsAsked(const block::LibraryCamera& camera, const std::set<std::string>& names) {
  const bool strokes = AllMarksHaveStrokes(camera.file);
  if (names.empty()) return !camera.format_only && camera.file.fiducials.size() <= 12 && strokes;
  if (!names.contains(camera.name)) return false;
  if (!strokes) throw InputError(camera.name + " has marks without strokes");
  return true;
}

// What the command line asks for; all where it names nothing.
struct Asked {
  int scans = 0;
  std::string read_as, scanner;
  double stroke_px = 0;
  std::set<std::string> cameras;
};

Asked Parse(const std::vector<std::string>& words) {
  Asked asked;
  asked.scans = std::stoi(words.at(0));
  if (asked.scans < 1) throw InputError(words[0] + " scans: at least 1 is needed");
  for (size_t i = 1; i < words.size(); ++i) {
    const auto value = [&]() -> const std::string& {
      if (i + 1 == words.size()) throw InputError(words[i] + " needs a value");
      return words[++i];
    };
    if (words[i] == "--read-as") {
      asked.read_as = value();
    } else if (words[i] == "--scanner") {
      asked.scanner = value();
    } else if (words[i] == "--stroke") {
      asked.stroke_px = std::stod(value());
    } else if (words[i].starts_with("--")) {
      throw InputError("no option " + words[i]);
    } else {
      asked.cameras.insert(words[i]);
    }
  }
  return asked;
}

int Run(const Asked& asked) {
  GDALAllRegister();
  std::printf("%-22s %-10s %6s %7s %6s %8s %8s %10s %9s\n", "camera", "scanner", "stroke", "ok, %",
              "wrong", "marks, %", "rms, px", "normalised", "> 3 s, %");
  const auto library = block::ReadCameraLibrary(block::CameraLibraryFolder(""));
  const auto reader = std::find_if(library.begin(), library.end(), [&](const auto& camera) {
    return camera.name == asked.read_as;
  });
  if (!asked.read_as.empty() && reader == library.end())
    throw InputError("no camera " + asked.read_as + " in the library");
  std::map<std::pair<std::string, double>, Tally> total;
  for (const block::LibraryCamera& camera : library) {
    if (camera.name == asked.read_as || !IsAsked(camera, asked.cameras)) continue;
    double reach_mm = 0;
    for (const auto& [name, shape] : camera.shapes)
      reach_mm = std::max(reach_mm, interior::MarkRadius(shape));
    for (const Scanning& scanning : kScannings)
      for (const double stroke_px : kStrokes_px) {
        if (!asked.scanner.empty() && asked.scanner != scanning.name) continue;
        if (asked.stroke_px > 0 && asked.stroke_px != stroke_px) continue;
        const Tally tally = OrientAll(
            {&camera, asked.read_as.empty() ? &camera : &*reader, stroke_px, scanning, reach_mm},
            asked.scans);
        Print(camera.name, scanning.name, stroke_px, tally);
        total[{scanning.name, stroke_px}].Add(tally);
      }
  }
  if (total.empty()) throw InputError("nothing of what was asked for exists");
  for (const auto& [key, tally] : total) Print("all", key.first, key.second, tally);
  return 0;
}

}  // namespace
}  // namespace orient

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr
        << "usage: interior_strokes SCANS [--read-as CAMERA] [--scanner plain|sharpened|faint]"
           " [--stroke PX] [CAMERA...]\n";
    return 1;
  }
  try {
    return orient::Run(orient::Parse({argv + 1, argv + argc}));
  } catch (const std::exception& error) {
    std::cerr << "interior_strokes: " << error.what() << "\n";
    return 2;
  }
}
